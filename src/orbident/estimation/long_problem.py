"""The problem of a recording that is read in stretches.

What only the whole can tell is found from a digest of the recording: clocks, how rough
and how noisy each column is, what is measured and what is derived. Then the equations
of all its samples are folded into one triangular factor, in one pass.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from orbident import _core
from orbident.estimation.linear_fits import (
    Factors,
    InitialMomentum,
    LinearEquations,
)
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.recursive.given import packed_piece, trusted
from orbident.files.kept_pieces import KeptPieces, Piece
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.extent import Extent
from orbident.preprocessing.origins import RUNNING
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import LONGEST, Settings
from orbident.preprocessing.stretches import (
    Part,
    Stretches,
    smoothed_rate,
    some_rows,
)
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.no_measurements import NO_SENSORS
from orbident.robot.description import Robot


def digest_of(
    robot: Robot, recording: LongRecording, initial_momentum: InitialMomentum
) -> MomentumProblem | None:
    """As `momentum_problem`, of a digest of the recording.

    Returns:
        None where something must be integrated over the whole recording, so that it
        has to be in memory.

    Raises:
        InputError: as `momentum_problem`.
    """
    heads = {name.partition(".")[0] for name in recording.digest.columns}
    if heads & {"thruster", *NO_SENSORS}:
        return None
    problem = momentum_problem(
        robot, recording.digest, initial_momentum, lambda _: None, Settings(LONGEST)
    )
    if any(origin & RUNNING for origin in problem.samples.origins.values()):
        return None
    return problem


def whole(
    problem: MomentumProblem,
    recording: LongRecording,
    again: bool,
    progress: Callable[[float], object],
    size: int | None = None,
) -> MomentumProblem:
    """The problem of all samples, on the clocks that it has.

    Args:
        problem: of a digest.
        recording: the whole of it.
        again: whether an estimator needs all samples again.
        progress: is called with the fraction of the rows that is done.
        size: rows of a stretch, where not as many as fit into memory.

    Returns:
        The problem whose recording and samples are those of the digest, and whose
        linear fits are of all samples.

    Raises:
        InputError: as `momentum_problem`.
    """
    robot, settings = problem.robot, Settings(LONGEST)
    late = corrections(problem.clocks)
    every = Stretches(robot, recording, late, settings, size or recording.stretch)
    # Joints that never move are held; which these are is known after one pass.
    settings.locked = {}
    # Which angles are shown within a turn, and which rates are false.
    cleaned(robot, recording.digest, settings)
    while True:
        samples = samples_of(robot, problem.recording, late, settings)
        # Those of before are held no longer.
        problem = replace(problem, samples=samples)
        if again:
            smoothed_rate(samples, settings)
        equations = LinearEquations.of(
            robot, problem.sets, samples, problem.initial_momentum
        )
        _core.give_back_memory()
        one_pass = _Pass(every, equations, trusted(samples) if again else None)
        pieces = KeptPieces(one_pass.pieces) if again else None
        total = None
        for seen, piece in one_pass():
            total = total.and_of(seen) if total else seen
            if pieces and piece:
                pieces.keep(piece)
            progress(total.extent.rows / recording.rows)
        assert total is not None
        locked = total.extent.locked(robot.joint_names)
        if settings.locked or not locked:
            break
        settings.locked = locked
    return replace(
        problem,
        fits=equations.solved(robot, problem.sets, samples, total.factors),
        extent=total.extent,
        pieces=pieces,
        rejected=total.rejected_by_column(),
    )


@dataclass(frozen=True)
class _Pass:
    """One pass through a recording, as often as it is called."""

    stretches: Stretches
    equations: LinearEquations
    trusted: tuple[float, float] | None
    """Between these times samples are packed, s."""

    def __call__(self) -> Iterator[tuple["_Seen", Piece | None]]:
        """What each stretch says, and its packed samples."""
        return self.stretches.each(lambda part: (self._seen(part), self._piece(part)))

    def pieces(self) -> Iterator[Piece]:
        """The packed samples alone."""
        return (piece for piece in self.stretches.each(self._piece) if piece)

    def _seen(self, part: Part) -> "_Seen":
        own = some_rows(part.samples, part.own)
        rejected = Counter(
            {
                (column, why): count
                for column, reasons in part.rejected.items()
                for why, count in reasons.items()
            }
        )
        return _Seen(self.equations.folded(own), Extent.of(own), rejected)

    def _piece(self, part: Part) -> Piece | None:
        if self.trusted is None:
            return None
        rate = smoothed_rate(part.samples, self.stretches.settings)[part.own]
        return packed_piece(some_rows(part.samples, part.own), rate, self.trusted)


class _Seen(NamedTuple):
    """What the samples of some stretches amount to."""

    factors: Factors
    extent: Extent
    rejected: Counter[tuple[str, str]]
    """How many samples were left out, by column and reason."""

    def and_of(self, other: "_Seen") -> "_Seen":
        """What both do, the other being later."""
        return _Seen(
            self.factors.and_of(other.factors),
            self.extent.and_of(other.extent),
            self.rejected + other.rejected,
        )

    def rejected_by_column(self) -> dict[str, dict[str, int]]:
        """The same of each column."""
        found: dict[str, dict[str, int]] = {}
        for (column, reason), count in self.rejected.items():
            found.setdefault(column, {})[reason] = count
        return found
