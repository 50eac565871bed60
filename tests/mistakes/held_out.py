"""`python tests/mistakes/held_out.py`: mistakes against which no cause was written.

Robots, joints, axes, signs, sizes and times are drawn at random. A cause that is found
on the table of `mistakes.py`, where it was developed, shows little; here it shows what
a user may expect. Maximum likelihood judges, as the cause is the same for all methods.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
from drawn import Kind
from drawn_columns import KINDS as IN_COLUMNS
from drawn_motions import KINDS as IN_MOTIONS
from drawn_robots import KINDS as IN_ROBOTS
from drawn_sensors import KINDS as IN_SENSORS
from mistakes import names_cause
from random_flights import flight
from scoring import Score, scored
from table import lines
from visibility import visibility_of

KINDS = {
    kind.name: kind for kind in (*IN_COLUMNS, *IN_SENSORS, *IN_ROBOTS, *IN_MOTIONS)
}
POOL = 4
"""Robots in space, and as many on the table, in a draw."""
JOINTS = range(3, 6)

GUESS = "perhaps"
"""Before what is suspected, and not tested."""


class Case(NamedTuple):
    """One mistake of a draw."""

    draw: int
    robot: str
    kind: str


class Row(NamedTuple):
    """What became of it."""

    case: Case
    mistake: str
    words: str
    """That name it."""
    score: Score
    named: bool
    hidden: bool
    """Accepted and wrong, but nobody can see it: see `visibility.py`."""


def cases(draw: int) -> Iterator[Case]:
    """Every kind once in space and once on the table, where it can be made.

    In random order: the first ones are as good a sample as any.
    """
    random = np.random.default_rng(draw)
    pools = {place: _pool(place, random) for place in ("space", "table")}
    every = [
        Case(draw, str(random.choice(able)), kind.name)
        for kind in KINDS.values()
        for place, tried in (("space", kind.space), ("table", kind.table))
        if tried and (able := _able(kind, pools[place]))
    ]
    return iter([every[k] for k in random.permutation(len(every))])


def _able(kind: Kind, pool: Sequence[str]) -> list[str]:
    return [name for name in pool if len(flight(name).robot.wheels) >= kind.wheels]


def _pool(place: str, random: np.random.Generator) -> list[str]:
    names: list[str] = []
    while len(names) < POOL:
        number = 2 * int(random.integers(500, 50_000)) + (place == "table")
        name = f"{place} {number}"
        if len(flight(name).robot.joints) in JOINTS:
            names.append(name)
    return names


def row(case: Case) -> Row:
    """Make the mistake, identify, and look for the cause."""
    kind: Kind = KINDS[case.kind]
    clean = flight(case.robot)
    seed = [case.draw, list(KINDS).index(case.kind), clean.space]
    mistake = kind.draw(clean, np.random.default_rng(seed))
    score = scored(mistake.spoil(clean), "maximum-likelihood", causes=True)
    named = score.outcome == "refused" and names_cause(mistake, score.reason)
    hidden = score.outcome == "wrong" and not visibility_of(clean, mistake.spoil).seen
    return Row(case, mistake.name, mistake.cause, score, named, hidden)


def all_rows(
    draw: int,
    workers: int,
    names: Sequence[str] = (),
    progress: Callable[[str], object] = str,
) -> list[Row]:
    """The rows of a draw, in the order of its cases.

    Args:
        draw: its number: a seed.
        workers: processes.
        names: the kinds' names, where not all.
        progress: is called with what is done.
    """
    asked = [case for case in cases(draw) if not names or case.kind in names]
    rows = []
    # A fresh interpreter: threads of the core do not survive a fork.
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for done in pool.map(row, asked):
            rows.append(done)
            progress(f"{len(rows)}/{len(asked)} {_line(done)}")
    return rows


def _line(row: Row) -> str:
    score = row.score
    named = "named" if row.named else ""
    return f"{row.case.robot}: {row.mistake}: {score.outcome} {named}| {score.reason}"


class Count:
    """How often each outcome occurs in all rows."""

    def __init__(self, rows: Sequence[Row]):
        self.runs = len(rows)
        wrong = [row for row in rows if row.score.outcome == "wrong"]
        self.wrong = [row for row in wrong if not row.hidden]
        self.hidden = len(wrong) - len(self.wrong)
        self.crashed = [row for row in rows if row.score.outcome == "crashed"]
        self.right = sum(row.score.outcome == "right" for row in rows)
        refused = [row for row in rows if row.score.outcome == "refused"]
        named = [row for row in refused if row.named]
        self.refused, self.named = len(refused), len(named)
        self.guessed = sum(GUESS in row.score.reason for row in named)

    @property
    def words(self) -> str:
        """A sentence."""
        return (
            f"{self.runs} recordings: {len(self.wrong)} accepted and wrong, "
            f"{self.hidden} more that nobody can see, "
            f"{self.right} accepted and right, {len(self.crashed)} crashed, "
            f"{self.refused} refused; of these the first reason names the cause of "
            f"{self.named} ({self.named / max(self.refused, 1):.0%}), of "
            f"{self.guessed} only after '{GUESS}'"
        )


def markdown(rows: Sequence[Row]) -> str:
    """All rows."""
    header = ("robot", "mistake", "outcome", "worst", "words", "first reason", "s")
    body = (
        [
            row.case.robot,
            row.mistake,
            row.score.outcome + ", named" * row.named + ", not visible" * row.hidden,
            f"{row.score.misses.base:.3g}",
            row.words.replace("|", "/"),
            row.score.reason.replace("|", "/"),
            f"{row.score.seconds:.0f}",
        ]
        for row in rows
    )
    return f"{Count(rows).words}.\n\n{lines(header, body)}\n"


def main() -> int:
    """Run a draw; 1 where something wrong was accepted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draw", type=int, default=1, help="its number")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--out", type=Path, help="file for the table, Markdown")
    parser.add_argument("names", nargs="*", help="kinds; all by default")
    given = parser.parse_args()
    rows = all_rows(
        given.draw, given.workers, given.names, lambda w: print(w, file=sys.stderr)
    )
    if given.out:
        given.out.write_text(markdown(rows), encoding="utf-8")
    print(markdown(rows) if not given.out else Count(rows).words)
    return 1 if Count(rows).wrong else 0


if __name__ == "__main__":
    sys.exit(main())
