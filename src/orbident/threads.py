"""One BLAS thread: thousands of small factorisations are only slowed down by more."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def one_blas_thread(
    verb: Callable[Arguments, Returned],
) -> Callable[Arguments, Returned]:
    """Run a public verb with one; threads that wait for another spin."""

    @functools.wraps(verb)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        with threadpool_limits(limits=1, user_api="blas"):
            return verb(*args, **kwargs)

    return wrapped
