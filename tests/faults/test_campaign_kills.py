"""kill -9 of a campaign's command or of a worker: what is resumed is the same table."""

import os
import random
import signal
import sys
import time
from collections import Counter
from pathlib import Path

import pyarrow as pa
import pytest
from processes import finished, started
from small_campaigns import begun, rows, write_campaign
from verbs import ended, faults, leftovers

from orbident.campaigns.conduct import conduct
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import opened

RUNS = 8
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


def disturbed(given: Path, out: Path, numbers: random.Random) -> str:
    """One kill at a random moment; what was killed, if it was in time."""
    victim = numbers.choice(("command", "worker"))
    with started("campaign", given, "-o", out, "--workers", 2, "--quiet") as process:
        if numbers.random() < 0.3:
            # Any moment of the start; else while runs are made.
            time.sleep(numbers.uniform(0.0, 3.0))
        else:
            count = len(list(out.glob("rows/*.parquet")))
            while process.poll() is None and count == len(
                list(out.glob("rows/*.parquet"))
            ):
                time.sleep(0.005)
            time.sleep(numbers.uniform(0.0, 0.3))
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
    while len(list(out.glob("rows/*.parquet"))) < RUNS:
        seen[disturbed(given, out, numbers)] += 1
    command = [sys.executable, "-m", "orbident.cli.app", "campaign", given, "-o", out]
    ran = finished(*command, "--quiet")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert rows(opened(out), out).equals(wanted)
    assert leftovers(out) == []
    return seen


@LINUX
def test_one(given: Path, undisturbed: pa.Table, tmp_path: Path):
    """A kill of the command as soon as it has made a run."""
    out = tmp_path / "out"
    with started("campaign", given, "-o", out, "--workers", 2, "--quiet") as process:
        while process.poll() is None and not list(out.glob("rows/*.parquet")):
            time.sleep(0.005)
        workers = workers_of(process.pid)
        process.kill()
        process.wait(timeout=30.0)
    assert len(workers) == 2
    _check_ended(workers)
    assert len(list(out.glob("rows/*.parquet"))) < RUNS
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
