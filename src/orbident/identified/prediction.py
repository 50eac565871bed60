"""The motion that identified parameters predict, from joint and wheel histories alone.

With `pi` known, `D` and `D_q qd` are `Y pi` at unit and at zero base rate (Eq. 16): the
base rate follows from conservation, and `phi` gives the velocity of S (Eq. 30). No
nominal inertia is used.

How far a prediction may be off, as the identified parameters may be off.

To first order in `beta`, along each column of a root of its covariance. With `b = R_0^T
h_cm` and `f` the turn by which the predicted attitude is off, base axes:

    D dw = R_0^T dh_cm - dY pi + b x f,   f' = dw - w x f,   f(0) = 0
    dv_S = R_0 (f x W phi + d(W phi)/dw dw + W dphi) + dv_cm

The constants of the motion are means over the recording (see `predict`), and so are
their derivatives. The noise of what was measured is not in it.

Of the pose over some seconds, thrust included, a recording is cut into windows. In each
of them the momentum, the velocity of the CM, the first pose and the sensors' biases are
those that fit best: they belong to the manoeuvre, not to the robot. Parameters and
errors of instruments are held at what is given, and nothing acts but recorded thrust.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
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
from orbident.files.names import joined
from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import (
    MinimalSets,
    Regressors,
    minimal_sets,
)
from orbident.model.reconstruction import root_of
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.delays import corrections, delays
from orbident.preprocessing.followers import without_followers
from orbident.preprocessing.samples import Batch, samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import Settings
from orbident.preprocessing.wrenches import recorded_thrust
from orbident.recordings.recording import Recording
from orbident.robot.description import MomentumWalk, Robot
from orbident.robot.joint_schema import require_measured
from orbident.robot.parameters import cross_matrix
from orbident.simulation.free_floating import RateLaw, float_attitude, rate_law

TOLERANCE = 1e-8
"""The error of the predicted attitude, rad: below what any sensor sees."""

PART = 512
"""Samples whose regressors are in memory at once."""


class Prediction(NamedTuple):
    """What was measured, and what the identified parameters predict."""

    t: Float[np.ndarray, " n"]
    measured: Batch
    """Only samples in which all that prediction needs was measured."""
    w: Float[np.ndarray, "n 3"]
    """Predicted base rate, base axes, rad/s."""
    v_S: Float[np.ndarray, "n 3"]
    """Predicted velocity of S, inertial axes, m/s."""
    x_WB: Float[np.ndarray, "n 4"]
    """Predicted attitude."""


def predict(result: Result, recording: Recording) -> Prediction:
    """Run the identified model along a recording's joint and wheel histories.

    The first attitude is taken from the recording, and so are the constants of the
    motion, momentum and CM velocity, as means over all samples: they belong to the
    manoeuvre, not to the robot. Everything else is predicted: by `pi` alone, turns.

    Raises:
        InputError: the result has undetermined parameters, or the recording lacks what
            prediction needs, or has thrust.
    """
    result.check_accepted()
    _check_complete(result)
    robot, sets = result.robot, minimal_sets(result.robot)
    if any(recorded_thrust(robot, recording)):
        raise InputError(
            f"{recording.source}: thrust acts, and this prediction is of what floats "
            "free; 'orbident validate' predicts poses over some seconds"
        )
    require_measured(robot, "prediction", "identify every recording by itself")
    _check_sizes(result, sets)
    # Clocks are the laboratory's, not the recording's.
    clean = cleaned(robot, recording, Settings()).recording
    t, measured = samples_of(robot, clean, corrections(result.clocks)).complete()
    if t.size < 4:
        raise InputError(
            f"{recording.source}: {t.size} complete samples; prediction needs at least "
            "4 with joints, wheels, gyro and attitude all measured"
        )

    wheels = wheels_of(robot)
    conserved = np.isin(np.arange(3), sets.regressors.momentum_axes)
    known = sets.regressors, result.pi.values, result.phi.values
    at = momentum_terms(*known, measured.q, measured.qd)
    R_WB = quaternion_matrix(measured.x_WB)
    h_B = rotate(at.D, measured.w) + at.h_q + measured.qd_rw @ wheels.A_rw.T
    h_cm = np.where(conserved, rotate(R_WB, h_B).mean(axis=0), 0.0)
    moving, v_cm = measured.moving, np.zeros(3)
    if moving.any():
        v = rotate(R_WB, rotate(at.V, measured.w) + at.v_q)
        v_cm = (measured.v_S - v)[moving].mean(axis=0)

    joints = len(robot.joints)
    spline = CubicSpline(t, np.hstack([measured.q, measured.qd, measured.qd_rw]))

    def law_at(nodes: Float[np.ndarray, " m"]) -> RateLaw:
        q, qd, qd_rw = np.split(spline(nodes), [joints, 2 * joints], axis=1)
        at = momentum_terms(*known, q, qd)
        h_moving = at.h_q + qd_rw @ wheels.A_rw.T
        return rate_law(at.D, h_moving, robot.motion == "planar")

    x_WB, law, _, _ = float_attitude(law_at, t, h_cm, measured.x_WB[0], TOLERANCE)
    w = law.rate(x_WB, np.broadcast_to(h_cm, (t.size, 3)))
    v = rotate(quaternion_matrix(x_WB), rotate(at.V, w) + at.v_q)
    return Prediction(t, measured, w, v + v_cm, x_WB)


class MomentumTerms(NamedTuple):
    """The identified momentum and velocity at some joint states, base axes.

    `h_rs = D w + h_q` and, relative to the system CM, `v_S = V w + v_q`; zero in axes
    in which momentum is not conserved.
    """

    D: Float[np.ndarray, "n 3 3"]
    h_q: Float[np.ndarray, "n 3"]
    V: Float[np.ndarray, "n 3 3"]
    v_q: Float[np.ndarray, "n 3"]


def momentum_terms(
    regressors: Regressors,
    pi: Float[np.ndarray, " pi"],
    phi: Float[np.ndarray, " phi"],
    q: Float[np.ndarray, "n joints"],
    qd: Float[np.ndarray, "n joints"],
) -> MomentumTerms:
    """`Y pi` and `W phi` at unit base rates and at the joints' rates (Eq. 16)."""
    known = regressors, pi, phi
    rest, w = np.zeros_like(q), np.zeros((len(q), 3))
    h_q, v_q = _momentum_and_velocity(*known, q, qd, w)
    D, V = np.zeros((2, len(q), 3, 3))
    for k in regressors.momentum_axes:
        unit = w + np.eye(3)[k]
        D[..., k], V[..., k] = _momentum_and_velocity(*known, q, rest, unit)
    return MomentumTerms(D, h_q, V, v_q)


