"""The pose that identified parameters predict over some seconds, thrust included.

A recording is cut into windows. In each of them the momentum, the velocity of the CM,
the first pose and the sensors' biases are those that fit best: they belong to the
manoeuvre, not to the robot. Parameters and errors of instruments are held at what is
given, and nothing acts but recorded thrust.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.output_error.beforehand import prior_of
from orbident.estimation.output_error.problem import (
    NOTHING,
    linear,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensors import sensors_of
from orbident.estimation.output_error.solver import solved
from orbident.estimation.result import Result
from orbident.estimation.solution import OUTSIDE
from orbident.model.minimal_sets import conserved_axes, minimal_sets
from orbident.preprocessing.delays import corrections, delays
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import Settings
from orbident.recordings.recording import Recording
from orbident.robot.description import MomentumWalk, Robot

POSE = ("attitude", "position")

WINDOW = 5.0
"""s: several pulses of valves that open for a second, and little of what else acts."""

Errors = Float[np.ndarray, "samples axes"]

HELD = 1e-6
"""Part of its size within which a number that is given may move."""


class PoseErrors(NamedTuple):
    """RMS of a predicted pose's error over that of the pose about its mean, by sensor.

    Of all windows together, and only of sensors that were recorded.
    """

    identified: dict[str, float]
    nominal: dict[str, float]
    """The same with the robot file's bodies, and thrust as it was recorded."""


def pose_errors(result: Result, recording: Recording) -> PoseErrors:
    """How well a result predicts the pose over windows of five seconds.

    Args:
        result: with all of its base parameters.
        recording: of the same robot.
    """
    robot, sets = result.robot, minimal_sets(result.robot)
    errors = {name: each.value for name, each in result.calibration.items()}
    late = corrections(result.clocks)
    nominal = sets.beta(robot.theta)
    return PoseErrors(
        _relative(robot, result.base.values, errors, recording, late),
        _relative(robot, nominal, {}, recording, late),
    )


def _relative(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    errors: Mapping[str, float],
    recording: Recording,
    late: Mapping[str, float],
) -> dict[str, float]:
    alone = replace(robot, disturbances={}, momentum_walk=MomentumWalk())
    clean = cleaned(alone, recording, Settings()).recording
    off: dict[str, float] = dict.fromkeys(POSE, 0.0)
    size = off.copy()
    for window in _windows(clean):
        # Where a window has too few samples, it has none to compare with.
        with suppress(InputError):
            for name, error, about in _predicted(alone, beta, errors, window, late):
                off[name] += float(np.sum(error**2))
                size[name] += float(np.sum(about**2))
    return {name: float(np.sqrt(off[name] / size[name])) for name in POSE if size[name]}


def _windows(recording: Recording) -> Iterator[Recording]:
    count = int((recording.t[-1] - recording.t[0]) / WINDOW)
    for k in range(count):
        start = recording.t[0] + k * WINDOW
        yield recording.between(start, start + WINDOW)


def _predicted(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    errors: Mapping[str, float],
    window: Recording,
    late: Mapping[str, float],
) -> Iterator[tuple[str, Errors, Errors]]:
    """Errors of a window's pose, and the pose about its mean, along free axes."""
    sets = minimal_sets(robot)
    sensors = sensors_of(robot, window, delays(robot, window, late))
    samples = samples_of(robot, window, late)
    problem = problem_of(robot, sets, samples, sensors)
    chosen = tuple(each for each in problem.instruments if each.name in errors)
    start = start_of(problem, samples, NOTHING, beta).carried(
        np.array([each.place for each in chosen])
    )
    values = np.array([errors[each.name] for each in chosen])
    start.common[start.common.size - values.size :] = values
    prior = prior_of(robot, sets, chosen, NOTHING, None)
    given = np.concatenate([beta, values])
    prior.values[OUTSIDE:] = given
    prior.std[OUTSIDE:] = HELD * np.maximum(np.abs(given), HELD)
    # What scales said is in what is given.
    prior = prior._replace(measured=prior.measured[:0])
    found = solved(problem, problem.weights, prior, start)
    residuals = linear(problem, problem.weights, found.state).residuals
    turning, moving = conserved_axes(robot)
    for name, axes in zip(POSE, (turning, moving), strict=True):
        if name in residuals:
            seen = problem.weights[name][:, axes[0]] > 0
            error = residuals[name][seen][:, axes] * sensors.by_name[name].std
            x = problem.samples[name][seen]
            if name == "attitude":
                turned = Rotation.from_quat(x)
                x = (turned.mean().inv() * turned).as_rotvec()
            yield name, error, (x - x.mean(axis=0))[:, axes]
