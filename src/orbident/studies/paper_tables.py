"""The numbers of Tables 1 to 6 and Sections 3.5 and 5, as printed; ours beside them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbident.files.json_parts import nulled
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import InitialState, Trajectory

# Table 2: row per joint, column per harmonic.
SPATIAL_A = (
    (0.0411, -0.0622, 0.0002),
    (0.0435, -0.0407, -0.1253),
    (0.0516, -0.0423, 0.1343),
)
SPATIAL_B = (
    (0.0533, -0.1269, 0.0171),
    (-0.0393, 0.0596, -0.0444),
    (-0.0153, 0.0449, 0.0463),
)
SPATIAL_DURATION = 80.0
SPATIAL_RATE = 20.0

# Table 3; the quaternion's norm is 1.0024, so it is normalised where it is used.
SPATIAL_ANGULAR_VELOCITY = (0.01, 0.03, 0.025)
SPATIAL_ATTITUDE = (0.2, 0.1, 0.3, 0.93)
SPATIAL_WHEEL_MOMENTUM = (50.0, 50.0, 50.0)

# Table 4: true value, relative error in percent without and with noise.
SPATIAL_TRUE = {
    "pi_1": (843.15, 2e-12, 0.04),
    "pi_2": (-111.75, -7e-12, -0.32),
    "pi_3": (120.82, 3e-11, 0.04),
    "pi_4": (843.15, 2e-12, 0.08),
    "pi_5": (120.82, 2e-11, 0.20),
    "pi_6": (1123.50, 5e-12, 0.11),
    "pi_7": (310.86, 9e-12, 0.23),
    "pi_8": (310.87, 2e-12, 0.14),
    "pi_9": (-246.37, -5e-12, -0.44),
    "pi_10": (246.42, 9e-12, 0.17),
    "pi_11": (-64.39, -2e-11, -0.88),
    "pi_12": (64.44, 3e-12, 0.01),
    "pi_13": (-143.50, -1e-13, -0.17),
    "pi_14": (158.56, 1e-12, 0.32),
    "pi_15": (-143.50, -2e-12, -0.23),
    "pi_16": (-47.83, -5e-12, -0.11),
    "pi_17": (52.85, 9e-12, 0.58),
    "pi_18": (-47.83, 2e-12, -0.19),
    "pi_19": (93.24, -1e-12, 0.15),
    "phi_1": (-0.96, -3e-13, -1.77),
    "phi_2": (-0.96, -9e-14, -1.28),
    "phi_3": (0.05, 1e-12, 2.87),
    "phi_4": (0.14, 6e-13, 2.07),
    "phi_5": (-0.56, -1e-12, -1.50),
}
# Section 4: of the total mass by Eq. 42, with noise, percent.
SPATIAL_MASS_ERROR = 0.97

# Table 5: row per joint, column per harmonic.
PLANAR_A = ((-0.025, -0.119, 0.100), (-0.004, -0.003, 0.113))
PLANAR_B = ((0.007, 0.093, -0.158), (-0.050, 0.126, 0.058))
PLANAR_DURATION = 20.0
PLANAR_RATE = 100.0
# Section 5.1: from S to the first joint, m; Eq. 45, rad/s.
PLANAR_JOINT1 = (0.173, 0.091)
PLANAR_WHEEL_SPEED = -170.0
# Section 5.2.
PLANAR_CONDITION = 153.0

# Table 6: identified; the true values are not known.
PLANAR_IDENTIFIED = {
    "pi_1": 0.0029,
    "pi_2": 0.0012,
    "pi_3": -0.0004,
    "pi_4": 0.0024,
    "pi_5": 0.1448,
    "pi_6": -0.0018,
    "pi_7": 0.0079,
    "pi_8": 0.0010,
    "phi_1": 0.1579,
    "phi_2": 0.0759,
    "phi_3": 0.0020,
    "phi_4": 0.0004,
    "M": 13.56,
}
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
    series = np.array(SPATIAL_A), np.array(SPATIAL_B)
    return _exciting(robot, SPATIAL_DURATION, series, initial, "Table 2")


def planar_robot() -> Robot:
    """The stand-in for Cepheus."""
    return load_robot("cepheus-like")


def planar_trajectory(robot: Robot) -> Trajectory:
    """Table 5's exciting trajectory, with the wheel at the speed of Eq. 45."""
    speeds = dict.fromkeys(robot.wheel_names, PLANAR_WHEEL_SPEED)
    initial = InitialState(wheel_speed=speeds)
    series = np.array(PLANAR_A), np.array(PLANAR_B)
    return _exciting(robot, PLANAR_DURATION, series, initial, "Table 5")


def _exciting(
    robot: Robot,
    duration: float,
    series: tuple[np.ndarray, np.ndarray],
    initial: InitialState,
    source: str,
) -> Trajectory:
    """A motion from rest to rest with the Fourier series `a` and `b`."""
    rest, joints = np.zeros((len(robot.joints), 3)), robot.joint_names
    return Trajectory(duration, joints, *series, rest, rest, initial, source=source)
