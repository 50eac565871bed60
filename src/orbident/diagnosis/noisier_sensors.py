"""Is a sensor noisier than the robot file says, or do its errors last longer?

Single samples that are off what their neighbours show: spikes within the motion.

Screening leaves out only what leaps out of the motion. What is smaller than the steps
of a joint that moves is far beyond noise all the same.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import maximum_filter1d, median_filter

from orbident import _core
from orbident.diagnosis.shifts import shown_by, without
from orbident.diagnosis.trial import Rival, Trial, amended_trial
from orbident.estimation.clock_search import WORTH
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.gaussian import OF_MEDIAN, noisiest_std
from orbident.robot.sensor_schema import InertialSpec, Sampled, TrackerSpec
from orbident.threads import processors

NOISIER = 1.5
"""Times the declared noise."""

UNMODELLED = Rival(np.inf, "something slow acts or moves in the robot")
"""So free a bias explains much that is none."""

WANDERS = 100.0
"""Times the declared walk of a bias: what it needs of that the fit estimates."""

WHITE = 0.1
"""Correlation of neighbouring residuals below which nothing lasts."""


def noisier_sensors(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with the noise that neighbouring samples show, of all sensors."""
    tables = shown_by(problem.robot, problem.recording)
    joints = [x for name, x in tables.items() if name.startswith("joint.")]
    if joints:
        tables["joints"] = np.hstack(joints)
    declared = problem.robot.sensors
    words, amended = list[str](), dict[str, Sampled]()
    for name, sensor in {**declared.of_base, "joints": declared.joints}.items():
        if name not in tables or sensor is None or not sensor.white_noise:
            continue
        x = tables[name][np.isfinite(tables[name]).all(axis=1)]
        # Of an attitude twice the quaternion's, which are angles.
        shown = noisiest_std(2 * x if name == "attitude" else x)
        white = sensor.white_noise
        if isinstance(sensor, InertialSpec):
            white = sensor.white_std(float(np.median(np.diff(problem.recording.t))))
        if shown > NOISIER * white:
            words.append(f"of the {name} is {shown:.2g} (SI), {shown / white:.2g}")
            more = {"white_noise": shown * sensor.white_noise / white}
            amended[name] = sensor.model_copy(update=more)
    if amended:
        cause = f"the noise {', that '.join(words)} times what the robot file declares"
        yield _trial(cause, problem, amended)._replace(seen=True)


class Lasting(NamedTuple):
    """Errors of a sensor that last longer than the robot file says."""

    words: str
    """What it is, a clause."""
    sensors: Mapping[str, Sampled]
    """The sensor with a noise that lasts so."""
    gain: float
    """What the likelihood of the residuals gains by it, twice its logarithm."""
    numbers: float
    """How many the fit has for it: one for each such time, on each axis."""


