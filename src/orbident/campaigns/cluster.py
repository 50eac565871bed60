"""Runs on other machines, by Dask; the one import of `distributed`.

Certificates for TLS are Dask's own settings (`distributed.comm.tls`), and so is what a
job of Slurm asks for (`jobqueue.slurm`): both belong to the cluster, not to a campaign.
"""

import asyncio
import importlib
import json
import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from orbident.campaigns.executors import Executors
from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import quoted
from orbident.files.text import read_text

PATIENCE = 10
"""s until a scheduler must have answered."""

SLURM = "slurm"

LIFETIME = 0.9
"""The part of a job's time after which its worker ends, some earlier than others. It
then hands what it has begun to others; at the end of its job it could not."""


def cluster(where: str, jobs: int) -> Executors:
    """An executor on a cluster.

    Args:
        where: a scheduler's address, such as `tls://host:8786`; a scheduler file; or
            `slurm`.
        jobs: that are submitted to Slurm.

    Raises:
        MissingLibraryError: Dask is not installed.
        InputError: it is neither an address nor a file, or nobody answers there.
    """
    with extra("cluster", "--cluster"):
        importlib.import_module("distributed")
    _silence("distributed")
    if where == SLURM:
        return lambda: _on_slurm(jobs)
    address = where if "://" in where else _address_in(Path(where))
    _check_answers(where, address)
    return lambda: _connected(where, address)


def _silence(library: str) -> None:
    """What it would tell in tracebacks, the command says in a line."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == library:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


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
        comm = await asyncio.wait_for(connect(address, PATIENCE, **known), PATIENCE)
        await comm.close()

    try:
        asyncio.run(hand_shake())
    # A stranger's answer may be taken for anything, a size of memory too.
    except Exception as error:
        reason = " ".join(str(error).split()) or "nothing was said"
        raise InputError(
            f"--cluster {where}: does not answer as a scheduler within {PATIENCE} s "
            f"({reason}); see that it runs, and that certificates are as it wants them"
        ) from error


@contextmanager
def _connected(where: str, address: Any) -> Iterator[Executor]:
    from distributed import Client, Security

    # Again, as it may be the second time: the first scheduler may have died.
    if isinstance(address, str):
        _check_answers(where, address)
    client = Client(
        address, timeout=PATIENCE, security=Security(), set_as_default=False
    )
    try:
        # Not pure: the same run twice is two runs. A worker may be lost twice.
        yield client.get_executor(pure=False, retries=2)
    finally:
        with suppress(OSError, RuntimeError):
            client.close(timeout=PATIENCE)


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
