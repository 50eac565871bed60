"""How well a result predicts a recording that was not used (Section 5.6).

The errors are judged by the likelihood ratio of two fits of all sensors of that
recording: with the result's parameters and deviations, and with parameters of its own.
To second order it is `d^T (C + C_own)^-1 d`, `d` the difference of the two sets of base
parameters, and chi-square distributed where the result is right. Momentum, biases and
the noise of every sensor, filtered or raw, are accounted for in both.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float
from pydantic import Field
from scipy.interpolate import CubicSpline

from orbident.errors import InputError
from orbident.estimation.base_parameters import exact_std
from orbident.estimation.identify import identify
from orbident.estimation.levels import ChiSquare, chi_square
from orbident.estimation.output_error.sensors import (
    TORQUES,
    joints_with_torques,
    torque_column,
)
from orbident.estimation.result import Result
from orbident.files.json_parts import JsonPart, NullableNumber
from orbident.gaussian import NINETY_FIVE, rms_of
from orbident.identified.difference import change_of_pi
from orbident.identified.prediction import (
    WINDOW,
    Prediction,
    pose_errors,
    predict,
    prediction_deviations,
)
from orbident.model.core_robot import friction_torques
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics
from orbident.preprocessing.delays import delays
from orbident.preprocessing.wrenches import recorded_thrust
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.recordings.tables import RecordingLike, recording_of

Verdict = Literal["explained", "not explained", "not judged"]

MISSED = 0.1
"""Share of the squared signal: even where a recording tells too little to judge by, a
larger squared error is no noise."""

UNSCORED = "it was not measured, or pi alone or thrust leaves it open"
"""Why a signal has no error."""

SCORED = ("gyro", "velocity")
"""The signals that are predicted."""


@dataclass(frozen=True, repr=False)
class Validation(JsonPart):
    """How well a result predicts a recording, by signal.

    Errors are NaN where the recording has nothing to compare with.
    """

    nrmse: dict[str, NullableNumber]
    """RMS of the error over the RMS of the measured signal about its mean."""
    rms: dict[str, NullableNumber]
    """RMS of the error: gyro in rad/s, velocity in m/s."""
    samples: int
    """Number of samples that were predicted."""
    std: Annotated[dict[str, NullableNumber], Field(alias="predicted_std")]
    """RMS of the predicted signals' deviations, as the parameters have theirs."""
    inside: Annotated[dict[str, NullableNumber], Field(alias="inside_95")]
    """Fraction of samples within 1.96 of these: 0.95 where the parameters alone are
    off, and less with noisy sensors, whose noise is not in it."""
    noise: dict[str, NullableNumber] = field(default_factory=dict)
    """RMS of the error that parameters fitted to this very recording leave: the
    sensors' share."""
    verdict: Verdict = "not judged"
    """Whether deviations and sensors explain the errors."""
    reason: str = ""
    chi2: NullableNumber = np.nan
    """Squared difference from the recording's own parameters, over its covariance."""
    dof: Annotated[int, Field(alias="degrees_of_freedom")] = 0
    """How many parameters are compared: what `chi2` is on average."""
    p_value: NullableNumber = np.nan
    """Probability of a larger `chi2` where the result is right."""
    pose: dict[str, NullableNumber] = field(default_factory=dict)
    """Where thrust acts: RMS of the errors of attitude and position, predicted over
    windows of five seconds, over their RMS about their means there."""
    pose_by_nominal: dict[str, NullableNumber] = field(default_factory=dict)
    """Such errors of a prediction by the robot file's bodies, thrust as recorded."""
    torques: dict[str, NullableNumber] = field(default_factory=dict)
    """Where torques of joints were recorded and the result has an `H+`, by column: RMS
    of the error, sensor noise included, over that of the torque about its mean."""
    torques_by_nominal: dict[str, NullableNumber] = field(default_factory=dict)
    """Such errors of torques by the robot file's bodies, rotors and friction."""

    def summary(self) -> list[str]:
        """The errors of every signal and what explains them, as lines of text."""
        lines = []
        units = {} if self.pose else dict(zip(SCORED, ("rad/s", "m/s"), strict=True))
        for name, unit in units.items():
            rms, std = self.rms[name], self.std[name]
            left = self.noise.get(name, np.nan)
            if not np.isfinite(rms):
                lines.append(f"{name:9} is not scored: {UNSCORED}")
                continue
            percent = f"{100 * self.nrmse[name]:.3g} % of the signal"
            lines.append(f"{name:9} error {rms:.3g} {unit} RMS, {percent}")
            if np.isfinite(std):
                sensors = f"{left:.3g} {unit}" if np.isfinite(left) else "unknown"
                lines.append(
                    f"{'':9} expected: {std:.3g} {unit} by the parameters' deviations, "
                    f"{sensors} by sensor noise (what a fit to this recording leaves)"
                )
        lines += [
            f"{name:9} error over {WINDOW:g} s: {100 * error:.3g} % of the signal, by "
            f"the robot file's numbers {100 * self.pose_by_nominal[name]:.3g} %"
            for name, error in self.pose.items()
        ]
        lines += [
            f"{name} error {100 * error:.3g} % of the signal, by the robot file's "
            f"numbers {100 * self.torques_by_nominal[name]:.3g} %"
            for name, error in self.torques.items()
        ]
        if self.dof:
            lines.append(
                f"chi-square {self.chi2:.3g} with {self.dof} degrees of freedom, "
                f"p = {self.p_value:.2g}"
            )
        return lines

    def __repr__(self) -> str:
        """The verdict, and the errors of every signal."""
        verdict = f"{self.samples} samples: {self.verdict}"
        reason = f": {self.reason}" if self.reason else ""
        return "\n".join([verdict + reason, *self.summary()])


