"""Libraries that an extra of this package installs, and the refusal without them."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from orbident.errors import InputError


class MissingLibraryError(InputError):
    """A library is not installed; the message says which extra installs it."""


@contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Import libraries of an extra in the block.

    Args:
        name: the extra, as in `pip install "orbident[name]"`.
        purpose: what needs the libraries; the message begins with it.

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

    Args:
        library: its name.

    Raises:
        ModuleNotFoundError: it is not installed.
    """
    if find_spec(library) is None:
        raise ModuleNotFoundError(name=library)
