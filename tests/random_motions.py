"""Random manoeuvres: joints on random Fourier series, wheels spinning, base turning."""

from collections.abc import Mapping

import numpy as np

from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState, Trajectory

HARMONICS = 5


def random_motion(
    robot: Robot,
    seed: int = 0,
    duration: float = 40.0,
    wheel_speed: float = 200.0,
    start: Mapping[str, float] | None = None,
    still: tuple[str, ...] = (),
    at_rest: bool = False,
) -> Trajectory:
    """A trajectory that excites everything.

    Args:
        robot: whose joints move.
        seed: of the random coefficients.
        duration: s.
        wheel_speed: of every wheel at the start, rad/s.
        start: where a joint starts and ends; zero where absent.
        still: joints that do not move.
        at_rest: whether the base does not turn at the start.
    """
    random = np.random.default_rng(seed)
    joints = len(robot.joints)
    a, b = 0.15 * random.standard_normal((2, joints, HARMONICS))
    ends = np.zeros((joints, 3))
    for k, name in enumerate(robot.joint_names):
        ends[k, 0] = (start or {}).get(name, 0.0)
        if name in still:
            a[k] = b[k] = 0.0
    spatial = robot.motion == "spatial"
    w = [0.01, 0.03, 0.025] if spatial else [0.0, 0.0, 0.3]
    attitude = [0.2, 0.1, 0.3, 0.93] if spatial else [0.0, 0.0, 0.6, 0.8]
    return Trajectory(
        duration=duration,
        joints=robot.joint_names,
        a=a,
        b=b,
        start=ends,
        end=ends,
        initial=InitialState(
            angular_velocity=np.zeros(3) if at_rest else np.array(w),
            attitude=np.array(attitude),
            wheel_speed=dict.fromkeys(robot.wheel_names, wheel_speed),
        ),
    )
