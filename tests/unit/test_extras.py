"""Imports from an extra: they succeed, or one line says what to install."""

import importlib
import sys

import pytest

from orbident.errors import InputError
from orbident.extras import MissingLibraryError, extra


def test_what_is_installed_is_imported():
    with extra("view", "the viewer"):
        import trimesh
    assert trimesh.__name__ == "trimesh"


def test_the_library_and_the_extra_are_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "trimesh.creation", None)
    with (
        pytest.raises(MissingLibraryError) as refusal,
        extra("view", "the viewer"),
    ):
        importlib.import_module("trimesh.creation")
    message = 'the viewer needs trimesh: pip install "orbident[view]"'
    assert str(refusal.value) == message
    assert isinstance(refusal.value, InputError)


def test_other_errors_are_not_hidden():
    with pytest.raises(ZeroDivisionError), extra("view", "the viewer"):
        _ = 1 / 0
