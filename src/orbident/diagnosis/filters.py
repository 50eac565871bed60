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

from orbident.diagnosis.noisier_sensors import UNMODELLED
from orbident.diagnosis.shifts import less, shown_by
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.diagnosis.trial import NONE, Rival, Trial, amended_trial
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.gaussian import noisiest_std
from orbident.recordings.derivatives import HALF, derivatives
from orbident.robot.sensor_schema import TrackerSpec

SMALL = np.array([1e-5, 1e-6])
"""s and s^2: far below what would be seen."""

CLEAR = 25.0
"""Times the square of the time by which samples are late: what is smoothed about its
middle, or swings, is not late, and what is late by a fifth of it may be late alone."""

LEAST = 4.0
"""A mean over fewer samples looks like noise, and a recording has at least so many."""

TINY = 1e-300
"""Less noise than any."""

Slopes = tuple[Float[np.ndarray, "n axes"], Float[np.ndarray, "n axes"]]
"""The first and the second derivative by time."""


def filters(problem: MomentumProblem) -> Iterator[Suspect]:
    """One of all joints, one of all tachometers, and one of each sensor of the base."""
    recording, robot = problem.recording, problem.robot
    for what, names in (
        ("joints", [f"joint.{name}.position" for name in robot.joint_names]),
        ("wheels", [f"wheel.{name}.speed" for name in robot.wheel_names]),
    ):
        shown = {
            name: slopes(recording.t, recording.column(name)[:, None])
            for name in names
            if recording.has(name)
        }
        if shown:
            yield _filtered(what, shown)
    for sensor in ("gyro", "position", "velocity", "attitude"):
        if recording.has(f"{sensor}.x"):
            yield _filter_of(problem, sensor)


def _filter_of(problem: MomentumProblem, sensor: str) -> Suspect:
    recording = problem.recording
    if sensor != "attitude":
        found = slopes(recording.t, recording.vector(sensor))
        return _filtered(sensor, {sensor: found})
    # The turn from what it was a moment ago is the rate by the time.
    w = np.column_stack(problem.samples.w)
    seen = np.isfinite(w).all(axis=1)
    spline = CubicSpline(problem.samples.t[seen], w[seen])
    at = np.clip(recording.t, *problem.samples.t[seen][[0, -1]])
    turning = spline(at)
    return _filtered(sensor, {sensor: (turning, slopes(at, turning)[0])})


def smoothed(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with each pose as the mean of so many samples around it.

    The mean of `n` white samples changes from one to the next by what enters and what
    leaves. So its fourth differences, `1/n` of third differences between these, show
    `sqrt(2 C(6, 3) / C(8, 4)) / n` of the noise, and what is left of it lasts for some
    `n / 2` samples.
    """
    robot, recording = problem.robot, problem.recording
    dt = float(np.median(np.diff(recording.t)))
    for sensor, samples in shown_by(robot, recording).items():
        tracker = robot.sensors.of_base.get(sensor)
        if not isinstance(tracker, TrackerSpec) or tracker.markov_std:
            continue
        x = samples[np.isfinite(samples).all(axis=1)]
        # Of an attitude twice the quaternion's, which are angles.
        shown = noisiest_std(2 * x if sensor == "attitude" else x)
        rows = np.sqrt(4 / 7) * tracker.white_noise / max(shown, TINY)
        if not LEAST <= rows <= x.shape[0] / LEAST:
            continue
        std, lasts = 3 * (tracker.white_noise / np.sqrt(rows),), 3 * (rows * dt / 2,)
        more = {"white_noise": shown, "markov_std": std, "correlation_time": lasts}
        errors = {sensor: tracker.model_copy(update=more)}
        suspect = _filter_of(problem, sensor)
        right = suspect.corrected(problem, np.array([0.0, -((rows * dt) ** 2) / 24]))
        yield amended_trial(
            f"a filter smooths the samples of the {sensor} over some {rows * dt:.2g} s "
            f"(neighbours show {tracker.white_noise / shown:.2g} times less noise than "
            "the robot file declares)",
            right,
            robot=replace(robot, sensors=robot.sensors.model_copy(update=errors)),
        )._replace(rival=UNMODELLED)


def _filtered(what: str, by_sensor: Mapping[str, Slopes]) -> Suspect:
    def rival(c: Numbers) -> Rival:
        return UNMODELLED if CLEAR * c[0] ** 2 < abs(c[1]) else NONE

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
        if what in ("joints", "wheels"):
            return problem.amended(recording=recording)
        return replace(problem, recording=recording)

    return Suspect(words, SMALL, corrected, rival=rival)


def slopes(t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"]) -> Slopes:
    """Both derivatives of samples, of which some may be missing; zero where none is."""
    first, second = np.zeros_like(x), np.zeros_like(x)
    seen = np.isfinite(x).all(axis=1)
    if seen.sum() > 2 * HALF:
        first[seen], second[seen] = derivatives(t[seen], x[seen])
    return first, second
