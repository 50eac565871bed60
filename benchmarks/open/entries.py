"""The methods that are compared: ours, the paper's, and two plain ones."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from answers import Answer
from baselines.recursive_least_squares import recursive_least_squares
from baselines.theta_filter import theta_filter

import orbident as oi
from orbident.choices import InitialMomentum, Method
from orbident.errors import InputError
from orbident.estimation.identify import METHODS
from orbident.estimation.result import Result
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies.paper_method import Filters, from_imu, from_mocap, paper_method
from orbident.trajectories.trajectory import InitialState

Entry = Callable[[Robot, Recording, InitialMomentum], Answer]


def ours(
    method: Method, robot: Robot, recording: Recording, momentum: InitialMomentum
) -> Answer:
    """A method of `identify`, as a user has it."""
    return answer_of(oi.identify(robot, recording, method, momentum))


def by_the_paper(
    robot: Robot, recording: Recording, momentum: InitialMomentum
) -> Answer:
    """The paper's: low-pass filters, Eqs. 24, 31 and 32, white noise."""
    if recording.has("accelerometer.x"):
        ready = from_imu(robot, recording, InitialState(), Filters())
    elif robot.motion == "planar":
        ready = from_mocap(robot, recording, Filters())
    else:
        return Answer(refused="the paper has no way from these sensors to a velocity")
    known = "first-sample" if momentum == "unknown" else momentum
    return answer_of(paper_method(robot, ready, known))


def answer_of(result: Result) -> Answer:
    """What a result says, without what it does not determine."""
    if result.status == "rejected":
        return Answer(refused=result.refusal())
    rows = [
        (name, value, std)
        for found in (result.pi, result.phi)
        for name, _, value, std in found
    ]
    rows.append(("M", result.mass.value, result.mass.std))
    kept = [row for row in rows if np.isfinite(row[1])]
    return Answer(
        {name: float(value) for name, value, _ in kept},
        {name: float(std) for name, _, std in kept},
    )


ENTRIES: dict[str, Entry] = {
    **{method: partial(ours, method) for method in METHODS},
    "the paper's method": by_the_paper,
    "plain recursive least squares": recursive_least_squares,
    "EKF on theta": theta_filter,
}


def timed(
    entry: Entry, robot: Robot, recording: Recording, momentum: InitialMomentum
) -> Answer:
    """An answer with its CPU seconds; input that a method does not take is refused."""
    began = time.process_time()
    try:
        answer = entry(robot, recording, momentum)
    except InputError as error:
        answer = Answer(refused=str(error))
    return replace(answer, seconds=time.process_time() - began)
