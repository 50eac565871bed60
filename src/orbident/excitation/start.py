"""The state in which a manoeuvre starts: its momentum is what fixes the scale."""

import numpy as np
from jaxtyping import Float

from orbident.model.inertia import inertia_at
from orbident.model.rotations import quaternion_matrix
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState

WHEEL_SPEED = 200.0
"""rad/s, some 1900 turns a minute: half of what reaction wheels are made for."""

TUMBLE = (0.01, 0.03, 0.025)
"""rad/s, base axes: Table 3's."""

NO_MOMENTUM = 1e-6
"""Share of the wheels' momentum: more than rounding in a file, less than tumbling."""


def usual_initial(robot: Robot, start: Float[np.ndarray, "joints 3"]) -> InitialState:
    """A state of slow tumbling, all wheels spinning; on a table, spun up from rest.

    Args:
        robot: the robot with its nominal inertia.
        start: position, velocity and acceleration of each joint.
    """
    speeds = dict.fromkeys(robot.wheel_names, WHEEL_SPEED)
    if robot.motion == "planar":
        return spun_up(robot, speeds, start)
    return InitialState(np.array(TUMBLE), wheel_speed=speeds)


def spun_up(
    robot: Robot, wheel_speed: dict[str, float], start: Float[np.ndarray, "joints 3"]
) -> InitialState:
    """The state after the wheels spun up when all was at rest (Eq. 25).

    Args:
        robot: with its nominal inertia.
        wheel_speed: by name, relative to the base, rad/s.
        start: position, velocity and acceleration of each joint.
    """
    initial = InitialState(wheel_speed=wheel_speed)
    w, _ = momentum_at_start(robot, initial, start, at_rest=True)
    return InitialState(w, wheel_speed=wheel_speed)


def was_at_rest(
    robot: Robot, initial: InitialState, start: Float[np.ndarray, "joints 3"]
) -> bool:
    """Whether the momentum is zero although wheels spin: `h_cm = 0` (Eqs. 25, 26)."""
    _, h_cm = momentum_at_start(robot, initial, start, at_rest=False)
    size = np.linalg.norm(_wheels_momentum(robot, initial))
    return bool(size > 0 and np.linalg.norm(h_cm) <= NO_MOMENTUM * size)


def momentum_at_start(
    robot: Robot,
    initial: InitialState,
    start: Float[np.ndarray, "joints 3"],
    at_rest: bool,
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """The base rate, and `h_cm = R_0 (D w + D_q qd + h_rw)` in inertial axes.

    Args:
        robot: its `theta` decides.
        initial: of base and wheels.
        start: position, velocity and acceleration of each joint.
        at_rest: all was at rest before the wheels spun up: `h_cm = 0`, and the base
            rate is `-D^-1 (D_q qd + h_rw)`, whatever the initial state says of it.
    """
    at = inertia_at(robot, start[:, 0])
    h = at.D_q @ start[:, 1] + _wheels_momentum(robot, initial)
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    if at_rest:
        w = np.zeros(3)
        w[axes] = -np.linalg.solve(at.D[np.ix_(axes, axes)], h[axes])
        return w, np.zeros(3)
    h_cm = quaternion_matrix(initial.attitude) @ (at.D @ initial.angular_velocity + h)
    if robot.motion == "planar":
        h_cm[:2] = 0.0
    return initial.angular_velocity, h_cm


def nutation(
    robot: Robot, initial: InitialState, start: Float[np.ndarray, "joints 3"]
) -> float:
    """A bound of how fast the base tumbles and nutates at the start, rad/s.

    In the plane nothing nutates, and the attitude is an integral over time.
    """
    if robot.motion == "planar":
        return 0.0
    D = np.linalg.eigvalsh(inertia_at(robot, start[:, 0]).D)
    w = float(np.linalg.norm(initial.angular_velocity))
    h_rw = float(np.linalg.norm(_wheels_momentum(robot, initial)))
    return w + (float(D[-1]) * w + h_rw) / float(D[0])


def _wheels_momentum(robot: Robot, initial: InitialState) -> Float[np.ndarray, "3"]:
    """`h_rw`, in the axes in which momentum is conserved, base axes."""
    h_rw = wheels_of(robot).A_rw @ initial.wheel_speeds(robot.wheel_names)
    if robot.motion == "planar":
        h_rw[:2] = 0.0
    return h_rw
