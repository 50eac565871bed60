"""Every mistake on every robot by every method, in several processes."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from mistake import Mistake
from mistakes import MISTAKES, by_name
from scoring import Row, row


def all_rows(
    workers: int,
    names: Sequence[str] = (),
    progress: Callable[[str], object] = str,
    of: Sequence[Mistake] = MISTAKES,
) -> list[Row]:
    """The rows of all mistakes, in the order of the table.

    Args:
        workers: processes.
        names: the mistakes' names, where not all.
        progress: is called with what is done.
        of: the mistakes of the table.
    """
    asked = asked_of(names, of)
    rows = []
    # A fresh interpreter: threads of the core do not survive a fork.
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for one in pool.map(_scores, asked):
            robot, name = asked[len(rows)]
            rows.append(Row(robot, by_name(name), one))
            progress(f"{len(rows)}/{len(asked)} {robot}: {name}")
    return rows


def asked_of(names: Sequence[str], of: Sequence[Mistake]) -> list[tuple[str, str]]:
    """Robot and mistake of every row."""
    return [
        (robot, mistake.name)
        for mistake in of
        if not names or mistake.name in names
        for robot in mistake.robots
    ]


def _scores(asked: tuple[str, str]) -> dict:
    """Without the mistake: its functions cannot be sent to another process."""
    robot, name = asked
    return row(robot, by_name(name), causes=True).scores
