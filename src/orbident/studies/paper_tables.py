"""The numbers of Tables 1 to 6 and Sections 3.5 and 5, as printed; ours beside them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from orbident.files.json_parts import nulled
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import InitialState, Trajectory

TABLES = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
"""Tables 2, 4, 5 and 6 by their names; the file says what their rows are."""

SPATIAL_DURATION = 80.0
SPATIAL_RATE = 20.0

# Table 3; the quaternion's norm is 1.0024, so it is normalised where it is used.
SPATIAL_ANGULAR_VELOCITY = (0.01, 0.03, 0.025)
SPATIAL_ATTITUDE = (0.2, 0.1, 0.3, 0.93)
SPATIAL_WHEEL_MOMENTUM = (50.0, 50.0, 50.0)

SPATIAL_TRUE: dict[str, list[float]] = TABLES["table4"]
# Section 4: of the total mass by Eq. 42, with noise, percent.
SPATIAL_MASS_ERROR = 0.97

PLANAR_DURATION = 20.0
PLANAR_RATE = 100.0
# Section 5.1: from S to the first joint, m; Eq. 45, rad/s.
PLANAR_JOINT1 = (0.173, 0.091)
PLANAR_WHEEL_SPEED = -170.0
# Section 5.2.
PLANAR_CONDITION = 153.0

PLANAR_IDENTIFIED: dict[str, float] = TABLES["table6"]
# Section 5.5: on scales, kg; of the mass by Eq. 40, percent.
PLANAR_MASS_WEIGHED = 13.55
PLANAR_MASS_ERROR = 0.1

# Section 5.5: N, s, m/s along y before the burn; N m/rad and N m s/rad.
BURN_FORCE = (0.052, -0.595)
BURN_START = 1.0
BURN_LASTS = 0.5
BURN_DRIFT = 0.0024
HOLD_KP = 0.3
HOLD_KD = 0.3

# Eq. 47: rad, s.
VALIDATION_AMPLITUDES = (0.86, 1.0)
VALIDATION_DURATION = 18.0


PRINTED = 0.005
"""Half of the last of the two decimals that Table 4 prints."""

NAN = float("nan")


@dataclass(frozen=True)
class PaperRow:
    """One parameter of a table of the paper, its numbers and ours."""

    name: str
    paper_true: float | None
    paper_error_percent: float | None
    true: float
    estimate: float
    """The estimate of the first seed."""
    rms_error_percent: float = NAN
    """Over the seeds; NaN without noise."""
    worst_error_percent: float = NAN
    cramer_rao_percent: float = NAN
    """The least RMS error that an unbiased estimate can have."""

    @property
    def error_percent(self) -> float:
        """Relative error of the estimate, signed."""
        return 100 * (self.estimate / self.true - 1)

    @property
    def as_printed(self) -> bool:
        """Whether the true value is the paper's, to its printed decimals."""
        return self.paper_true is None or abs(self.true - self.paper_true) <= PRINTED

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        numbers = {**vars(self), "error_percent": self.error_percent}
        del numbers["name"]
        return {"name": self.name, **{key: nulled(x) for key, x in numbers.items()}}


def spatial_robot() -> Robot:
    """Table 1's servicer."""
    return load_robot("paper-spatial")


def spatial_trajectory(robot: Robot) -> Trajectory:
    """Table 2's exciting trajectory with Table 3's initial conditions."""
    speeds = {
        wheel.name: momentum / wheel.inertia
        for wheel, momentum in zip(robot.wheels, SPATIAL_WHEEL_MOMENTUM, strict=True)
    }
    initial = InitialState(
        angular_velocity=np.array(SPATIAL_ANGULAR_VELOCITY),
        attitude=np.array(SPATIAL_ATTITUDE),
        wheel_speed=speeds,
    )
    return _exciting(robot, SPATIAL_DURATION, "2", initial)


def planar_robot() -> Robot:
    """The stand-in for Cepheus."""
    return load_robot("cepheus-like")


def planar_trajectory(robot: Robot) -> Trajectory:
    """Table 5's exciting trajectory, with the wheel at the speed of Eq. 45."""
    speeds = dict.fromkeys(robot.wheel_names, PLANAR_WHEEL_SPEED)
    initial = InitialState(wheel_speed=speeds)
    return _exciting(robot, PLANAR_DURATION, "5", initial)


def _exciting(
    robot: Robot, duration: float, table: str, initial: InitialState
) -> Trajectory:
    """A motion from rest to rest with the Fourier series of a table."""
    a, b = (np.array(TABLES[f"table{table}"][name]) for name in "ab")
    joints, source = robot.joint_names, f"Table {table}"
    return Trajectory(duration, joints, a, b, initial=initial, source=source)
