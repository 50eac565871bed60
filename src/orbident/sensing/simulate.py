"""A recording of a free-floating manoeuvre, as ideal sensors would make it."""

import numpy as np

from orbident.dynamics.free_floating import BaseState, FreeFloating, free_floating
from orbident.dynamics.regularity import check_regular
from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import Trajectory

RATE = 20.0
"""Hz, where neither the caller nor the robot file says otherwise: the paper's."""


def simulate(
    robot: Robot,
    trajectory: Trajectory,
    rate: float | None = None,
    tolerance: float = 1e-9,
) -> Recording:
    """Let the robot float free along a trajectory, and record it without noise.

    Args:
        robot: with its nominal inertia.
        trajectory: of the joints, with the initial state of base and wheels.
        rate: samples per second; the robot file's by default, else 20 Hz.
        tolerance: of the attitude, rad.

    Raises:
        InputError: the trajectory is not for this robot's joints and wheels, its mass
            matrix is singular, the rate is not positive, or the base turns too fast
            for it.
    """
    check_regular(robot)
    rate = float(robot.sensors.get("rate", RATE) if rate is None else rate)
    if not 0.0 < rate < np.inf:
        raise InputError(f"rate {rate} Hz: give a positive number of samples a second")
    trajectory = trajectory.for_robot(robot)
    initial = trajectory.initial
    start = BaseState(
        angular_velocity=initial.angular_velocity,
        attitude=initial.attitude,
        velocity=initial.velocity,
        wheel_speed=initial.wheel_speeds(robot.wheel_names),
    )
    t = sample_times(trajectory.duration, rate)
    if t.size < 2:
        raise InputError(
            f"rate {rate} Hz gives {t.size} sample in {trajectory.duration} s; "
            "sample faster"
        )
    return recorded(robot, free_floating(robot, trajectory, t, start, tolerance))


def sample_times(duration: float, rate: float) -> np.ndarray:
    """0, 1/rate, 2/rate ... up to and including the duration, s."""
    # A duration that is a whole number of periods but for rounding has its last one.
    count = int(np.floor(duration * rate * (1 + 1e-12))) + 1
    return np.minimum(np.arange(count) / rate, duration)


def recorded(robot: Robot, motion: FreeFloating) -> Recording:
    """A motion as the columns of a recording."""
    columns = {}
    for k, name in enumerate(robot.joint_names):
        columns[f"joint.{name}.position"] = motion.q[:, k]
        columns[f"joint.{name}.velocity"] = motion.qd[:, k]
    for k, name in enumerate(robot.wheel_names):
        columns[f"wheel.{name}.speed"] = motion.qd_rw[:, k]
    vectors = {
        "gyro": (motion.w, "xyz"),
        "attitude": (motion.attitude, "xyzw"),
        "position": (motion.r_S, "xyz"),
        "velocity": (motion.v_S, "xyz"),
    }
    for sensor, (values, components) in vectors.items():
        for k, component in enumerate(components):
            columns[f"{sensor}.{component}"] = values[:, k]
    return Recording(motion.t, columns, source=f"simulation of {robot.name}")
