"""How a free-floating base answers when joints are moved by hand."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot
from orbident.simulation.free_floating import BaseState, JointState, free_floating

NODES = 9
"""Times from one position of the sliders to the next; the integrator adds its own."""


class BasePose(NamedTuple):
    """Where the base is, inertial frame."""

    x_WB: Float[np.ndarray, "4"]
    r_S: Float[np.ndarray, "3"]
    """m."""


class Straight(NamedTuple):
    """All joints from rest to rest, on a straight line, in a time of 1."""

    start: Float[np.ndarray, " joints"]
    end: Float[np.ndarray, " joints"]

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations."""
        s = t[:, None]
        way = self.end - self.start
        return (
            self.start + (3 - 2 * s) * s**2 * way,
            6 * (1 - s) * s * way,
            (6 - 12 * s) * way,
        )


def reaction(
    robot: Robot,
    base: BasePose,
    start: Float[np.ndarray, " joints"],
    end: Float[np.ndarray, " joints"],
) -> BasePose:
    """The base after the joints moved, without momentum; held wheels do not spin.

    Then `D w + D_q qd = 0` (Eq. 18): where the base gets to depends on the way of the
    joints, not on their time.

    Args:
        robot: its `theta` decides.
        base: before.
        start: joint positions before, rad or m.
        end: joint positions after.
    """
    at_rest = BaseState(
        angular_velocity=np.zeros(3),
        attitude=base.x_WB,
        velocity=np.zeros(3),
        wheel_speed=np.zeros(len(robot.wheels)),
    )
    t = np.linspace(0.0, 1.0, NODES)
    moved = free_floating(robot, Straight(start, end), t, at_rest)
    return BasePose(moved.attitude[-1], base.r_S + moved.r_S[-1])
