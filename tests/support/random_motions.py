"""Random manoeuvres: joints on random Fourier series, wheels spinning, base turning."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia_at
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState, Trajectory

HARMONICS = 5

Start = Literal["turning", "at rest", "spun up"]
"""The base turns; the base is at rest and the wheels spin; or the base turns because
the wheels spun up when all was at rest, so that the momentum is zero."""


def random_motion(
    robot: Robot,
    seed: int = 0,
    duration: float = 40.0,
    wheel_speed: float = 200.0,
    start: Start = "turning",
    start_at: Mapping[str, float] | None = None,
    still: Sequence[str] = (),
) -> Trajectory:
    """A trajectory that excites everything; its joints start and end at rest.

    Args:
        robot: whose joints move.
        seed: of the random coefficients.
        duration: s.
        wheel_speed: of every wheel at the start, rad/s.
        start: how base and wheels start.
        start_at: where a joint starts and ends; zero where absent, or the middle of
            its range where zero is not well inside.
        still: joints that do not move.
    """
    random = np.random.default_rng(seed)
    joints = len(robot.joints)
    a, b = 0.15 * random.standard_normal((2, joints, HARMONICS))
    ends = np.zeros((joints, 3))
    for k, name in enumerate(robot.joint_names):
        ends[k, 0] = (start_at or {}).get(name, _usual(robot.joints[k].position))
        if name in still:
            a[k] = b[k] = 0.0
    free = Trajectory(
        duration=duration, joints=robot.joint_names, a=a, b=b, start=ends, end=ends
    )
    room = _room(robot, free)[:, None]
    return replace(
        free,
        a=room * a,
        b=room * b,
        initial=InitialState(
            angular_velocity=_rate(robot, ends[:, 0], wheel_speed, start),
            attitude=np.array(
                [0.2, 0.1, 0.3, 0.93]
                if robot.motion == "spatial"
                else [0.0, 0.0, 0.6, 0.8]
            ),
            wheel_speed=dict.fromkeys(robot.wheel_names, wheel_speed),
        ),
    )


def _usual(stops: tuple[float, float] | None) -> float:
    if stops is None or stops[0] < -0.1 < 0.1 < stops[1]:
        return 0.0
    return sum(stops) / 2


def _room(robot: Robot, free: Trajectory) -> np.ndarray:
    """The part of each joint's motion that keeps it within its range; 1 at most."""
    q, _, _ = free.at(np.linspace(0.0, free.duration, 1000))
    room = np.ones(len(robot.joints))
    for k, joint in enumerate(robot.joints):
        if joint.position is not None:
            start = free.start[k, 0]
            away = q[:, k] - start
            stops = np.where(away > 0, *(stop - start for stop in joint.position[::-1]))
            moving = np.abs(away) > 1e-9
            room[k] = np.min(stops[moving] / away[moving], initial=1.0)
    return room


def _rate(robot: Robot, q: np.ndarray, wheel_speed: float, start: Start) -> np.ndarray:
    planar = robot.motion == "planar"
    if start == "at rest":
        return np.zeros(3)
    if start == "turning":
        return np.array([0.0, 0.0, 0.3] if planar else [0.01, 0.03, 0.025])
    D = inertia_at(robot, q).D
    h_rw = wheels_of(robot).A_rw @ np.full(len(robot.wheels), wheel_speed)
    if planar:
        return np.array([0.0, 0.0, -h_rw[2] / D[2, 2]])
    return -np.linalg.solve(D, h_rw)
