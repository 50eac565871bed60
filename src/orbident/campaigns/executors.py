"""Where runs are made: in this process, in several, or on other machines by Dask.

This is the one import of `distributed`. Certificates for TLS are Dask's own settings
(`distributed.comm.tls`), and so is what a job of Slurm asks for (`jobqueue.slurm`):
both belong to the cluster, not to a campaign.
"""

import asyncio
import importlib
import json
import logging
import multiprocessing
import os
import signal
import sys
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
from contextlib import AbstractContextManager, contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import quoted
from orbident.files.text import read_text

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

    Close the generator when it is not read to its end: that ends the workers. The work
    takes one task, and goes to the workers; no two tasks are equal. `after` says what
    the user is to do when workers die again and again.

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
        if sys.version_info < (3, 11, 5):
            # What is being sent to them would wait for ever (CPython's issue 94777).
            vars(pool)["_call_queue"]._reader.close()
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


ANSWER = 10
"""s until a scheduler must have answered."""

SLURM = "slurm"

LIFETIME = 0.9
"""The part of a job's time after which its worker ends, some earlier than others. It
then hands what it has begun to others; at the end of its job it could not."""


def cluster(where: str, jobs: int) -> Executors:
    """An executor on a cluster.

    It is at a scheduler's address, such as `tls://host:8786`, or that of a scheduler
    file, or so many jobs are submitted to `slurm`.

    Raises:
        MissingLibraryError: Dask is not installed.
        InputError: it is neither an address nor a file, or nobody answers there.
    """
    with extra("cluster", "--cluster"):
        importlib.import_module("distributed")
    # What it would tell in tracebacks, the command says in a line.
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    if where == SLURM:
        return lambda: _on_slurm(jobs)
    address = where if "://" in where else _address_in(Path(where))
    _check_answers(where, address)
    return lambda: _connected(where, address)


def _address_in(file: Path) -> str:
    """What a scheduler file says."""
    if not file.is_file():
        raise InputError(
            f"--cluster {file}: neither an address such as tcp://host:8786, nor a "
            "scheduler file, nor 'slurm'; give one of these"
        )
    try:
        return str(json.loads(read_text(file))["address"])
    except (ValueError, KeyError, TypeError):
        raise InputError(
            f"--cluster {file}: is no scheduler file; give the one that 'dask "
            "scheduler --scheduler-file' wrote"
        ) from None


def _check_answers(where: str, address: str) -> None:
    """A client would wait for ever where a stranger takes the connection."""
    from distributed import Security
    from distributed.comm.core import connect

    if not address.startswith(("tcp://", "tls://")):
        raise InputError(
            f"--cluster {where}: found the address {quoted(address)}; give "
            "tcp://host:port or tls://host:port"
        )

    async def hand_shake() -> None:
        known = Security().get_connection_args("client")
        comm = await asyncio.wait_for(connect(address, ANSWER, **known), ANSWER)
        await comm.close()

    try:
        asyncio.run(hand_shake())
    # A stranger's answer may be taken for anything, a size of memory too.
    except Exception as error:
        reason = " ".join(str(error).split()) or "nothing was said"
        raise InputError(
            f"--cluster {where}: does not answer as a scheduler within {ANSWER} s "
            f"({reason}); see that it runs, and that certificates are as it wants them"
        ) from error


@contextmanager
def _connected(where: str, address: Any) -> Iterator[Executor]:
    from distributed import Client, Security

    # Again, as it may be the second time: the first scheduler may have died.
    if isinstance(address, str):
        _check_answers(where, address)
    client = Client(address, timeout=ANSWER, security=Security(), set_as_default=False)
    try:
        # Not pure: the same run twice is two runs. A worker may be lost twice.
        yield client.get_executor(pure=False, retries=2)
    finally:
        with suppress(OSError, RuntimeError):
            client.close(timeout=ANSWER)


@contextmanager
def _on_slurm(jobs: int) -> Iterator[Executor]:
    with slurm_cluster() as started:
        started.scale(jobs=jobs)
        with _connected(SLURM, started) as executor:
            yield executor


def slurm_cluster() -> Any:
    """A cluster of Slurm jobs, none submitted yet, without a dashboard.

    Raises:
        MissingLibraryError: dask-jobqueue is not installed.
        InputError: Dask's settings do not say what a job asks for.
    """
    with extra("cluster", "--cluster slurm"):
        import dask.config
        from dask_jobqueue.slurm import SLURMCluster
    try:
        lasts = _seconds(str(dask.config.get("jobqueue.slurm.walltime")))
        lives = f"{LIFETIME * lasts:.0f}s"
        stagger = f"{(1 - LIFETIME) / 2 * lasts:.0f}s"
        return SLURMCluster(
            worker_extra_args=["--lifetime", lives, "--lifetime-stagger", stagger],
            scheduler_options={"dashboard": False},
        )
    except (ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"--cluster slurm: {reason}; say in Dask's jobqueue.yaml what a job asks "
            "for: cores, memory, walltime"
        ) from error


def _seconds(walltime: str) -> float:
    """`[days-]hours:minutes:seconds`, as Slurm takes it.

    Raises:
        ValueError: it is written in another way.
    """
    days, _, rest = walltime.rpartition("-")
    hours, minutes, seconds = (int(part) for part in rest.split(":"))
    return 60.0 * (60 * (24 * int(days or 0) + hours) + minutes) + seconds
