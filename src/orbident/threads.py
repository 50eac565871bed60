"""How many threads the core and BLAS use."""

import functools
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import ContextVar
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")
Item = TypeVar("Item")


_alone = ContextVar("_alone", default=False)


def processors() -> int:
    """Threads of the core's loops: the processors that this process may run on."""
    return 1 if _alone.get() else at_hand()


def at_hand() -> int:
    """The processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def ahead(items: Iterator[Item]) -> Iterator[Item]:
    """Prepare the next item in a thread, one at most, beside the work on each."""
    if processors() == 1:
        yield from items
        return
    with ThreadPoolExecutor(1) as beside:
        coming = beside.submit(next, items, None)
        while (item := coming.result()) is not None:
            coming = beside.submit(next, items, None)
            yield item


def side_by_side(
    work: Callable[[Item], Returned], items: Iterable[Item]
) -> Iterator[Returned]:
    """`map`, in threads: for work that is done in the core, which has one thread then.

    No more items are held than there are threads, however many there are.
    """
    if processors() == 1:
        yield from map(work, items)
        return

    def alone(item: Item) -> Returned:
        _alone.set(True)
        return work(item)

    with ThreadPoolExecutor(processors()) as threads:
        coming: deque[Future[Returned]] = deque()
        for item in items:
            coming.append(threads.submit(alone, item))
            del item
            if len(coming) == processors():
                yield coming.popleft().result()
        while coming:
            yield coming.popleft().result()


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


def one_thread(work: Callable[Arguments, Returned]) -> Callable[Arguments, Returned]:
    """Run what has other processes beside it with one thread, of BLAS and the core."""

    @functools.wraps(work)
    @one_blas_thread
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        token = _alone.set(True)
        try:
            return work(*args, **kwargs)
        finally:
            _alone.reset(token)

    return wrapped
