"""Where the bodies are, how they move, and what momentum that is; base axes.

Places and motions are seen from the feature point S. The momentum of many samples is
linear in `theta` (Eqs. 3 and 19): `S theta` is the first moment about S, `P theta` the
linear momentum relative to S and `A theta` the angular momentum about S; the angular
momentum about the system CM is

    h_rs = A theta - (S theta) x (P theta) / M.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_robot, core_tree
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, INERTIA_ENTRIES, MASS, PER_BODY
from orbident.threads import processors

JointState = tuple[
    Float[np.ndarray, "n joints"],
    Float[np.ndarray, "n joints"],
    Float[np.ndarray, "n joints"],
]
"""Positions, rates and accelerations of joints at some times, rad or m, and s."""


class Poses(NamedTuple):
    """Where every body is, and the motion that a unit rate of each joint causes.

    That motion is the same rigid field for all bodies that the joint carries: its
    angular velocity, and its velocity at S.
    """

    R: Float[np.ndarray, "n bodies 3 3"]
    """`R_Bi`."""
    d: Float[np.ndarray, "n bodies 3"]
    """`p_SBi`, m."""
    field_w: Float[np.ndarray, "n joints 3"]
    field_u: Float[np.ndarray, "n joints 3"]

    def arm(self, body: int, p: Float[np.ndarray, "3"]) -> Float[np.ndarray, "n 3"]:
        """From S to the point `p` of a body, its frame, m; base axes."""
        return self.d[:, body] + self.R[:, body] @ p


def poses(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Poses:
    """Forward kinematics at the joint positions `q` (rad or m)."""
    return Poses(*_core.poses(core_tree(robot), q, processors()))


def carrying_joints(robot: Robot, body: int) -> Float[np.ndarray, " joints"]:
    """1 for each joint that moves the body: the body is at or beyond it."""
    carries = np.zeros(len(robot.joints))
    while body > 0:
        carries[body - 1] = 1.0
        body = robot.joints[body - 1].parent
    return carries


class MomentumRegressors(NamedTuple):
    """The regressors of the samples; columns are the flat `theta`, base first."""

    S: Float[np.ndarray, "n 3 theta"]
    P: Float[np.ndarray, "n 3 theta"]
    A: Float[np.ndarray, "n 3 theta"]


def momentum_regressors(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    qd: Float[np.ndarray, "n joints"],
    w: Float[np.ndarray, "n 3"],
) -> MomentumRegressors:
    """`S`, `P` and `A` at joint states and base rates (rad/s, base axes)."""
    return MomentumRegressors(
        *_core.momentum(core_tree(robot), q, qd, w, threads=processors())
    )


class Inertia(NamedTuple):
    """The inertia of the system at some configurations, base axes.

    `h_rs = D w + D_q qd` about the system CM (Eq. 3); kinetic energy about the CM
    `1/2 w D w + w D_q qd + 1/2 qd D_qq qd` (Eq. 6, wheels apart).
    """

    D: Float[np.ndarray, "n 3 3"]
    D_q: Float[np.ndarray, "n 3 joints"]
    D_qq: Float[np.ndarray, "n joints joints"]
    r_cm: Float[np.ndarray, "n 3"]
    """Vector from S to the system CM, m."""
    J_cm: Float[np.ndarray, "n 3 joints"]
    """Velocity of the CM relative to S is `w x r_cm + J_cm qd`."""

    def energy(self, axes: Sequence[int]) -> Float[np.ndarray, "n all all"]:
        """`[[D, D_q], [D_q^T, D_qq]]` (Eq. 6), over `[w, qd]`; `w` in these axes."""
        which = list(axes)
        D, D_q = self.D[:, which][:, :, which], self.D_q[:, which]
        return np.block([[D, D_q], [np.swapaxes(D_q, 1, 2), self.D_qq]])


def first_moments(at: Poses) -> Float[np.ndarray, "n 3 theta"]:
    """The first moment of all bodies about S by each of their parameters, base axes."""
    n, bodies = at.d.shape[:2]
    by_theta = np.zeros((n, 3, bodies, PER_BODY))
    by_theta[..., MASS] = np.swapaxes(at.d, 1, 2)
    by_theta[..., FIRST_MOMENT] = np.swapaxes(at.R, 1, 2)
    return by_theta.reshape(n, 3, -1)


def inertia(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Inertia:
    """The matrices of `robot.theta` at the joint positions `q` (rad or m)."""
    return Inertia(*_core.inertia(core_robot(robot), q, processors()))


def inertia_at(robot: Robot, q: Float[np.ndarray, " joints"]) -> Inertia:
    """The same at one configuration; no leading axis."""
    return Inertia(*(part[0] for part in inertia(robot, q[None])))


def carried_inertia(robot: Robot, joint: int) -> Float[np.ndarray, " theta"]:
    """The inertia of what a joint carries, about its axis, per unit of each `theta`.

    Its product with `theta` is in kg m^2, or in kg for a joint that slides. Joints
    beyond it are at zero.
    """
    at = poses(robot, np.zeros((1, len(robot.joints))))
    by = np.zeros((len(robot.bodies), PER_BODY))
    a = at.R[0, joint + 1] @ robot.joints[joint].axis
    carried = (carrying_joints(robot, i)[joint] for i in range(len(robot.bodies)))
    for i in np.flatnonzero([*carried]):
        if robot.joints[joint].kind == "prismatic":
            by[i, 0] = 1.0
            continue
        R, d = at.R[0, i], at.d[0, i] - at.d[0, joint + 1]
        across, own = np.cross(a, d), R.T @ a
        by[i, 0] = across @ across
        by[i, 1:4] = 2 * np.cross(a, R.T) @ across
        by[i, 4:] = [(1 + (r != c)) * own[r] * own[c] for r, c in INERTIA_ENTRIES]
    return by.ravel()


class Springs(NamedTuple):
    """What holds joints that nobody drives: `tau = -k q - c qd`; zero of others."""

    k: Float[np.ndarray, " joints"]
    """N m/rad or N/m."""
    c: Float[np.ndarray, " joints"]
    """N m s/rad or N s/m."""


def springs_on(robot: Robot) -> Springs:
    """The springs and dampers of passive joints, with nominal inertia."""
    springs = Springs(*np.zeros((2, len(robot.joints))))
    for name, passive in robot.passive.items():
        joint, rate = robot.joint_names.index(name), 2 * np.pi * passive.frequency
        inertia = float(carried_inertia(robot, joint) @ robot.theta.ravel())
        springs.k[joint] = rate**2 * inertia
        springs.c[joint] = 2 * passive.damping * rate * inertia
    return springs


def principal_inertias(robot: Robot) -> Float[np.ndarray, " axes"]:
    """Nominal, of the whole robot at zero, kg m^2; about z alone in the plane."""
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    return np.linalg.eigvalsh(D[2:, 2:] if robot.motion == "planar" else D)
