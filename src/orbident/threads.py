"""How many threads the core and BLAS use."""

import functools
import os
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def processors() -> int:
    """The processors that this process may run on: threads of the core's loops."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def one_blas_thread(
    verb: Callable[Arguments, Returned],
) -> Callable[Arguments, Returned]:
    """Run a public verb with one BLAS thread.

    Thousands of small factorisations are only slowed down by threads that wait for
    one another.
    """

    @functools.wraps(verb)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        with threadpool_limits(limits=1, user_api="blas"):
            return verb(*args, **kwargs)

    return wrapped
