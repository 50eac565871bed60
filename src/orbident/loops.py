"""`numba.njit`, for what is too small for XLA."""

# Numba has no stubs for its configuration.
# pyright: reportAttributeAccessIssue=false, reportPrivateImportUsage=false

import contextlib
import hashlib
import inspect
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numba
from platformdirs import user_cache_path


def looped(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile plain loops over arrays and tuples; divisions follow NumPy's rules.

    Shapes go unchecked inside: whoever calls from Python has checked them. What is
    compiled is kept for the next process, where there is a folder to keep it.
    """
    # Without what the type checker of the tests may have put around it.
    plain = inspect.unwrap(function)
    compiled: Any = numba.njit(
        plain, error_model="numpy", fastmath={"contract", "reassoc"}
    )
    with contextlib.suppress(RuntimeError), _caching_in(_folder()):
        compiled.enable_caching()
    return compiled


@cache
def _folder() -> str:
    """One for each state of the sources.

    Numba sees no change of what a function calls in another file, and old and new do
    not go together.
    """
    sources = sorted(Path(__file__).parent.rglob("*.py"))
    text = b"".join(path.read_bytes() for path in sources)
    above = numba.config.CACHE_DIR or user_cache_path("orbident") / "loops"
    return str(Path(above) / hashlib.sha256(text).hexdigest()[:16])


@contextlib.contextmanager
def _caching_in(folder: str) -> Iterator[None]:
    """Numba takes the folder from its configuration, which stays the user's."""
    before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, folder
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before
