"""Inputs of regressors from encoders and motion capture (the paper's Section 5.3)."""

import numpy as np
from jaxtyping import Float

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies.filters import Filters


def from_mocap(robot: Robot, recording: Recording, filters: Filters) -> Recording:
    """Rates of everything by differentiation, in the plane.

    The paper filters what motion capture gives only after it is differentiated. The
    two may change places but for the ends of the record.

    Args:
        robot: whose joints and wheels were recorded; it moves in the plane.
        recording: joint and wheel positions, attitude and position, evenly sampled.
        filters: of encoders and motion capture.

    Raises:
        InputError: a column is missing or has gaps, or the samples are not evenly
            spaced.
    """
    t = recording.t
    yaw = filters.with_rate(t, yaw_of(recording.vector("attitude", "xyzw")), "attitude")
    r_S = {
        axis: filters.with_rate(t, recording.column(name), name)
        for axis, name in (("x", "position.x"), ("y", "position.y"))
    }
    nothing = np.zeros(t.size)
    columns = filters.joints_and_wheels(robot, recording)
    columns |= {"gyro.x": nothing, "gyro.y": nothing, "gyro.z": yaw.rate}
    columns |= {"attitude.x": nothing, "attitude.y": nothing}
    columns |= {"attitude.z": np.sin(yaw.x / 2), "attitude.w": np.cos(yaw.x / 2)}
    columns |= {f"velocity.{axis}": filtered.rate for axis, filtered in r_S.items()}
    columns["velocity.z"] = nothing
    return Recording(t, columns, source=recording.source)


def yaw_of(x_WB: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, " n"]:
    """How far the base has turned about z, over full turns, rad.

    Args:
        x_WB: unit quaternions about z, of either sign, scalar last.
    """
    # Twice the half angle, which a quaternion and its negative see pi apart.
    return 2 * np.unwrap(np.arctan2(x_WB[:, 2], x_WB[:, 3]), period=np.pi)
