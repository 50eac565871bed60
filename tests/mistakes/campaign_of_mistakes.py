"""Every mistake on every robot by every method, in several processes."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from mistake import Mistake
from mistakes import MISTAKES, REAL_EFFECTS, by_name
from scoring import Row, row

Asked = tuple[str, str]
"""A robot, and the name of a mistake."""

Done = TypeVar("Done")


def arguments(description: str | None) -> argparse.Namespace:
    """Those of a command that makes the mistakes of a table, which is `of`."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--out", type=Path, help="file for the table, Markdown")
    parser.add_argument("names", nargs="*", help="mistakes; all by default")
    parser.add_argument(
        "--real-effects",
        dest="of",
        action="store_const",
        const=REAL_EFFECTS,
        default=MISTAKES,
        help="what real ones do, in MuJoCo",
    )
    parser.add_argument(
        "--usual-tolerances",
        action="store_true",
        help="robot files with the usual tolerances, and not exact instruments",
    )
    return parser.parse_args()


def in_processes(
    function: Callable[[Asked], Done],
    workers: int,
    names: Sequence[str] = (),
    of: Sequence[Mistake] = MISTAKES,
) -> Iterator[tuple[str, Asked, Done]]:
    """What a function makes of every row of a table, in the table's order.

    Args:
        function: of the robot and the mistake's name.
        workers: processes.
        names: the mistakes' names, where not all.
        of: the mistakes of the table.

    Returns:
        How many rows of all are done, the row, and what was made of it.
    """
    asked = [
        (robot, mistake.name)
        for mistake in of
        if not names or mistake.name in names
        for robot in mistake.robots
    ]
    # A fresh interpreter: threads of the core do not survive a fork.
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for k, done in enumerate(pool.map(function, asked)):
            yield f"{k + 1}/{len(asked)}", asked[k], done


def all_rows(
    workers: int,
    names: Sequence[str] = (),
    progress: Callable[[str], object] = str,
    of: Sequence[Mistake] = MISTAKES,
    usual: bool = False,
) -> list[Row]:
    """The rows of all mistakes, in the order of the table; see `in_processes`.

    Args:
        workers: processes.
        names: the mistakes' names, where not all.
        progress: is called with what is done.
        of: the mistakes of the table.
        usual: whether robot files declare the usual tolerances.
    """
    rows, function = [], partial(_scores, usual=usual)
    for done, (robot, name), scores in in_processes(function, workers, names, of):
        rows.append(Row(robot, by_name(name), scores))
        progress(f"{done} {robot}: {name}")
    return rows


def _scores(asked: Asked, usual: bool) -> dict:
    """Without the mistake: its functions cannot be sent to another process."""
    robot, name = asked
    return row(robot, by_name(name), causes=True, usual=usual).scores
