"""A free-flying motion as plain data: where it starts, and what it was."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.simulation.free_floating import BaseState


class FlyingState(NamedTuple):
    """Everything that moves, at one time."""

    base: BaseState
    q: Float[np.ndarray, " joints"]
    qd: Float[np.ndarray, " joints"]
    r_S: Float[np.ndarray, "3"]
    """Position of S, inertial axes, m."""
    q_rw: Float[np.ndarray, " wheels"]
    """Wheel angles over full turns, rad."""


def standing(base: BaseState, q: Float[np.ndarray, " joints"]) -> FlyingState:
    """Joints at rest; S is at the origin, and wheel angles are counted from here."""
    return FlyingState(base, q, np.zeros_like(q), np.zeros(3), 0 * base.wheel_speed)


class FreeFlying(NamedTuple):
    """A free-flying motion at its sample times."""

    t: Float[np.ndarray, " n"]
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    qdd: Float[np.ndarray, "n joints"]
    attitude: Float[np.ndarray, "n 4"]
    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    w_dot: Float[np.ndarray, "n 3"]
    """Its derivative, rad/s^2."""
    q_rw: Float[np.ndarray, "n wheels"]
    """Wheel angles over full turns, rad."""
    qd_rw: Float[np.ndarray, "n wheels"]
    """Relative to the base, rad/s."""
    qdd_rw: Float[np.ndarray, "n wheels"]
    r_S: Float[np.ndarray, "n 3"]
    """Position of S, inertial axes, m."""
    v_S: Float[np.ndarray, "n 3"]
    """Velocity of S, inertial axes, m/s."""
    f_S: Float[np.ndarray, "n 3"]
    """Specific force at S, base axes, m/s^2."""
    r_cm: Float[np.ndarray, "n 3"]
    """Position of the system CM, inertial axes, m."""
    v_cm: Float[np.ndarray, "n 3"]
    """Velocity of the system CM, inertial axes, m/s."""
    h_cm: Float[np.ndarray, "n 3"]
    """Angular momentum about the system CM, inertial axes, N m s."""
    tau: Float[np.ndarray, "n joints"]
    """Joint torques, N m or N."""
    tau_rw: Float[np.ndarray, "n wheels"]
    """Torques on the rotors, N m."""
    force: Float[np.ndarray, "n 3"]
    """Net thruster force, base axes, N; at an edge that of what follows."""
    torque: Float[np.ndarray, "n 3"]
    """Net moment of the thrusters about S, base axes, N m."""
    error: float
    """Estimate of the largest error of attitude, joints and position; rad or m."""
    steps: int
    """RK4 steps in all."""

    def state(self, k: int) -> FlyingState:
        """Where a motion that goes on from sample `k` starts."""
        base = BaseState(self.w[k], self.attitude[k], self.v_S[k], self.qd_rw[k])
        return FlyingState(base, self.q[k], self.qd[k], self.r_S[k], self.q_rw[k])
