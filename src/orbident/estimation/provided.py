"""What layers above make of a result: each is registered by name, none imported."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

_PLACES: dict[str, str] = {}


def provide(name: str, place: str) -> None:
    """Register a function of a result; its module is imported when it is first used.

    Args:
        name: by which a result asks for it.
        place: `module:function`.
    """
    _PLACES[name] = place


def provided(name: str) -> Callable[..., Any]:
    """The function that was registered by this name."""
    module, _, function = _PLACES[name].partition(":")
    return getattr(import_module(module), function)