def lasting(problem: MomentumProblem, shown: Estimate) -> list[Lasting]:
    """The sensors whose errors may be what lasts in the residuals, the likeliest first.

    A tracker's own residuals last where its errors do, and those of all trackers where
    the bias of a gyro walks.

    Args:
        problem: of a recording.
        shown: how it is fitted.
    """
    sensors, found = problem.robot.sensors, list[Lasting]()
    for signal in shown.signals:
        tracker = sensors.of(signal.name)
        if not isinstance(tracker, TrackerSpec) or signal.t.size < AROUND:
            continue
        r = signal.measured - signal.predicted
        lags = range(1, signal.t.size // 4)
        covariance = np.array([np.mean(r[k:] * r[:-k]) for k in lags])
        part = float(covariance[0] / np.mean(r**2))
        if tracker.markov_std or part < WHITE:
            continue
        rows = float(1 + np.argmax(covariance < covariance[0] / np.e))
        time = rows * float(np.median(np.diff(signal.t)))
        size = float(np.sqrt(covariance[0]))
        more = {"markov_std": 3 * (size,), "correlation_time": 3 * (time,)}
        found.append(
            Lasting(
                f"the {signal.name} has lasting errors of {size:.2g} (SI), each over "
                f"some {time:.2g} s",
                {signal.name: tracker.model_copy(update=more)},
                _gain(r, part, rows),
                r.shape[1] * float(np.ptp(signal.t)) / time,
            )
        )
    gyro = sensors.gyro
    if found and problem.recording.has("gyro.x") and gyro and gyro.bias_instability:
        walk = {"bias_instability": WANDERS * gyro.bias_instability}
        found.append(
            Lasting(
                "the bias of the gyro drifts far more than the robot file declares",
                {"gyro": gyro.model_copy(update=walk)},
                sum(each.gain for each in found),
                max(each.numbers for each in found),
            )
        )
    return sorted(found, key=lambda each: -each.gain)


def _gain(r: Float[np.ndarray, "n axes"], part: float, rows: float) -> float:
    """What the likelihood gains where a part of noise is correlated over some rows.

    The periodogram at each frequency is that of the noise times a variable of its own
    (Whittle 1953). Noise of which a part is `a` times what it was a row before has

        S = (1 - part) + part (1 - a^2) / |1 - a exp(-i w)|^2.
    """
    n, a = len(r), np.exp(-1 / rows)
    w = 2 * np.pi * np.arange(1, n // 2 + 1)[:, None] / n
    shown = np.abs(np.fft.rfft(r, axis=0)[1:]) ** 2 / (n * np.mean(r**2, axis=0))
    S = 1 - part + part * (1 - a**2) / np.abs(1 - a * np.exp(-1j * w)) ** 2
    return float(2 * np.sum(shown - shown / S - np.log(S)))


def lasting_errors(problem: MomentumProblem, shown: Estimate | None) -> Iterator[Trial]:
    """Identify again with each sensor whose errors may last; none without a fit.

    What lasts explains much of anything: where that is not all, it says nothing.
    """
    one = float(np.log(problem.samples.t.size))
    for errors in lasting(problem, shown) if shown else ():
        # Its size and its time are what the residuals gave.
        if errors.gain - 2 * one > WORTH:
            found = _trial(errors.words, problem, errors.sensors)
            if found.accepted:
                price = errors.numbers * one
                yield found.with_price(price)._replace(rival=UNMODELLED)


def _trial(
    cause: str, problem: MomentumProblem, sensors: Mapping[str, Sampled]
) -> Trial:
    """Identify again with these sensors declared in place of the robot file's."""
    robot = problem.robot
    amended = robot.sensors.model_copy(update=sensors)
    return amended_trial(cause, problem, replace(robot, sensors=amended))


OFF = 8.0
"""Times the scatter of what neighbours predict."""

AROUND, NEIGHBOURS = 101, 5
"""Samples that tell the scatter, and that one spike spoils."""

ROUNDS = 8
"""Rounds, at most; each leaves out samples that are the worst of their neighbours."""

MOST = 0.1
"""Part of a sensor's samples: more are no exceptions."""


def spikes(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again without such samples."""
    left, found = problem.recording, dict[str, int]()
    for sensor, shown in shown_by(problem.robot, problem.recording).items():
        off = np.logical_or.reduce([outlying(left.t, x) for x in shown.T])
        if 0 < off.sum() < MOST * off.size:
            left, found[sensor] = without(left, sensor, off), int(off.sum())
    if not found:
        return
    which = max(found, key=lambda sensor: found[sensor])
    words = (
        f"spikes (outliers): {found[which]} samples of {which.replace('.', ' ')} are "
        "far from what their neighbours show"
    )
    yield amended_trial(words, problem, recording=left)


def outlying(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """Samples that a cubic through two neighbours on either side does not expect."""
    kept, off = np.flatnonzero(np.isfinite(x)), np.zeros(x.size, dtype=bool)
    for _ in range(ROUNDS):
        if kept.size < AROUND:
            break
        inner = kept[2:-2]
        # At the ends all neighbours would be on one side.
        expected = _core.expected_samples(t[kept], x[kept], 1, processors())
        r = np.abs(x[inner] - expected[2:-2])
        worst = (r == maximum_filter1d(r, NEIGHBOURS)) & (
            r > OFF * OF_MEDIAN * median_filter(r, AROUND)
        )
        if not worst.any():
            break
        off[inner[worst]] = True
        kept = kept[~off[kept]]
    return off
