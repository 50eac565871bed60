"""Where runs are made: in this process, or in several on this machine."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager, contextmanager
from itertools import islice
from typing import Any, TypeVar

from orbident.errors import InputError

Task = TypeVar("Task")
Done = TypeVar("Done")

Executors = Callable[[], AbstractContextManager[Executor]]
"""Makes an executor, and another one where workers of the first have died."""

WAITING = 64
"""Tasks that executors are given ahead: enough for many workers, little memory."""

PATIENCE = 3
"""Times that workers may die in a row without a task done."""


def computed(
    executors: Executors,
    work: Callable[[Task], Done],
    tasks: Iterable[Task],
    after: str = "",
) -> Generator[tuple[Task, Future[Done]]]:
    """Do all tasks; those that workers had when they died are done again.

    Close the generator when it is not read to its end: that ends the workers.

    Args:
        executors: where.
        work: takes one task; goes to the workers.
        tasks: no two are equal.
        after: what the user is to do when workers die again and again.

    Yields:
        Tasks as they are done, in any order, each with its result or what it raised.

    Raises:
        InputError: workers die again and again.
    """
    left, deaths = dict.fromkeys(tasks), 0
    while left:
        try:
            with executors() as executor:
                for task, future in _submitted(executor, work, tuple(left)):
                    if isinstance(died := future.exception(), BrokenExecutor):
                        raise died
                    del left[task]
                    deaths = 0
                    yield task, future
        except (BrokenExecutor, CancelledError) as error:
            deaths += 1
            if deaths == PATIENCE:
                raise InputError(
                    f"workers ended {PATIENCE} times in a row before any was done, "
                    f"perhaps for want of memory; {after}run the same command with "
                    "fewer --workers"
                ) from error


def _submitted(
    executor: Executor, work: Callable[[Task], Done], tasks: Iterable[Task]
) -> Iterator[tuple[Task, Future[Done]]]:
    left = iter(tasks)
    running: dict[Future[Done], Task] = {}
    while True:
        for task in islice(left, WAITING - len(running)):
            future = executor.submit(work, task)
            running[future] = task
            if future.done():
                break
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            yield running.pop(future), future


class InThisProcess(Executor):
    """Runs what is submitted at once, where it is submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """A future that is done already."""
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def local(workers: int) -> Executors:
    """Processes on this machine; with one worker this one."""
    return InThisProcess if workers == 1 else lambda: _pool(workers)


@contextmanager
def _pool(workers: int) -> Iterator[Executor]:
    # A fork of a process with threads may hang.
    spawn = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, spawn, initializer=_start)
    try:
        yield pool
    finally:
        # What has begun is done again by whoever goes on; nobody is to wait for it.
        # One that an interrupt met as it began is not in the pool yet.
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        # Without workers it takes no time, and leaves no semaphores behind, of which
        # Python would warn where an interrupt ends this process.
        pool.shutdown(wait=True, cancel_futures=True)


def _start() -> None:
    """Let a worker ignore Ctrl-C, and end when the command that started it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
