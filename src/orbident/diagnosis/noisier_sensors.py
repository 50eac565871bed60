"""Is a sensor noisier than the robot file says, or does a gyro's bias wander?

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
from orbident.diagnosis.trial import NONE, Rival, Trial, amended_trial
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.gaussian import OF_MEDIAN, noisiest_std
from orbident.robot.sensor_schema import InertialSpec, Sampled
from orbident.threads import processors

NOISIER = 1.5
"""Times the declared noise."""

UNMODELLED = Rival(np.inf, "something slow acts or moves in the robot")
"""So free a bias explains much that is none."""

WANDERS = 100.0
"""Times the declared walk of a bias: what it needs is found by the fit."""

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


def wandering(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with a gyro whose bias may walk freely."""
    gyro = problem.robot.sensors.gyro
    if not problem.recording.has("gyro.x") or not (gyro and gyro.bias_instability):
        return
    walk = {"bias_instability": WANDERS * gyro.bias_instability}
    words = (
        "the bias of the gyro drifts far more than the robot file declares: with one "
        "that may walk 100 times as far"
    )
    found = _trial(words, problem, {"gyro": gyro.model_copy(update=walk)})
    if found.accepted:
        yield found._replace(rival=UNMODELLED)


class Lasting(NamedTuple):
    """Errors of a tracker that last, as its residuals do."""

    sensor: str
    size: float
    """rad or m."""
    time: float
    """s: after it `1 / e` of their covariance is left."""
    gain: float
    """What the likelihood gains by it, twice its logarithm, about."""
    price: float
    """What must be gained, as each such time of the recording needs a number of its own
    on each axis (Schwarz 1978)."""

    @property
    def words(self) -> str:
        """What it is, a clause."""
        return (
            f"the {self.sensor} has lasting errors of {self.size:.2g} (SI), each over "
            f"some {self.time:.2g} s"
        )


def lasting(problem: MomentumProblem, shown: Estimate) -> Lasting | None:
    """The tracker whose residuals are most like errors that last, if any is.

    Args:
        problem: of a recording.
        shown: how it is fitted.
    """
    sensors, found = problem.robot.sensors, list[Lasting]()
    trackers = {"attitude": sensors.attitude, "position": sensors.position}
    for signal in shown.signals:
        tracker = trackers.get(signal.name)
        if tracker is None or tracker.markov_std or signal.t.size < AROUND:
            continue
        r = signal.measured - signal.predicted
        lags = range(1, signal.t.size // 4)
        covariance = np.array([np.mean(r[k:] * r[:-k]) for k in lags])
        alike = covariance[0] / np.mean(r**2)
        if alike < WHITE:
            continue
        row = float(np.median(np.diff(signal.t)))
        time = row * float(1 + np.argmax(covariance < covariance[0] / np.e))
        numbers = r.shape[1] * float(np.ptp(signal.t)) / time
        price = numbers * float(np.log(problem.samples.t.size))
        size, gain = (
            float(np.sqrt(covariance[0])),
            -r.size * float(np.log1p(-(alike**2))),
        )
        found.append(Lasting(signal.name, size, time, gain, price))
    return max(found, key=lambda each: each.gain - each.price, default=None)


def with_lasting(problem: MomentumProblem, errors: Lasting) -> Iterator[Trial]:
    """Identify again with a tracker whose errors last."""
    tracker = problem.robot.sensors.of(errors.sensor)
    more = {
        "markov_std": 3 * (errors.size,),
        "correlation_time": 3 * (errors.time,),
    }
    amended = {errors.sensor: tracker.model_copy(update=more)}
    found = _trial(errors.words, problem, amended)
    rival = UNMODELLED if found.accepted else NONE
    yield found._replace(misfit=found.misfit + errors.price, rival=rival)


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
