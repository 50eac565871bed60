"""How the base of a free-floating robot accelerates, from conserved momentum."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.equations_of_motion import movable
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.description import Robot
from orbident.simulation import forward_inverse
from orbident.simulation.free_floating import FreeFloating


class Accelerations(NamedTuple):
    """Accelerations of the base and the wheels at the samples of a motion."""

    w_dot: Float[np.ndarray, "n 3"]
    """Derivative of the base rate, base axes, rad/s^2."""
    qdd_rw: Float[np.ndarray, "n wheels"]
    """Accelerations of the wheels relative to the base, rad/s^2."""
    f_S: Float[np.ndarray, "n 3"]
    """Specific force at S, `R_0^T dv_S/dt`, base axes, m/s^2: no gravity is felt."""


def accelerations(
    robot: Robot, motion: FreeFloating, qdd: Float[np.ndarray, "n joints"]
) -> Accelerations:
    """Solve the equations of motion (Eq. 13), where no force acts on the whole.

    Known are the joints' accelerations and those of held wheels, which are zero; no
    motor drives the free ones. The CM's constant velocity is seen by no sensor here.

    Args:
        robot: the robot with its nominal inertia.
        motion: the free-floating motion.
        qdd: joint accelerations at its samples, rad/s^2 or m/s^2.
    """
    n, joints = motion.q.shape
    of_base, still = np.zeros((n, 3)), np.zeros_like(motion.qd_rw)
    v = np.hstack([of_base, motion.w, motion.qd, motion.qd_rw])
    known = np.hstack([of_base, of_base, qdd, still])
    free = movable(robot).astype(float)
    free[6:] = np.append(np.zeros(joints), wheels_of(robot).free)
    vd, f_S = forward_inverse.hybrid_dynamics(
        robot, motion.q, v, np.zeros_like(v), known, free
    )
    return Accelerations(w_dot=vd[:, 3:6], qdd_rw=vd[:, 6 + joints :], f_S=f_S)
