"""kill -9: what was there is there, or what is there is new and complete."""

import random
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import finished
from verbs import QUICK, VERBS, Shelf, chosen, ended, faults, leftovers, started

HERE = Path(__file__).parent
SECONDS = 4.0
"""About what a verb takes; later than that most are done."""


def program(name: str) -> str:
    """A file beside this one as a program; what it prints."""
    env = {"PYTHONPATH": f"{HERE.parent / 'support'}:{HERE.parents[1] / 'src'}"}
    ran = finished(sys.executable, "-W", "ignore", HERE / name, env=env)
    assert (ran.returncode, ran.stderr) == (0, "")
    return ran.stdout


@pytest.mark.slow
def test_before_every_call_of_the_file_system():
    """Each case was killed at many places, so that none was skipped."""
    kills = dict(line.split() for line in program("crash_points.py").splitlines())
    assert int(kills["single_file"]) >= 4
    assert int(kills["first_run"]) >= 40
    assert int(kills["replaced_run"]) >= 60


def kill(name: str, folder: Path, numbers: random.Random) -> bool:
    """Kill a verb at a random moment, or just after it has begun to write.

    Return whether it was killed before its end.
    """
    with started(name, folder) as process:
        if numbers.random() < 0.5:
            end = time.monotonic() + numbers.uniform(0.0, SECONDS)
            while process.poll() is None and time.monotonic() < end:
                time.sleep(0.01)
        else:
            while process.poll() is None and not leftovers(folder):
                time.sleep(0.001)
            time.sleep(numbers.uniform(0.0, 0.1))
        process.kill()
        status, _ = ended(process)
    return status != 0


def killed(seed: int, names: tuple[str, ...], shelf, tmp_path: Path) -> str:
    """One kill and the check after it; what became of it."""
    name, numbers = chosen(seed, names)
    here: Shelf = shelf(name)
    folder = tmp_path / str(seed)
    here.laid_out(name, folder)
    in_time = kill(name, folder, numbers)
    left = bool(leftovers(folder))
    here.check(name, folder)
    return f"{name}: " + ("writing" if left else "in time" if in_time else "too late")


@pytest.mark.parametrize(
    "seed",
    [*(pytest.param(k, marks=pytest.mark.slow) for k in range(len(QUICK) - 1)), 3],
)
def test_some(shelf: Callable[..., Shelf], tmp_path: Path, seed: int):
    killed(seed, QUICK, shelf, tmp_path)


@pytest.mark.long
def test_many(shelf: Callable[..., Shelf], tmp_path: Path):
    seeds = range(1000, 1000 + faults(1.0))
    seen = Counter(killed(seed, tuple(VERBS), shelf, tmp_path) for seed in seeds)
    print(*sorted(seen.items()), sep="\n")
    assert seen.total() == len(seeds)
