"""Two processes, one place."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from test_kills import program
from verbs import VERBS, Shelf, chosen, ended, faults, leftovers, started

SPARING = ("identify",)
"""What exists it does not replace: one wins, and one is refused."""


def raced(seed: int, names: tuple[str, ...], shelf, tmp_path: Path) -> str:
    """Both at once; how they ended."""
    name, _ = chosen(seed, names)
    here: Shelf = shelf(name)
    folder = tmp_path / str(seed)
    here.laid_out(name, folder)
    with started(name, folder) as first, started(name, folder) as second:
        statuses = sorted(ended(process)[0] for process in (first, second))
    assert statuses in ([[0, 2]] if name in SPARING else [[0, 0], [0, 2]])
    assert leftovers(folder) == []
    here.check(name, folder)
    return f"{name}: {statuses}"


def test_many_writers_and_readers():
    """Who reads meanwhile sees the old or the new."""
    assert program("rivals.py") == ""


@pytest.mark.slow
def test_two_identifications(shelf: Callable[..., Shelf], tmp_path: Path):
    assert raced(0, SPARING, shelf, tmp_path) == "identify: [0, 2]"


@pytest.mark.long
def test_many(shelf: Callable[..., Shelf], tmp_path: Path):
    seeds = range(faults(0.1))
    seen = Counter(raced(seed, tuple(VERBS), shelf, tmp_path) for seed in seeds)
    print(*sorted(seen.items()), sep="\n")
    assert seen.total() == len(seeds)
