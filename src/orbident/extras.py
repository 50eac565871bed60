"""What is imported when it is first used: libraries of an extra, and layers above.

A library may be missing, which is said with the extra that installs it. What a layer
above makes of a result is registered by name, so that no layer imports one above it.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from orbident.errors import InputError


class MissingLibraryError(InputError):
    """A library is not installed; the message says which extra installs it."""


@contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Import libraries of an extra in the block.

    The message begins with the purpose: what needs the libraries.

    Raises:
        MissingLibraryError: a module that the block imports is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        library = (error.name or name).partition(".")[0]
        raise MissingLibraryError(
            f'{purpose} needs {library}: pip install "orbident[{name}]"'
        ) from error


def require_library(library: str) -> None:
    """Stands in a block of `extra` for the import, where only a child imports it.

    Raises:
        ModuleNotFoundError: it is not installed.
    """
    if find_spec(library) is None:
        raise ModuleNotFoundError(name=library)


_PLACES: dict[str, str] = {}


def provide(name: str, place: str) -> None:
    """Register a function of a result, `module:function`, to be imported when used."""
    _PLACES[name] = place


def provided(name: str) -> Callable[..., Any]:
    """The function that was registered by this name."""
    module, _, function = _PLACES[name].partition(":")
    return getattr(import_module(module), function)
