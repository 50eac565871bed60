"""The pictures are what the product computes, and need neither network nor script."""

import re
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable

import numpy as np
import pytest
from pages import PAGES, ROOT, name_of

KEPT = sorted((ROOT / "docs/pictures").glob("*.svg"))
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
SHOWN = re.compile(r"!\[([^\]]*)\]\(([^)]+)\)")
LARGEST = 150_000
"""Bytes: a page with it is there at once."""
ROUNDING = 0.3
"""Pixels: numbers are written with one decimal, of an estimate that ends within a
millionth of its best."""


@pytest.fixture(scope="module")
def made() -> dict[str, str]:
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        make: Callable[[], dict[str, str]] = __import__("make_pictures").pictures
    finally:
        sys.path.pop(0)
    return make()


@pytest.mark.slow
def test_they_are_those_that_the_command_makes(made: dict[str, str]):
    """`python docs/make_pictures.py` makes them again."""
    assert [path.name for path in KEPT] == sorted(made)
    for path in KEPT:
        kept = path.read_text(encoding="utf-8")
        assert NUMBER.split(kept) == NUMBER.split(made[path.name]), path
        old, new = (
            np.array(NUMBER.findall(text), float) for text in (kept, made[path.name])
        )
        np.testing.assert_allclose(new, old, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.name)
def test_they_are_small_and_say_what_they_show(path):
    text = path.read_text(encoding="utf-8")
    assert len(text) < LARGEST
    root = ET.fromstring(text)
    names = [each.tag.rpartition("}")[2] for each in root.iter()]
    assert {"title", "desc"} <= set(names)
    assert "script" not in names
    assert text.count("://") == text.count('xmlns="http://www.w3.org/2000/svg"')
    assert "prefers-color-scheme: dark" in text


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_pictures_of_pages_are_there_and_have_words_instead(page):
    for words, file in SHOWN.findall(page.read_text(encoding="utf-8")):
        assert (page.parent / file).is_file(), file
        assert len(words.split()) > 5, file
