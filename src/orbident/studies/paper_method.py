"""The paper's method: linear fits of signals that were filtered beforehand."""

import time

from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import momentum_problems
from orbident.estimation.obstacles import obstacles
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def paper_method(
    robot: Robot, recording: Recording, initial_momentum: InitialMomentum
) -> Result:
    """Identify by Eqs. 24, 31 and 32 alone.

    Filtered signals are no sensor's any more, so the result is not judged by what
    sensors show: a study knows the truth.

    Args:
        robot: geometry, wheels and structure.
        recording: of filtered signals.
        initial_momentum: as `identify` has it.
    """
    started = time.perf_counter()
    problem, *_ = momentum_problems(robot, recording, initial_momentum, lambda _: None)
    method = LeastSquares()
    estimate = method.estimate(problem, lambda _: None)
    masses = dict(estimate.masses)
    judgement = judge(Solved(problem, obstacles(problem), estimate, None), masses)
    elapsed = time.perf_counter() - started
    return result_of(problem, method.name, estimate, judgement, masses, None, elapsed)
