"""Where runs are made: in this process, or in several on this machine."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from typing import Any

Executors = Callable[[], AbstractContextManager[Executor]]
"""Makes an executor, and another one where workers of the first have died."""


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
    pool = ProcessPoolExecutor(workers, spawn, initializer=_start)
    try:
        yield pool
    finally:
        # What has begun is done again by whoever goes on; nobody is to wait for it.
        running = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in running:
            process.kill()


def _start() -> None:
    """Let a worker ignore Ctrl-C, and end when the command that started it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