def validate(result: Result, recording: RecordingLike) -> Validation:
    """Predict a recording's base rates and velocities, score and judge the errors.

    Where thrust is recorded, the pose is predicted over windows of five seconds, in
    which what else acts matters little.

    Args:
        result: complete and not rejected.
        recording: of the same robot, as `identify` takes it; one that the result is not
            from says most.

    Returns:
        The errors, and whether the deviations of the parameters and the noise of the
        sensors explain them.

    Raises:
        InputError: the result is rejected or has undetermined parameters, or the
            recording lacks what prediction needs.
    """
    if not isinstance(result, Result):
        raise InputError("give the result first, and then the recording")
    held = recording_of(recording)
    recording = held.read() if isinstance(held, LongRecording) else held
    thrust = any(recorded_thrust(result.robot, recording))
    scores = _of_poses(result, recording) if thrust else scored(result, recording)
    own = identify(result.robot, recording, initial_momentum=result.initial_momentum)
    if own.status == "rejected" and result.initial_momentum != "unknown":
        # What was known of one recording's momentum need not hold for another.
        own = identify(result.robot, recording)
    if own.status == "rejected":
        missed = max((x for x in scores.nrmse.values() if x == x), default=0.0)
        verdict = "not explained" if missed**2 > MISSED else "not judged"
        reason = f"of itself the recording is refused: {own.refusal()}"
        return replace(scores, verdict=verdict, reason=reason)
    scores = _compared(result, own, scores)
    phi = () if own.of_momentum_alone else own.phi.values
    complete = np.isfinite([*own.pi.values, *phi]).all()
    if thrust or not complete:
        return scores
    return replace(scores, noise=scored(own, recording).rms)


def _of_poses(result: Result, recording: Recording) -> Validation:
    """The errors of poses alone: thrust is in no other prediction."""
    result.check_model()
    pose, by_nominal = {}, {}
    if np.isfinite(result.base.values).all() and not result.robot.passive:
        pose, by_nominal = pose_errors(result, recording)
    none: dict[str, NullableNumber] = dict.fromkeys(SCORED, np.nan)
    return Validation(
        nrmse=none,
        rms=none,
        samples=recording.t.size,
        std=none,
        inside=none,
        pose=pose,
        pose_by_nominal=by_nominal,
    )


def _compared(result: Result, own: Result, scores: Validation) -> Validation:
    """Compare the base parameters that both determine, or `pi` where that is all."""
    if result.of_momentum_alone or own.of_momentum_alone:
        return _judged(change_of_pi(result, own), "", scores)
    both = np.isfinite(result.base.values) & np.isfinite(own.base.values)
    exact = exact_std(result.robot, minimal_sets(result.robot))[both]
    C = (result.base_covariance + own.base_covariance)[np.ix_(both, both)]
    d = (own.base.values - result.base.values)[both]
    C += np.diag(exact**2)
    sigmas = np.abs(d) / np.sqrt(np.diag(C))
    worst = int(np.argmax(sigmas))
    name = np.array(result.base.names)[both][worst]
    words = f": {name} by {sigmas[worst]:.2g} combined standard deviations"
    return _judged(chi_square(d, C), words, scores)


