"""Short recordings of a robot in space with something wrong, ready to be identified."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from clean_recordings import Recorded, clean_space
from edited_recordings import changed

from orbident.diagnosis.suspects import Scores, Suspect
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.identify import estimator_of
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

SECONDS = 30.0


@cache
def clean() -> Recorded:
    return clean_space(seed=1, duration=SECONDS)


def problem_with(
    columns: Mapping[str, Callable[[np.ndarray], np.ndarray]] | None = None,
    robot: Robot | None = None,
) -> MomentumProblem:
    """The clean recording with some columns changed, or another robot file."""
    recording = clean().recording
    new = {
        name: change(recording.columns[name])
        for name, change in (columns or {}).items()
    }
    return momentum_problem(
        robot or clean().robot, changed(recording, new), "unknown", lambda _: None
    )


def fitted(problem: MomentumProblem) -> Estimate:
    return estimator_of("maximum-likelihood").estimate(problem, lambda _: None)


def solved(problem: MomentumProblem) -> Solved:
    shown = fitted(problem)
    return Solved(problem, [], shown, shown)


def with_joint(k: int, **changes) -> Robot:
    """The robot with one joint that is not as described."""
    robot = clean().robot
    joints = list(robot.joints)
    joints[k] = replace(joints[k], **changes)
    return replace(robot, joints=tuple(joints))


def with_recording(recording: Recording) -> MomentumProblem:
    """The problem of a recording that was changed from the clean one."""
    return problem_with(
        {name: lambda _, x=x: x for name, x in recording.columns.items()}
    )


def numbers(problem: MomentumProblem, suspect: Suspect) -> np.ndarray:
    """Those of a suspect that explain most, to first order."""
    solution = fitted(problem).solution
    assert solution is not None
    (found,) = Scores(problem, solution).of([suspect])
    return found.values