def _momentum_and_velocity(
    regressors: Regressors,
    pi: Float[np.ndarray, "pi ..."],
    phi: Float[np.ndarray, "phi ..."],
    q: Float[np.ndarray, "n joints"],
    qd: Float[np.ndarray, "n joints"],
    w: Float[np.ndarray, "n 3"],
) -> tuple[Float[np.ndarray, "n 3 ..."], Float[np.ndarray, "n 3 ..."]]:
    """`Y pi` and `W phi`, or their changes along the columns of a root."""
    h, v = np.zeros((2, len(q), 3, *pi.shape[1:]))
    # By parts: a regressor may have hundreds of columns a sample.
    for start in range(0, len(q), PART):
        part = slice(start, start + PART)
        Y, W = regressors(q[part], qd[part], w[part])
        h[part, list(regressors.momentum_axes)] = Y @ pi
        v[part, list(regressors.velocity_axes)] = W @ phi
    return h, v


def _check_sizes(result: Result, sets: MinimalSets) -> None:
    found = result.pi.values.size, result.phi.values.size
    needed = sets.pi_of_beta.shape[0], sets.base.sigmas
    if found != needed:
        raise InputError(
            f"the result has {found[0]} pi and {found[1]} phi, but robot "
            f"'{result.robot.name}' has {needed[0]} and {needed[1]}; identify again"
        )


def _check_complete(result: Result) -> None:
    known = {"pi": result.pi} | (
        {} if result.of_momentum_alone else {"phi": result.phi}
    )
    for name, estimates in known.items():
        missing = np.flatnonzero(~np.isfinite(estimates.values))
        unknown = [estimates.names[k] for k in missing]
        if unknown:
            raise InputError(
                f"the result does not determine {joined(unknown)}, so {name} cannot "
                "predict; identify from a recording that does (see its warnings)"
            )