def _judged(apart: ChiSquare, worst: str, scores: Validation) -> Validation:
    """Whether chance explains how far the parameters are apart."""
    reason = (
        "the parameters agree with those that this recording alone would give, "
        "within the standard deviations of both"
    )
    verdict = "explained"
    if apart.is_no_chance("validation"):
        reason = (
            "the parameters differ from those that this recording alone would give by "
            f"more than chance{worst}; the robot may have changed, or one of the two "
            "recordings or its deviations are wrong"
        )
        verdict = "not explained"
    found = {"chi2": apart.value, "dof": apart.dof, "p_value": apart.p}
    return replace(scores, verdict=verdict, reason=reason, **found)


def scored(result: Result, recording: Recording) -> Validation:
    """Predict a recording's base rates and velocities, and score the errors only.

    Raises:
        InputError: the result has undetermined parameters, or the recording lacks what
            prediction needs.
    """
    prediction = predict(result, recording)
    axes_h, axes_v = result.robot.conserved_axes
    measured = prediction.measured
    w_std, v_std = prediction_deviations(result, prediction)
    # Each with what was measured, the error, and its deviation by the parameters.
    gyro = np.array([measured.w, prediction.w - measured.w, w_std])
    velocity = np.array([measured.v_S, prediction.v_S - measured.v_S, v_std])
    signals = {
        "gyro": gyro[..., axes_h],
        "velocity": velocity[:, measured.moving][..., axes_v],
    }
    rms = {name: rms_of(error) for name, (_, error, _) in signals.items()}
    size = {
        name: rms_of(x - x.mean(axis=0)) if len(x) else np.nan
        for name, (x, _, _) in signals.items()
    }
    own, by_nominal = dict[str, NullableNumber](), dict[str, NullableNumber]()
    recording = recording.with_joints_of(result.robot)
    if joints_with_torques(result.robot, recording):
        nominal = Dynamics(result.robot, np.zeros((0, 0)))
        scale = {name: each.value for name, each in result.calibration.items()}
        by_nominal = _of_torques(nominal, {}, prediction, recording)
        # A result may be accepted though H+ is not definite, within its deviations.
        with suppress(InputError):
            own = _of_torques(result.dynamics(), scale, prediction, recording)
    return Validation(
        nrmse={name: rms[name] / size[name] if size[name] else np.nan for name in rms},
        rms=rms,
        samples=prediction.t.size,
        std={name: rms_of(std) for name, (*_, std) in signals.items()},
        inside={name: _inside(error, std) for name, (_, error, std) in signals.items()},
        torques=own,
        torques_by_nominal=by_nominal,
    )


def _of_torques(
    model: Dynamics,
    errors: Mapping[str, float],
    prediction: Prediction,
    recording: Recording,
) -> dict[str, NullableNumber]:
    """The errors of torques by inverse dynamics along the measured motion.

    Errors of instruments are by name: what torque sensors scale by is among them.
    """
    robot, t, seen = model.robot, prediction.t, prediction.measured
    measured = seen.q, seen.qd, seen.w, seen.qd_rw
    q, qd, w, qd_rw = (CubicSpline(t, each) for each in measured)
    at = recording.t - delays(robot, recording, {})[TORQUES]
    inside = (t[0] <= at) & (at <= t[-1])
    at = at[inside]
    rates = qd(at)
    tau = model.torques(
        q(at), rates, qd(at, 1), w=w(at), qd_rw=qd_rw(at), qdd_rw=qd_rw(at, 1)
    )
    tau += friction_torques(robot, rates)
    found = dict[str, NullableNumber]()
    for name in joints_with_torques(robot, recording):
        k, column = robot.joint_names.index(name), torque_column(name)
        shown = recording.columns[column][inside]
        some = np.isfinite(shown)
        size = np.std(shown[some]) if some.any() else 0.0
        scale = 1 + errors.get(f"joint.{name}.torque_scale", 0.0)
        off = rms_of((scale * tau[:, [k]] - shown[:, None])[some])
        found[column] = off / float(size) if size else np.nan
    return found


def _inside(
    errors: Float[np.ndarray, "n axes"], std: Float[np.ndarray, "n axes"]
) -> float:
    if not (len(errors) and np.isfinite(std).all()):
        return np.nan
    return float(np.mean(np.abs(errors) <= NINETY_FIVE * std))
