"""A trajectory as samples, for those who have to follow it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.text import write_text
from orbident.recordings.recording import Recording
from orbident.simulation.control_laws import part_on
from orbident.simulation.simulate import sample_times
from orbident.trajectories.trajectory import Trajectory

SECOND = 1_000_000_000
"""ns."""


class SampledTrajectory(NamedTuple):
    """A trajectory at some times, the last its end."""

    joints: tuple[str, ...]
    t: Float[np.ndarray, " n"]
    """s."""
    q: Float[np.ndarray, "n joints"]
    """rad or m."""
    qd: Float[np.ndarray, "n joints"]
    qdd: Float[np.ndarray, "n joints"]
    duty: Mapping[str, Float[np.ndarray, " n"]]
    """Of each thruster that fires, until the next sample."""


def sampled(trajectory: Trajectory, rate: float) -> SampledTrajectory:
    """Samples at an even rate, and one at the end.

    Args:
        trajectory: what to sample.
        rate: Hz.

    Raises:
        InputError: the rate is not positive, or gives too few or too many samples.
    """
    t = sample_times(trajectory.duration, rate)
    if t[-1] < trajectory.duration:
        t = np.append(t, trajectory.duration)
    fired = trajectory.environment.thrusters if trajectory.environment else {}
    duty = {
        name: sum((part_on(pulse, t) for pulse in each.pulses), np.zeros(t.size))
        for name, each in fired.items()
    }
    return SampledTrajectory(trajectory.joints, t, *trajectory.at(t), duty)


def motion_table(samples: SampledTrajectory) -> Recording:
    """As a table: `t`, and `joint.<name>.position`, `.velocity`, `.acceleration`.

    And `thruster.<name>.duty`, from 0 to 1.
    """
    columns = {f"thruster.{name}.duty": duty for name, duty in samples.duty.items()}
    for k, name in enumerate(samples.joints):
        columns[f"joint.{name}.position"] = samples.q[:, k]
        columns[f"joint.{name}.velocity"] = samples.qd[:, k]
        columns[f"joint.{name}.acceleration"] = samples.qdd[:, k]
    return Recording(samples.t, columns, source="samples")


def write_joint_trajectory(samples: SampledTrajectory, path: Path) -> None:
    """Writes a ROS `trajectory_msgs/JointTrajectory` as YAML.

    Raises:
        InputError: there are no joints, or the folder does not exist or cannot be
            written to.
    """
    if not samples.joints:
        raise InputError(
            f"{path}: a joint trajectory has no pulses of thrusters, and here are no "
            "joints; write a table"
        )
    points = [
        {
            "positions": q.tolist(),
            "velocities": qd.tolist(),
            "accelerations": qdd.tolist(),
            "effort": [],
            "time_from_start": {"sec": ns // SECOND, "nanosec": ns % SECOND},
        }
        for ns, q, qd, qdd in zip(
            np.round(samples.t * SECOND).astype(int).tolist(),
            *(samples.q, samples.qd, samples.qdd),
            strict=True,
        )
    ]
    message: dict[str, Any] = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(samples.joints),
        "points": points,
    }
    write_text(path, yaml.safe_dump(message, sort_keys=False, default_flow_style=None))
