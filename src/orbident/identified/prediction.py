"""The motion that identified parameters predict, from joint and wheel histories alone.

With `pi` known, `D` and `D_q qd` are `Y pi` at unit and at zero base rate (Eq. 16): the
base rate follows from conservation, and `phi` gives the velocity of S (Eq. 30). No
nominal inertia is used.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.compilation import compiled
from orbident.dynamics.attitude import RateLaw, float_attitude, rate_law
from orbident.dynamics.batches import in_batches
from orbident.dynamics.wheels import wheels_of
from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.precision import in_float64
from orbident.recordings.recording import Recording
from orbident.regressors.minimal_sets import MinimalSets, Regressors, minimal_sets
from orbident.signals.delays import corrections
from orbident.signals.samples import Batch, samples_of
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import quaternion_matrix, rotate

TOLERANCE = 1e-8
"""Of the predicted attitude, rad: below what any sensor sees."""


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


@in_float64
def predict(result: Result, recording: Recording) -> Prediction:
    """Run the identified model along a recording's joint and wheel histories.

    The first attitude is taken from the recording, and so are the constants of the
    motion, momentum and CM velocity, as means over all samples: they belong to the
    manoeuvre, not to the robot. Everything else is predicted.

    Raises:
        InputError: the result has undetermined parameters, or the recording lacks what
            prediction needs.
    """
    _check_complete(result)
    robot, sets = result.robot, minimal_sets(result.robot)
    _check_sizes(result, sets)
    regressors = sets.regressors
    pi, phi = result.pi.values, result.phi.values
    # Clocks are the laboratory's, not the recording's.
    t, measured = samples_of(robot, recording, corrections(result.clocks)).complete()
    if t.size < 4:
        raise InputError(
            f"{recording.source}: {t.size} complete samples; prediction needs at least "
            "4 with joints, wheels, gyro and attitude all measured"
        )

    wheels = wheels_of(robot)
    turning = np.isin(np.arange(3), regressors.momentum_axes)
    terms = partial(_terms, regressors, pi, phi)
    at = in_batches(terms, measured.q, measured.qd, measured.w, measured.x_WB)
    R_WB = at.R_WB
    h_W = np.einsum("nij,nj->ni", R_WB, at.h + measured.qd_rw @ wheels.A_rw.T)
    h_cm = np.where(turning, h_W.mean(axis=0), 0.0)
    moving = measured.moving
    v_cm = (measured.v_S - at.v)[moving].mean(axis=0) if moving.any() else np.zeros(3)

    joints = len(robot.joints)
    history = np.hstack([measured.q, measured.qd, measured.qd_rw])
    spline = CubicSpline(t, history)

    def law_at(nodes: Float[np.ndarray, " m"]) -> RateLaw:
        q, qd, qd_rw = np.split(spline(nodes), [joints, 2 * joints], axis=1)
        at_rest = np.zeros((nodes.size, 3)), np.tile([0.0, 0, 0, 1], (nodes.size, 1))
        at = in_batches(terms, q, qd, *at_rest)
        h_moving = at.h + qd_rw @ wheels.A_rw.T
        return rate_law(at.D, h_moving, robot.motion == "planar")

    x_WB, law, _, _ = float_attitude(law_at, t, h_cm, measured.x_WB[0], TOLERANCE)
    w = in_batches(_rate, law, x_WB, np.broadcast_to(h_cm, (t.size, 3)))
    v = in_batches(terms, measured.q, measured.qd, w, x_WB).v
    return Prediction(t, measured, w, v + v_cm, x_WB)


class Terms(NamedTuple):
    """The identified momentum and velocity at some joint states."""

    D: Float[AnyArray, "n 3 3"]
    h: Float[AnyArray, "n 3"]
    """`h_rs = D w + D_q qd`, base axes; zero where momentum is not conserved."""
    v: Float[AnyArray, "n 3"]
    """Velocity of S relative to the system CM, inertial axes."""
    R_WB: Float[AnyArray, "n 3 3"]


@compiled
def _terms(
    regressors: Regressors,
    pi: Float[AnyArray, " pi"],
    phi: Float[AnyArray, " phi"],
    q: Float[AnyArray, "n joints"],
    qd: Float[AnyArray, "n joints"],
    w: Float[AnyArray, "n 3"],
    x_WB: Float[AnyArray, "n 4"],
) -> Terms:
    turning, moving = regressors.momentum_axes, regressors.velocity_axes

    def terms(q, qd, w, x_WB):
        def h_rs(w):
            Y, _ = regressors(q, qd, w)
            return jnp.zeros(3).at[turning,].set(Y @ pi)

        _, W = regressors(q, qd, w)
        R_WB = quaternion_matrix(x_WB)
        v = jnp.zeros(3).at[moving,].set(W @ phi)
        return Terms(jax.jacfwd(h_rs)(w), h_rs(w), rotate(R_WB, v), R_WB)

    return jax.vmap(terms)(q, qd, w, x_WB)


@compiled
def _rate(law: RateLaw, x_WB: Float[AnyArray, "n 4"], h_cm: Float[AnyArray, "n 3"]):
    return law.rate(x_WB, h_cm)


def _check_sizes(result: Result, sets: MinimalSets) -> None:
    found = result.pi.values.size, result.phi.values.size
    needed = sets.pi_of_beta.shape[0], sets.base.sigmas
    if found != needed:
        raise InputError(
            f"the result has {found[0]} pi and {found[1]} phi, but robot "
            f"'{result.robot.name}' has {needed[0]} and {needed[1]}; identify again"
        )


def _check_complete(result: Result) -> None:
    for name, estimates in (("pi", result.pi), ("phi", result.phi)):
        unknown = [
            parameter
            for parameter, value in zip(estimates.names, estimates.values, strict=True)
            if not np.isfinite(value)
        ]
        if unknown:
            raise InputError(
                f"the result does not determine {', '.join(unknown)}, so {name} cannot "
                "predict; identify from a recording that does (see its warnings)"
            )
