"""The state in which a manoeuvre starts: its momentum is what fixes the scale."""

import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.dynamics.wheels import wheels_of
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState

WHEEL_SPEED = 200.0
"""rad/s, some 1900 turns a minute: half of what reaction wheels are made for."""

TUMBLE = (0.01, 0.03, 0.025)
"""rad/s, base axes: Table 3's."""

# Of the wheels' momentum: rounding in a file is far below, any tumbling far above.
NO_MOMENTUM = 1e-6

_inertia = compiled(inertia)


def usual_initial(robot: Robot, start: Float[np.ndarray, "joints 3"]) -> InitialState:
    """In space a little tumbling and all wheels spinning; on a table spun up from rest.

    Args:
        robot: with its nominal inertia.
        start: position, velocity and acceleration of each joint.
    """
    speeds = dict.fromkeys(robot.wheel_names, WHEEL_SPEED)
    if robot.motion == "planar":
        return spun_up(robot, speeds, start)
    return InitialState(np.array(TUMBLE), wheel_speed=speeds)


@in_float64
def spun_up(
    robot: Robot, wheel_speed: dict[str, float], start: Float[np.ndarray, "joints 3"]
) -> InitialState:
    """All was at rest before the wheels spun up (Eq. 25): `w = -D^-1 (h_rw + D_q qd)`.

    Args:
        robot: with its nominal inertia.
        wheel_speed: by name, relative to the base, rad/s.
        start: position, velocity and acceleration of each joint.
    """
    at = _inertia(tree_of(robot), robot.theta, start[:, 0])
    D = np.asarray(at.D)
    speeds = InitialState(wheel_speed=wheel_speed).wheel_speeds(robot.wheel_names)
    h = wheels_of(robot).A_rw @ speeds + np.asarray(at.D_q) @ start[:, 1]
    if robot.motion == "planar":
        w = np.array([0.0, 0.0, -h[2] / D[2, 2]])
    else:
        w = -np.linalg.solve(D, h)
    return InitialState(w, wheel_speed=wheel_speed)


@in_float64
def was_at_rest(
    robot: Robot, initial: InitialState, start: Float[np.ndarray, "joints 3"]
) -> bool:
    """Whether the momentum is zero although wheels spin: `h_cm = 0` (Eqs. 25, 26)."""
    at = _inertia(tree_of(robot), robot.theta, start[:, 0])
    h_rw = wheels_of(robot).A_rw @ initial.wheel_speeds(robot.wheel_names)
    h = np.asarray(at.D) @ initial.angular_velocity + h_rw
    h += np.asarray(at.D_q) @ start[:, 1]
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    size = np.linalg.norm(h_rw[axes])
    return bool(size > 0 and np.linalg.norm(h[axes]) <= NO_MOMENTUM * size)
