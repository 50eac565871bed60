"""No space left: one line, status 2, nothing lost and nothing left behind."""

import shutil
import sys
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import pytest
from processes import ORBIDENT, finished
from small_campaigns import begun, rows, write_campaign
from verbs import (
    PLACES,
    QUICK,
    VERBS,
    Shelf,
    chosen,
    ended,
    faults,
    leftovers,
    started,
)

from orbident.campaigns.conduct import campaign_progress, conduct
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import opened

slow = partial(pytest.param, marks=pytest.mark.slow)
long = partial(pytest.param, marks=pytest.mark.long)
RUNS = 8
"""Runs of the campaign, each in a file of its own."""

WITH_OWN_MOUNTS = ("unshare", "--map-root-user", "--mount")
ON_A_SMALL_DISK = """
set -e
size=$1; shift
mv "$PWD" "$PWD.old"; mkdir "$PWD"
mount -t tmpfs -o size="$size" none "$PWD"
cp -a "$PWD.old/." "$PWD"
cd "$PWD"
status=0; "$@" || status=$?
mkdir "$PWD.new"; cp -a "$PWD/." "$PWD.new"
exit "$status"
"""
"""A disk that only this process sees; what it holds at the end is copied to `.new`."""


WITH_SMALL_FILES = """
import os, resource, sys
most = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
os.execv(sys.argv[2], sys.argv[2:])
"""


@cache
def may_mount() -> bool:
    """Whether the system lets us have a disk of our own."""
    if shutil.which("unshare") is None:
        return False
    mount = "mount -t tmpfs -o size=4k none /mnt"
    return finished(*WITH_OWN_MOUNTS, "sh", "-c", mount).returncode == 0


def size_of(path: Path) -> int:
    return sum(each.stat().st_size for each in [path, *path.rglob("*")])


def check_refused(status: int, said: str, here: Shelf, name: str, folder: Path) -> str:
    """Complete, or refused in one line without a trace."""
    assert status in {0, 2}, said
    if status == 2:
        assert PLACES[name].split("/")[0] in said
        assert "cannot be written" in said
        assert "nothing was changed there; " in said
    assert leftovers(folder) == []
    here.check(name, folder)
    return f"{name}: {('complete', '', 'refused')[status]}"


def limited(seed: int, names: tuple[str, ...], shelf, tmp_path: Path) -> str:
    """No file may become larger than some bytes."""
    name, numbers = chosen(seed, names)
    here: Shelf = shelf(name)
    folder = tmp_path / str(seed)
    here.laid_out(name, folder)
    made = here.made["run" if name.startswith(("identify", "report")) else name]
    most = numbers.randrange(size_of(made))

    program = (sys.executable, "-c", WITH_SMALL_FILES, str(most))
    with started(name, folder, program) as process:
        status, said = ended(process)
    return check_refused(status, said, here, name, folder)


def filled(seed: int, names: tuple[str, ...], shelf, tmp_path: Path) -> str:
    """A disk with some bytes free."""
    name, numbers = chosen(seed, names)
    here: Shelf = shelf(name)
    folder = tmp_path / str(seed)
    here.laid_out(name, folder)
    made = here.made["run" if name.startswith(("identify", "report")) else name]
    # Blocks of 4 KiB, and one for every name.
    free = numbers.randrange(1, 2 + size_of(made) // 4096)
    used = sum(1 + each.lstat().st_size // 4096 for each in folder.rglob("*"))
    script = ("sh", "-c", ON_A_SMALL_DISK, "sh", str(4096 * (used + free)))
    program = (*WITH_OWN_MOUNTS, *script)
    with started(name, folder, program) as process:
        status, said = ended(process)
    return check_refused(status, said, here, name, tmp_path / f"{seed}.new")


@pytest.mark.slow
@pytest.mark.skipif(
    not may_mount(), reason="the system does not let this user mount a small disk"
)
def test_a_campaign(tmp_path: Path):
    """What is made is kept; with space again, the rest is made to the same table."""
    campaign, whole = begun(tmp_path / "whole", runs=RUNS, chunk=1)
    conduct(campaign, whole, InThisProcess)
    here = tmp_path / "here"
    write_campaign(here, runs=RUNS, chunk=1)
    # What is given and frozen, and the rows of some runs.
    script = ("sh", "-c", ON_A_SMALL_DISK, "sh", "140k")
    command = (*ORBIDENT, "campaign", "campaign.yaml", "-o", "out", "--workers", 1)
    ran = finished(*WITH_OWN_MOUNTS, *script, *command, cwd=here)
    assert ran.returncode == 2, ran.stderr
    assert ran.stderr.startswith("orbident: ")
    assert ran.stderr.count("\n") == 1
    assert "free some space" in ran.stderr

    out = tmp_path / "here.new" / "out"
    assert leftovers(out) == []
    begun_there = opened(out)
    assert 0 < campaign_progress(begun_there, out).runs < RUNS
    conduct(begun_there, out, InThisProcess)
    assert rows(begun_there, out).equals(rows(campaign, whole))


@pytest.mark.parametrize(
    "seed", [*map(long, (0, 1)), 2, slow(3), *map(long, range(4, len(QUICK)))]
)
def test_some(shelf: Callable[..., Shelf], tmp_path: Path, seed: int):
    limited(seed, QUICK, shelf, tmp_path)


@pytest.mark.long
def test_many(shelf: Callable[..., Shelf], tmp_path: Path):
    """Where a disk can be had, half of them on one that is really full."""
    seen = Counter()
    for seed in range(2000, 2000 + faults(0.25)):
        way = filled if may_mount() and seed % 2 else limited
        seen[f"{way.__name__}: {way(seed, tuple(VERBS), shelf, tmp_path)}"] += 1
    print(*sorted(seen.items()), sep="\n")
    assert seen.total() == faults(0.25)
