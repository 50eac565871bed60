"""kill -9 of a campaign's command, of a worker, and of the scheduler of a cluster.

What is resumed is the same table, bit for bit. Twenty kills on this machine and twenty
on a cluster of two workers take some minutes:

.venv/bin/pytest -m long -s tests/faults/test_campaign_kills.py
"""

import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pyarrow as pa
import pytest
from dask_clusters import Cluster, cluster, tls_settings
from processes import ORBIDENT, finished, started
from small_campaigns import begun, rows, write_campaign
from verbs import ended, faults, leftovers

from orbident.campaigns.conduct import conduct
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import opened

RUNS = 8
START, RUN = 5.0, 0.5
"""s: what the start of workers, and a run, may take on two busy cores."""

LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="workers are found in /proc"
)


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign file."""
    return write_campaign(tmp_path_factory.mktemp("given"), runs=RUNS, chunk=1)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> pa.Table:
    """The table by one process."""
    campaign, out = begun(tmp_path_factory.mktemp("one"), runs=RUNS, chunk=1)
    conduct(campaign, out, InThisProcess)
    return rows(campaign, out)


def workers_of(command: int) -> list[int]:
    """The processes that a command has started to make runs."""
    found = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((each / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == command and b"spawn_main" in (each / "cmdline").read_bytes():
                found.append(int(each.name))
        except OSError:
            continue
    return found


def wait_for_a_moment(
    command: subprocess.Popen[str], out: Path, numbers: random.Random
) -> None:
    """Any moment of the start, or while runs are made."""
    if numbers.random() < 0.3:
        time.sleep(numbers.uniform(0.0, START))
        return
    before = made(out)
    while command.poll() is None and made(out) == before:
        time.sleep(0.005)
    time.sleep(numbers.uniform(0.0, RUN))


def made(out: Path) -> int:
    """How many files of rows there are."""
    return len(list(out.glob("rows/*.parquet")))


def disturbed(given: Path, out: Path, numbers: random.Random) -> str:
    """One kill at a random moment; what was killed, if it was in time."""
    victim = numbers.choice(("command", "worker"))
    with started("campaign", given, "-o", out, "--workers", 2, "--quiet") as process:
        wait_for_a_moment(process, out, numbers)
        workers = workers_of(process.pid)
        if process.poll() is not None:
            return "too late"
        if victim == "worker" and workers:
            os.kill(numbers.choice(workers), signal.SIGKILL)
            # The command starts others, and goes on to the end.
            status, said = ended(process)
            assert status == 0, said
            return "worker"
        process.kill()
        process.wait(timeout=30.0)
    _check_ended(workers)
    return "command"


def _check_ended(workers: list[int]) -> None:
    """Workers end with their command."""
    end = time.monotonic() + 30.0
    while any(Path(f"/proc/{pid}").exists() for pid in workers):
        assert time.monotonic() < end
        time.sleep(0.02)


def killed(given: Path, wanted: pa.Table, out: Path, seed: int) -> Counter[str]:
    """Kills until the campaign is complete; what they were."""
    numbers, seen = random.Random(seed), Counter()
    while made(out) < RUNS:
        seen[disturbed(given, out, numbers)] += 1
    check_resumed(given, wanted, out)
    return seen


def check_resumed(given: Path, wanted: pa.Table, out: Path) -> None:
    """The command once more ends the campaign, on this machine, to the same table."""
    ran = finished(*ORBIDENT, "campaign", given, "-o", out, "--quiet")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert rows(opened(out), out).equals(wanted)
    assert leftovers(out) == []


@pytest.mark.slow
@LINUX
def test_one(given: Path, undisturbed: pa.Table, tmp_path: Path):
    """A kill of the command as soon as it has made a run."""
    out = tmp_path / "out"
    with started("campaign", given, "-o", out, "--workers", 2, "--quiet") as process:
        while process.poll() is None and not made(out):
            time.sleep(0.005)
        workers = workers_of(process.pid)
        process.kill()
        process.wait(timeout=30.0)
    assert len(workers) == 2
    _check_ended(workers)
    assert made(out) < RUNS
    conduct(opened(out), out, InThisProcess)
    assert rows(opened(out), out).equals(undisturbed)
    assert leftovers(out) == []


@LINUX
@pytest.mark.long
def test_many(given: Path, undisturbed: pa.Table, tmp_path: Path):
    seen, seed = Counter(), 0
    while seen["command"] + seen["worker"] < faults(0.1):
        seen += killed(given, undisturbed, tmp_path / str(seed), seed)
        seed += 1
    print(*sorted(seen.items()), f"{seed} campaigns", sep="\n")


def disturbed_on(where: Cluster, given: Path, out: Path, numbers: random.Random) -> str:
    """One kill at a random moment of a campaign on a cluster; what was killed."""
    victim = numbers.choice(("command", "worker", "scheduler"))
    at = ("--cluster", where.address, "--quiet")
    with started("campaign", given, "-o", out, *at) as process:
        wait_for_a_moment(process, out, numbers)
        if process.poll() is not None:
            return "too late"
        if victim == "command":
            process.kill()
            process.wait(timeout=30.0)
            return victim
        if victim == "worker":
            workers = workers_of(where.process.pid)
            os.kill(numbers.choice(workers), signal.SIGKILL)
            # Another worker does what that one had, and the command goes on.
            status, said = ended(process)
            assert status == 0, said
            return victim
        where.process.kill()
        status, said = ended(process)
        assert status == 2 or made(out) == RUNS, said
        return victim


@LINUX
@pytest.mark.long
def test_many_on_a_cluster(
    given: Path,
    undisturbed: pa.Table,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
):
    pytest.importorskip("distributed")
    for name, value in tls_settings(tmp_path).items():
        monkeypatch.setenv(name, value)
    seen, seed, numbers = Counter(), 0, random.Random(0)
    while seen.total() - seen["too late"] < faults(0.1):
        with cluster() as where:
            victim = ""
            while victim != "scheduler":
                out = tmp_path / str(seed)
                victim = disturbed_on(where, given, out, numbers)
                seen[victim] += 1
                print(victim, flush=True)
                if made(out) == RUNS:
                    check_resumed(given, undisturbed, out)
                    seed += 1
    check_resumed(given, undisturbed, tmp_path / str(seed))
    print(*sorted(seen.items()), f"{seed + 1} campaigns", sep="\n")
