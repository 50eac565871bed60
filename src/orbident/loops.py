"""`numba.njit`, for what is too small for XLA."""

import contextlib
import inspect
from collections.abc import Callable
from typing import Any

import numba


def looped(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile plain loops over arrays and tuples; divisions follow NumPy's rules.

    Shapes go unchecked inside: whoever calls from Python has checked them. What is
    compiled is kept for the next process, where there is a folder to keep it.
    """
    # Without what the type checker of the tests may have put around it.
    plain = inspect.unwrap(function)
    compiled: Any = numba.njit(plain, error_model="numpy", fastmath={"contract"})
    with contextlib.suppress(RuntimeError):
        compiled.enable_caching()
    return compiled
