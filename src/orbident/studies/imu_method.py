"""Regressors' inputs from encoders and an IMU, the paper's way (Sections 3.5 and 4)."""

import numpy as np

from orbident.preprocessing.attitude_fusion import integrate_gyro
from orbident.preprocessing.velocity import velocity_from_accelerometer
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies.filters import Filters
from orbident.trajectories.trajectory import InitialState


def from_imu(
    robot: Robot, recording: Recording, initial: InitialState, filters: Filters
) -> Recording:
    """Encoders differentiated; attitude and velocity of S by integration.

    Args:
        robot: whose joints and wheels were recorded.
        recording: joint and wheel positions, gyro and accelerometer, evenly sampled.
        initial: attitude of the base and velocity of S at the first sample.
        filters: of encoders and gyro.

    Raises:
        InputError: a column is missing or has gaps, or the samples are not evenly
            spaced.
    """
    t = recording.t
    gyro = [f"gyro.{k}" for k in "xyz"]
    w = [filters.smooth(t, recording.column(name), name) for name in gyro]
    x_WB = integrate_gyro(t, np.column_stack(w), initial.attitude)
    felt = velocity_from_accelerometer(t, x_WB, recording.vector("accelerometer"))
    columns = filters.joints_and_wheels(robot, recording)
    columns |= dict(zip(gyro, w, strict=True))
    columns |= {f"attitude.{k}": x for k, x in zip("xyzw", x_WB.T, strict=True)}
    v_S = initial.velocity + felt
    columns |= {f"velocity.{k}": v for k, v in zip("xyz", v_S.T, strict=True)}
    return Recording(t, columns, source=recording.source)
