"""Suspects whose error has a course in time: steps, drifts, joints that give way."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.diagnosis.shown import less
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.model.minimal_sets import conserved_axes

SMALL = 1e-5
"""rad, rad/s or m: far below what would be seen."""

SMALL_BEND = 1e-4
"""s^2: of a joint that gives way at 16 Hz."""


def step(problem: MomentumProblem, sensor: str, row: int) -> Suspect:
    """The suspect that a sensor is off by a constant from one row on."""
    t, axes = problem.recording.t, _axes(problem, sensor)
    joint = sensor.partition(".")[2]

    def words(c: Numbers) -> str:
        size = f"a jump (a step) of {np.linalg.norm(c):.2g} (SI) at t = {t[row]:.4g} s"
        if joint:
            return f"joint {joint} slips: its position has {size}"
        return f"the {sensor} has {size}"

    return _shifted(sensor, 1.0 * (np.arange(t.size) >= row), axes, words)


def drifts(problem: MomentumProblem) -> Iterator[Suspect]:
    """Sensors whose error grows with time; a position's would be a velocity."""
    t = problem.recording.t
    elapsed = (t - t[0]) / (t[-1] - t[0])
    named = {"gyro": "the bias of the gyro", "attitude": "the attitude"}
    for sensor, what in named.items():

        def words(c: Numbers, what: str = what) -> str:
            size = np.linalg.norm(c)
            return f"{what} drifts by {size:.2g} (SI) over the recording"

        if problem.recording.has(f"{sensor}.x"):
            yield _shifted(sensor, elapsed, _axes(problem, sensor), words)


def soft_joints(problem: MomentumProblem) -> Iterator[Suspect]:
    """Encoders on the motors of joints that give way: `q_m = q + c qdd`."""
    names, t = problem.robot.joint_names, problem.samples.t
    if not names:
        return
    moved = np.column_stack(problem.samples.qd)
    seen = np.isfinite(moved).all(axis=1)
    inside = np.clip(problem.recording.t, *t[seen][[0, -1]])
    qdd = CubicSpline(t[seen], moved[seen])(inside, 1)

    def words(c: Numbers) -> str:
        k = int(np.argmax(c))
        hertz = 1 / (2 * np.pi * np.sqrt(max(c[k], SMALL**2)))
        return (
            "joints are flexible, between an encoder on the motor and the link: joint "
            f"{names[k]} gives way, as if it swung at {hertz:.2g} Hz"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        # No spring pushes the other way.
        for name, error in zip(names, (np.maximum(c, 0.0) * qdd).T, strict=True):
            recording = less(recording, f"joint.{name}", error[:, None])
        return problem.amended(recording=recording)

    yield Suspect(words, np.full(len(names), SMALL_BEND), corrected)


def _shifted(
    sensor: str,
    course: Float[np.ndarray, " n"],
    axes: Float[np.ndarray, "numbers axes"],
    words: Callable[[Numbers], str],
) -> Suspect:
    """An error of so much along each axis, times its course."""

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        changed = less(problem.recording, sensor, np.outer(course, c @ axes))
        # Samples hold the motion of joints, and only a first guess of the base's.
        if sensor.startswith("joint."):
            return problem.amended(recording=changed)
        return replace(problem, recording=changed)

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def _axes(problem: MomentumProblem, sensor: str) -> Float[np.ndarray, "axes all"]:
    """Those of a sensor in which it says something."""
    if sensor.startswith("joint."):
        return np.eye(1)
    turning, moving = conserved_axes(problem.robot)
    return np.eye(3)[list(turning if sensor in ("gyro", "attitude") else moving)]
