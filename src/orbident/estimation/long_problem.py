"""The problem of a recording that is read in stretches.

What only the whole can tell is found from a digest of the recording: clocks, how rough
and how noisy each column is, what is measured and what is derived. Then the equations
of all its samples are folded into one triangular factor, stretch by stretch.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace

from orbident.estimation.clocks import base_clocks, joint_clocks
from orbident.estimation.extent import Extent
from orbident.estimation.linear_fits import InitialMomentum, fit
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.stretches import Stretches, cut
from orbident.model.minimal_sets import minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.base_motion import FUSED, INTEGRATED
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.point_velocity import COUNTED, FELT
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import NO_SENSORS, screened
from orbident.preprocessing.settings import LONGEST, Settings
from orbident.recordings.long_recording import SPANS, LongRecording
from orbident.robot.description import Robot

NOT_LOCAL = {INTEGRATED, FUSED, FELT, COUNTED}
"""How a signal is obtained that depends on all samples before, or on all there are."""


def long_problems(
    robot: Robot,
    recording: LongRecording,
    initial_momentum: InitialMomentum,
    progress: Callable[[float], object],
    size: int | None = None,
) -> list[MomentumProblem] | None:
    """As `momentum_problems`, of a recording that is read in stretches.

    Args:
        robot: geometry, wheels and structure.
        recording: of the free-floating robot.
        initial_momentum: what is known of the momentum.
        progress: is called with the fraction of the rows that is done.
        size: rows of a stretch, where not as many as fit into memory.

    Returns:
        Problems whose recording and samples are those of the digest, and whose linear
        fits are of all samples; None where something must be integrated over the whole
        recording, so that it has to be in memory.

    Raises:
        InputError: as `momentum_problems`.
    """
    check_regular(robot)
    size = size or recording.stretch
    recording.digest.check_joints(robot)
    clean = screened(robot, recording.digest)
    heads = {name.partition(".")[0] for name in clean.recording.columns}
    if heads & {"thruster", *NO_SENSORS}:
        return None
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, clean.recording)
    samples = samples_of(robot, clean.recording, corrections(clocks))
    if NOT_LOCAL & set(samples.origins.values()):
        return None
    problem = MomentumProblem(
        robot,
        sets,
        clean.recording,
        {},
        clean.notes,
        clocks,
        samples,
        initial_momentum,
        fit(robot, sets, samples, initial_momentum, lambda _: None),
    )
    first = _of_all(problem, recording, progress, size)
    span = samples.t.size // SPANS
    middle = cut(first.samples, slice(SPANS // 2 * span, (SPANS // 2 + 1) * span))
    late = joint_clocks(robot, sets, middle, initial_momentum)
    punctual = {name: delay._replace(believed=False) for name, delay in late.items()}
    first = replace(first, clocks=clocks | punctual)
    if late == punctual:
        return [first]
    other = replace(problem, clocks=clocks | late)
    return [first, _of_all(other, recording, progress, size)]


def _of_all(
    problem: MomentumProblem,
    recording: LongRecording,
    progress: Callable[[float], object],
    size: int,
) -> MomentumProblem:
    """The problem with linear fits of all samples, on the clocks that it has."""
    robot, given = problem.robot, problem.initial_momentum
    settings = Settings(LONGEST)
    late = corrections(problem.clocks)
    # Joints that never move are held; which these are is known after one pass.
    settings.locked = {}
    while True:
        samples = samples_of(robot, problem.recording, late, settings)
        every = Stretches(robot, recording, late, settings, size)
        seen = _Seen(every, progress)
        fits = fit(robot, problem.sets, samples, given, lambda _: None, iter(seen))
        extent = seen.extent
        assert extent is not None
        locked = extent.locked(robot.joint_names)
        if settings.locked or not locked:
            break
        settings.locked = locked
    return replace(
        problem,
        samples=samples,
        fits=fits,
        stretches=every,
        extent=extent,
        rejected={name: {"spike": n} for name, n in seen.spikes.items()},
    )


class _Seen:
    """Stretches, and what they amount to once all have passed."""

    def __init__(self, every: Stretches, progress: Callable[[float], object]) -> None:
        self._every, self._progress = every, progress
        self.extent: Extent | None = None
        self.spikes: Counter[str] = Counter()

    def __iter__(self) -> Iterator[Samples]:
        for samples, rejected in self._every.with_rejected():
            own = Extent.of(samples)
            self.extent = self.extent.and_of(own) if self.extent else own
            for name, why in rejected.items():
                self.spikes[name] += sum(why.values())
            yield samples
            self._progress(self.extent.rows / self._every.recording.rows)
