"""Which samples of a recording a flight build replays: those of the recursion."""

import numpy as np
from jaxtyping import Float

from orbident.estimation.clocks import base_clocks
from orbident.estimation.linear_fits import known_momentum
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def samples_for_flight(
    source: Result | Robot, recording: Recording
) -> tuple[Robot, Samples, Float[np.ndarray, "3"] | None]:
    """Screen a recording and derive what it lacks, as `identify` does.

    Args:
        source: a result, whose robot, clocks and knowledge of the momentum count; or a
            robot, of whose momentum nothing is known.
        recording: of the free-floating robot.

    Returns:
        The robot, its samples, and the momentum where it is known (N m s).

    Raises:
        InputError: a column is missing, or there are too few samples.
    """
    robot = source.robot if isinstance(source, Result) else source
    check_regular(robot)
    clean = screened(robot, recording.with_joints_of(robot)).recording
    if not isinstance(source, Result):
        clocks = base_clocks(robot, clean)
        return robot, samples_of(robot, clean, corrections(clocks)), None
    samples = samples_of(robot, clean, corrections(source.clocks))
    if source.initial_momentum != "at-rest":
        return robot, samples, None
    known = known_momentum(robot, minimal_sets(robot), samples, "at-rest")
    return robot, samples, None if known is None else np.asarray(known.h)
