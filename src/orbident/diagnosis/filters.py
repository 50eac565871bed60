"""Suspects that a filter stands between the motion and what a sensor shows.

Of what is shown, `y`, the motion to second order in the filter's time is

    x = y + a y' + b y''

with `b = 0` behind a low-pass filter of first order, `b = a^2 / 2` where samples are
late by `a`, and `a = 0`, `b = -w^2 / 24` where each is a mean over a time `w`. On a
mount that swings at the frequency `f` it is `x = y + y'' / (2 pi f)^2`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.diagnosis.shifts import less
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.recordings.derivatives import HALF, derivatives

SMALL = np.array([1e-5, 1e-6])
"""s and s^2: far below what would be seen."""

CLEAR = 25.0
"""Times the square of the time by which samples are late: what is smoothed about its
middle, or swings, is not late, and what is late by a fifth of it may be late alone."""

Slopes = tuple[Float[np.ndarray, "n axes"], Float[np.ndarray, "n axes"]]
"""The first and the second derivative by time."""


def filters(problem: MomentumProblem) -> Iterator[Suspect]:
    """One of all joints, and one of each sensor of the base."""
    recording = problem.recording
    joints = {
        f"joint.{name}": recording.column(f"joint.{name}.position")[:, None]
        for name in problem.robot.joint_names
        if recording.has(f"joint.{name}.position")
    }
    if joints:
        yield _filtered("joints", {x: slopes(recording.t, joints[x]) for x in joints})
    for sensor in ("gyro", "position"):
        if recording.has_vector(sensor):
            of_sensor = slopes(recording.t, recording.vector(sensor))
            yield _filtered(sensor, {sensor: of_sensor})
    if recording.has("attitude.x"):
        # The turn from what it was a moment ago is the rate by the time.
        w = np.column_stack(problem.samples.w)
        seen = np.isfinite(w).all(axis=1)
        spline = CubicSpline(problem.samples.t[seen], w[seen])
        at = np.clip(recording.t, *problem.samples.t[seen][[0, -1]])
        turning = spline(at)
        yield _filtered("attitude", {"attitude": (turning, slopes(at, turning)[0])})


def _filtered(what: str, by_sensor: Mapping[str, Slopes]) -> Suspect:
    def words(c: Numbers) -> str:
        late, smooth = float(c[0]), float(c[1])
        if CLEAR * late**2 < smooth:
            f = 1 / (2 * np.pi * np.sqrt(smooth))
            return (
                f"the sensor of the {what} swings at {f:.2g} Hz beside the robot, as "
                "on a mast or a soft mount"
            )
        if CLEAR * late**2 < -smooth:
            over = np.sqrt(24 * abs(smooth))
            return f"a filter smooths the samples of the {what} over some {over:.2g} s"
        way = "late" if late > 0 else "early"
        return (
            f"the samples of the {what} are {1e3 * abs(late):.3g} ms {way}, by a "
            "filter or by the clock"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        for sensor, (first, second) in by_sensor.items():
            error = -c[0] * first - c[1] * second
            recording = less(recording, sensor, error)
        # Samples hold the motion of joints, and only a first guess of the base's.
        if what == "joints":
            return problem.amended(recording=recording)
        return replace(problem, recording=recording)

    return Suspect(words, SMALL, corrected)


def slopes(t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"]) -> Slopes:
    """Both derivatives of samples, of which some may be missing; zero where none is."""
    first, second = np.zeros_like(x), np.zeros_like(x)
    seen = np.isfinite(x).all(axis=1)
    if seen.sum() > 2 * HALF:
        first[seen], second[seen] = derivatives(t[seen], x[seen])
    return first, second
