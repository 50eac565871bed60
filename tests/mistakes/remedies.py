"""`python tests/mistakes/remedies.py`: what comes of doing as a refusal says.

A recording with a mistake is refused, and the first reason says what to do. That is
done, and what is accepted then must be right; see `following.py`.
"""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from campaign_of_mistakes import arguments, in_processes
from following import NOTHING_TO_FOLLOW, Attempt, Refusal, followed
from mistake import Mistake
from mistakes import MISTAKES, by_name
from recordings import clean
from table import lines

import orbident as oi
from orbident.diagnosis.trial import Trial, sure_trial

OUTCOMES = (
    *("right", "refused", "wrong", "wrong, not visible", "crashed"),
    *("measured", "nothing there", "declared", "nothing to follow"),
)


class Row(NamedTuple):
    """A recording that is refused, and what is done about it."""

    robot: str
    mistake: str
    words: str
    """The first reason, and what it says to do."""
    attempts: tuple[Attempt, ...]

    def has(self, outcome: str) -> bool:
        """Whether this came of what was done."""
        return outcome in {one.outcome for one in self.attempts}


def row(asked: tuple[str, str]) -> Row | None:
    """Make the mistake, identify, and follow; None where nothing is refused."""
    mistake, trials = by_name(asked[1]), list[Trial]()
    known = clean(asked[0])
    spoiled = mistake.spoil(known)

    def kept(one: Trial, before: float) -> Trial:
        trials.append(sure_trial(one, before))
        return trials[-1]

    start = spoiled.initial_momentum
    try:
        result = oi.identify(spoiled.robot, spoiled.recording, initial_momentum=start)
    except oi.InputError as error:
        return Row(*asked, str(error), (NOTHING_TO_FOLLOW,))
    if result.status != "rejected":
        return None
    assert result.solved is not None
    # A result does not keep what was tried for it.
    with patch("orbident.diagnosis.causes.sure_trial", kept):
        checks = result.with_causes().checks
    first = next(one for one in checks if one.level == "do not trust")
    refusal = Refusal(known, mistake, spoiled, result.solved.problem, first, trials)
    return Row(*asked, first.words, tuple(followed(refusal)))


def all_rows(
    workers: int,
    names: Sequence[str] = (),
    progress: Callable[[str], object] = str,
    of: Sequence[Mistake] = MISTAKES,
) -> list[Row]:
    """The rows of all recordings that are refused, in the order of the table.

    Args:
        workers: processes.
        names: the mistakes' names, where not all.
        progress: is called with what is done.
        of: the mistakes of the table.
    """
    rows = list[Row]()
    for done, (robot, name), one in in_processes(row, workers, names, of):
        rows += [one] if one else []
        outcomes = [each.outcome for each in one.attempts] if one else ["accepted"]
        progress(f"{done} {robot}: {name}: {', '.join(outcomes)}")
    return rows


def in_words(rows: Sequence[Row]) -> str:
    """A sentence with all counts."""
    found = Counter(one.outcome for row in rows for one in row.attempts)
    counts = "; ".join(f"{found[outcome]} {outcome}" for outcome in OUTCOMES)
    return f"{len(rows)} recordings are refused; what they say to do: {counts}"


def markdown(rows: Sequence[Row]) -> str:
    """All that was done."""
    header = ("robot", "mistake", "done", "outcome", "worst", "first reason")
    body = (
        [row.robot, row.mistake, one.way, one.outcome, f"{one.miss:.3g}", row.words]
        for row in rows
        for one in row.attempts
    )
    return f"{in_words(rows)}.\n\n{lines(header, body)}\n"


def main() -> int:
    """Follow all; 1 where something wrong is accepted in the end."""
    given = arguments(__doc__)

    def tell(words: str) -> None:
        print(words, file=sys.stderr)

    rows = all_rows(given.workers, given.names, tell, given.of)
    if given.out:
        given.out.write_text(markdown(rows), encoding="utf-8")
    print(in_words(rows) if given.out else markdown(rows))
    return 1 if any(row.has("wrong") for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
