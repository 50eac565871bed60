"""The two conservation laws of one sample, linear in all unknowns.

In base axes, with the rate `w = w_gyro - b_g - n`,

    Y pi - R_0^T h_cm - D b_g = -A_rw qd_rw                     (Eqs. 2, 19)
    W phi + R_0^T v_cm + U b_g = R_0^T v_S                      (Eq. 29)

with `D = d h_rs / dw` and `U = d (velocity of the CM relative to S) / dw` at the
parameters known so far. The gyro's noise `n` adds `D n` and `-U n` on the right, and
the noise of attitude and joint rates adds to that.

`Y` and `W` are evaluated at a smoothed rate, and `D`, `U` take them to the gyro's.
Noise in a regressor is mistaken for excitation: as long as the base has hardly
changed its rate, least squares would find that it has no inertia.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.inertia import inertia
from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.estimation.recursive.noise import Noise
from orbident.regressors.minimal_sets import MinimalSets, Regressors
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross_matrix, quaternion_matrix, rotate_back


class Model(eqx.Module):
    """A robot's regressors, and a `theta` for every `beta`."""

    regressors: Regressors
    wheels: Wheels
    theta_of: Float[AnyArray, "theta beta"]
    accelerometer: bool = eqx.field(static=True)
    """Whether its bias is an unknown."""

    @classmethod
    def of(cls, robot: Robot, sets: MinimalSets, accelerometer: bool) -> "Model":
        """The model of a robot, on JAX's side once and for all."""
        model = cls(
            regressors=sets.regressors,
            wheels=wheels_of(robot),
            theta_of=sets.base.theta_of,
            accelerometer=accelerometer,
        )
        return jax.tree.map(jnp.asarray, model)

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Base axes in which angular and linear momentum are conserved."""
        regressors = self.regressors
        return np.array(regressors.momentum_axes), np.array(regressors.velocity_axes)


class Measured(NamedTuple):
    """The parts of `Sample.packed` that the laws need."""

    q: Float[AnyArray, " joints"]
    qd: Float[AnyArray, " joints"]
    w: Float[AnyArray, "3"]
    x_WB: Float[AnyArray, "4"]
    qd_rw: Float[AnyArray, " wheels"]
    v_S: Float[AnyArray, "3"]
    w_smooth: Float[AnyArray, "3"]


class Equations(NamedTuple):
    """`H [h_cm, v_cm, b_g, b_a, pi, phi] = rhs`, and the noise.

    That of both laws counts as if each had its own. What they have in common is told
    by `D` and `U`, and while these are wrong by some ten percent it would be wrong.
    """

    momentum: Float[AnyArray, "h unknowns+1"]
    """`[H | rhs]`."""
    velocity: Float[AnyArray, "v unknowns+1"]
    L_h: Float[AnyArray, "h h"]
    """Lower triangular root of the noise's covariance."""
    L_v: Float[AnyArray, "v v"]
    R_WB: Float[AnyArray, "3 3"]


def measured(model: Model, packed: Float[AnyArray, " sample"]) -> Measured:
    """What `Sample.packed` holds."""
    joints, wheels = len(model.regressors.tree.parent), model.wheels.A_rw.shape[1]
    cuts = np.cumsum([joints, joints, 3, 4, wheels, 3, 3])
    return Measured(*jnp.split(packed, cuts)[:7])


def equations(
    model: Model,
    noise: Noise,
    beta: Float[AnyArray, " beta"],
    h_cm: Float[AnyArray, "3"],
    at: Measured,
) -> Equations:
    """Both laws at one sample.

    Args:
        model: of the robot.
        noise: of its sensors.
        beta: where `D`, `U` and the noise's gains are evaluated.
        h_cm: the momentum known so far, for the noise of the attitude.
        at: what was measured.
    """
    h, v = model.axes
    R_WB = quaternion_matrix(at.x_WB)
    R_h, R_v = R_WB.T[h, :][:, h], R_WB.T[v, :][:, v]
    theta = (model.theta_of @ beta).reshape(-1, PER_BODY)
    I = inertia(model.regressors.tree, theta, at.q)
    D, U = I.D[h, :][:, h], -cross_matrix(I.r_cm)[v, :][:, h]
    excess = (at.w - at.w_smooth)[h]
    # In the plane the other two rates are zero, and stay what was measured.
    Y, W = model.regressors(at.q, at.qd, jnp.asarray(at.w).at[h].add(-excess))
    none = jnp.zeros((len(h), len(v)))
    b_a = none[:, : len(v) if model.accelerometer else 0]
    b_v = jnp.zeros((len(v), b_a.shape[1]))
    rhs_h = -(model.wheels.A_rw @ at.qd_rw)[h] - D @ excess
    rhs_v = rotate_back(R_WB, at.v_S)[v] + U @ excess
    momentum = [-R_h, none, -D, b_a, Y, jnp.zeros((len(h), W.shape[1])), rhs_h[:, None]]
    velocity = [none.T, R_v, U, b_v, jnp.zeros((len(v), Y.shape[1])), W, rhs_v[:, None]]
    # A turn phi of the attitude turns R_0^T h_cm by R_0^T (h_cm x phi).
    turn = (R_WB.T @ cross_matrix(h_cm))[h, :]
    C_h = [noise.gyro * D, noise.joint_rates * I.D_q[h, :], noise.attitude * turn]
    C_v = [
        noise.gyro * U,
        noise.joint_rates * I.J_cm[v, :],
        noise.velocity * jnp.eye(len(v)),
    ]
    return Equations(
        momentum=jnp.concatenate(momentum, axis=1),
        velocity=jnp.concatenate(velocity, axis=1),
        L_h=_root(C_h),
        L_v=_root(C_v),
        R_WB=R_WB,
    )


def _root(C: list[Float[AnyArray, "e _"]]) -> Float[AnyArray, "e e"]:
    """Lower triangular, of the covariance of noises that add up."""
    gains = jnp.concatenate(C, axis=1)
    return jnp.linalg.cholesky(gains @ gains.T)
