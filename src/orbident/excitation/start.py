"""The state in which a manoeuvre starts: its momentum is what fixes the scale."""

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.rotations import quaternion_matrix
from orbident.model.wheels import wheels_of
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState

WHEEL_SPEED = 200.0
"""rad/s, some 1900 turns a minute: half of what reaction wheels are made for."""

TUMBLE = (0.01, 0.03, 0.025)
"""rad/s, base axes: Table 3's."""

NO_MOMENTUM = 1e-6
"""Share of the wheels' momentum: rounding in a file is far below, tumbling far above."""


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
    w, _ = momentum_at_start(robot, core_robot(robot), initial, start, at_rest=True)
    return InitialState(w, wheel_speed=wheel_speed)


def was_at_rest(
    robot: Robot, initial: InitialState, start: Float[np.ndarray, "joints 3"]
) -> bool:
    """Whether the momentum is zero although wheels spin: `h_cm = 0` (Eqs. 25, 26)."""
    core = core_robot(robot)
    _, h_cm = momentum_at_start(robot, core, initial, start, at_rest=False)
    size = np.linalg.norm(_wheels_momentum(robot, initial))
    return bool(0 < size and np.linalg.norm(h_cm) <= NO_MOMENTUM * size)


def momentum_at_start(
    robot: Robot,
    core: _core.Robot,
    initial: InitialState,
    start: Float[np.ndarray, "joints 3"],
    at_rest: bool,
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """The base rate, and `h_cm = R_0 (D w + D_q qd + h_rw)` in inertial axes.

    Args:
        robot: whose wheels and plane are meant.
        core: its tree with a plausible inertia.
        initial: of base and wheels.
        start: position, velocity and acceleration of each joint.
        at_rest: all was at rest before the wheels spun up: `h_cm = 0`, and the base
            rate is `-D^-1 (D_q qd + h_rw)`, whatever the initial state says of it.
    """
    D, D_q = (
        x[0] for x in _core.inertia(core, np.ascontiguousarray(start[None, :, 0]))[:2]
    )
    h = D_q @ start[:, 1] + _wheels_momentum(robot, initial)
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    if at_rest:
        w = np.zeros(3)
        w[axes] = -np.linalg.solve(D[np.ix_(axes, axes)], h[axes])
        return w, np.zeros(3)
    h_cm = np.zeros(3)
    h_cm[axes] = (
        quaternion_matrix(initial.attitude) @ (D @ initial.angular_velocity + h)
    )[axes]
    return initial.angular_velocity, h_cm


def nutation(
    robot: Robot, initial: InitialState, start: Float[np.ndarray, "joints 3"]
) -> float:
    """A bound of how fast the base tumbles and nutates at the start, rad/s.

    In the plane nothing nutates, and the attitude is an integral over time.
    """
    if robot.motion == "planar":
        return 0.0
    at = np.ascontiguousarray(start[None, :, 0])
    D = np.linalg.eigvalsh(_core.inertia(core_robot(robot), at)[0][0])
    w = float(np.linalg.norm(initial.angular_velocity))
    h_rw = float(np.linalg.norm(_wheels_momentum(robot, initial)))
    return w + (float(D[-1]) * w + h_rw) / float(D[0])


def _wheels_momentum(robot: Robot, initial: InitialState) -> Float[np.ndarray, "3"]:
    """`h_rw`, in the axes in which momentum is conserved, base axes."""
    h_rw = wheels_of(robot).A_rw @ initial.wheel_speeds(robot.wheel_names)
    if robot.motion == "planar":
        h_rw[:2] = 0.0
    return h_rw