def prediction_deviations(
    result: Result, prediction: Prediction
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """The standard deviations of what was predicted; NaN without a covariance.

    Those of the base rate are along base axes, rad/s, and those of the velocity of S
    along inertial axes, m/s.
    """
    robot, sets = result.robot, minimal_sets(result.robot)
    changes = partial(_momentum_and_velocity, sets.regressors, *_changed(result, sets))
    seen = prediction.measured
    R = quaternion_matrix(seen.x_WB)
    dh, dv = changes(seen.q, seen.qd, seen.w)
    dh_cm = (R @ dh).mean(axis=0)
    moving = seen.moving if seen.moving.any() else np.ones(seen.moving.size, bool)
    dv_cm = -(R @ dv)[moving].mean(axis=0)

    known = sets.regressors, result.pi.values, result.phi.values
    at = momentum_terms(*known, seen.q, seen.qd)
    w, R = prediction.w, quaternion_matrix(prediction.x_WB)
    dh, dv = changes(seen.q, seen.qd, w)
    b = rotate(at.D, w) + at.h_q + seen.qd_rw @ wheels_of(robot).A_rw.T
    conserved = np.isin(np.arange(3), sets.regressors.momentum_axes)
    D = at.D + np.diag(~conserved)
    # dw = dw_0 + B f; in the plane neither tilts.
    dw_0 = np.linalg.solve(D, np.swapaxes(R, 1, 2) @ dh_cm - dh) * conserved[:, None]
    B = np.linalg.solve(D, cross_matrix(b)) * conserved[:, None]
    f = _turns(prediction.t, B - cross_matrix(w), dw_0)
    dw = dw_0 + B @ f
    v = rotate(at.V, w) + at.v_q
    off = at.V @ dw + dv - cross_matrix(v) @ f
    dv = R @ off + dv_cm
    return np.linalg.norm(dw, axis=2), np.linalg.norm(dv, axis=2)


def _changed(
    result: Result, sets: MinimalSets
) -> tuple[Float[np.ndarray, "pi n"], Float[np.ndarray, "phi n"]]:
    """Roots of the covariances of `pi` and `phi`, by the same errors; NaN without."""
    if result.of_momentum_alone:
        n = result.pi.values.size
        root = root_of(result.covariance[:n, :n])
        return root, np.full((sets.base.sigmas, n), np.nan)
    root = root_of(result.base_covariance)
    dpi, dphi = sets.derivatives(result.base.values)
    return dpi @ root, dphi @ root


def _turns(
    t: Float[np.ndarray, " n"],
    A: Float[np.ndarray, "n 3 3"],
    c: Float[np.ndarray, "n 3 r"],
) -> Float[np.ndarray, "n 3 r"]:
    """`f' = A f + c` from zero, by the trapezoidal rule: stable, of second order."""
    f, eye = np.zeros_like(c), np.eye(3)
    for k, half in enumerate(np.diff(t) / 2):
        known = f[k] + half * (A[k] @ f[k] + c[k] + c[k + 1])
        f[k + 1] = np.linalg.solve(eye - half * A[k + 1], known)
    return f


POSE = ("attitude", "position")

WINDOW = 5.0
"""s: several pulses of valves that open for a second, and little of what else acts."""

Errors = Float[np.ndarray, "samples axes"]

HELD = 1e-6
"""Part of its size within which a number that is given may move."""


def pose_errors(
    result: Result, recording: Recording
) -> tuple[dict[str, float], dict[str, float]]:
    """How well a result predicts the pose over windows of five seconds.

    RMS of a predicted pose's error over that of the pose about its mean, by sensor: of
    all windows together, and only of sensors that were recorded. Then such errors by
    the robot file's bodies in place of the identified ones, and thrust as it was
    recorded. The result has all of its base parameters.
    """
    robot = replace(result.robot, disturbances={}, momentum_walk=MomentumWalk())
    clean = cleaned(robot, recording, Settings()).recording
    errors = {name: each.value for name, each in result.calibration.items()}
    late = corrections(result.clocks)
    nominal = minimal_sets(robot).beta(robot.theta)
    return (
        _relative(robot, result.base.values, errors, clean, late),
        _relative(robot, nominal, {}, clean, late),
    )


def _relative(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    errors: Mapping[str, float],
    clean: Recording,
    late: Mapping[str, float],
) -> dict[str, float]:
    off: dict[str, float] = dict.fromkeys(POSE, 0.0)
    size = off.copy()
    for k in range(int((clean.t[-1] - clean.t[0]) / WINDOW)):
        start = clean.t[0] + k * WINDOW
        window = clean.between(start, start + WINDOW)
        # Where a window has too few samples, it has none to compare with.
        with suppress(InputError):
            for name, error, about in _predicted(robot, beta, errors, window, late):
                off[name] += float(np.sum(error**2))
                size[name] += float(np.sum(about**2))
    return {name: float(np.sqrt(off[name] / size[name])) for name in POSE if size[name]}


def _predicted(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    errors: Mapping[str, float],
    window: Recording,
    late: Mapping[str, float],
) -> Iterator[tuple[str, Errors, Errors]]:
    """Errors of a window's pose, and the pose about its mean, along free axes."""
    sets = minimal_sets(robot)
    samples = samples_of(robot, window, late)
    behind = delays(robot, window, late)
    window = without_followers(window, samples.led)
    sensors = sensors_of(robot, window, behind, samples.speeds)
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
    turning, moving = robot.conserved_axes
    for name, axes in zip(POSE, (turning, moving), strict=True):
        if name in residuals:
            seen = problem.weights[name][:, axes[0]] > 0
            error = residuals[name][seen][:, axes] * sensors.by_name[name].std
            x = problem.samples[name][seen]
            if name == "attitude":
                turned = Rotation.from_quat(x)
                x = (turned.mean().inv() * turned).as_rotvec()
            yield name, error, (x - x.mean(axis=0))[:, axes]
