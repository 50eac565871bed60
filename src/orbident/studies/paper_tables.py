"""The numbers of Tables 1 to 6 and Sections 3.5 and 5, as printed; ours beside them.

The parameters of Tables 4 and 6 span the same spaces as the minimal sets found
automatically; the change of basis between the two is found from samples, so an estimate
in the one is an estimate in the other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.json_parts import nulled
from orbident.model.dependencies import random_motion
from orbident.model.minimal_sets import MinimalSets
from orbident.model.rotations import axis_rotation
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import InitialState, Trajectory

Vector = Float[np.ndarray, "3"]

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


class ParameterRow:
    """A parameter of a table, what it is and what was found."""

    name: str
    true: float
    estimate: float

    @property
    def error_percent(self) -> float:
        """Relative error of the estimate, signed."""
        return 100 * (self.estimate / self.true - 1)

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        numbers = {**vars(self), "error_percent": self.error_percent}
        return {k: x if k == "name" else nulled(x) for k, x in numbers.items()}


@dataclass(frozen=True)
class PaperRow(ParameterRow):
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
    def as_printed(self) -> bool:
        """Whether the true value is the paper's, to its printed decimals."""
        return self.paper_true is None or abs(self.true - self.paper_true) <= PRINTED


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
    return _exciting(robot, PLANAR_DURATION, "5", InitialState(wheel_speed=speeds))


def _exciting(
    robot: Robot, duration: float, table: str, initial: InitialState
) -> Trajectory:
    """A motion from rest to rest with the Fourier series of a table."""
    a, b = (np.array(TABLES[f"table{table}"][name]) for name in "ab")
    joints, source = robot.joint_names, f"Table {table}"
    return Trajectory(duration, joints, a, b, initial=initial, source=source)


# Two bases of one space agree to rounding, others not at all.
SAME_SPACE = 1e-8
SAMPLES = 64
"""Random ones: far more equations than the paper has parameters."""


class PaperColumns(NamedTuple):
    """One sample of the regressors as the paper has them."""

    Y: Float[np.ndarray, "h pi"]
    W: Float[np.ndarray, "v phi"]
    x: Float[np.ndarray, " v"]
    """What of the velocity is known from geometry alone (Eq. 29)."""


class PaperBasis(NamedTuple):
    """How the paper's parameters follow from the automatic minimal sets."""

    pi_of_pi: Float[np.ndarray, "paper pi"]
    """The paper's `pi` is this times the automatic one."""
    phi_of_phi: Float[np.ndarray, "paper phi"]
    phi_offset: Float[np.ndarray, " paper"]
    """The paper's `phi` is `phi_of_phi phi + phi_offset`."""

    def pi(self, pi: Float[np.ndarray, " pi"]) -> Float[np.ndarray, " paper"]:
        """The paper's `pi`."""
        return self.pi_of_pi @ pi

    def phi(self, phi: Float[np.ndarray, " phi"]) -> Float[np.ndarray, " paper"]:
        """The paper's `phi`."""
        return self.phi_of_phi @ phi + self.phi_offset


Columns = Callable[
    [Float[np.ndarray, " joints"], Float[np.ndarray, " joints"], Vector], PaperColumns
]


def spatial_columns(q: Vector, qd: Vector, w: Vector) -> PaperColumns:
    """The 19 + 5 columns of the spatial arm (Table 4, Eqs. 42 and A.6), base axes.

    Joint 1 turns about base z at S, joints 2 and 3 about `n`, perpendicular to z and
    positive where it raises the arm; `x1` is the arm's horizontal direction, `a` and
    `b` are the directions of links 2 and 3.
    """
    x, y, z = np.eye(3)
    x1 = axis_rotation(z, np.asarray(q[0])) @ x
    n = np.cross(x1, z)

    def u(angle: float) -> Vector:
        return np.cos(angle) * x1 + np.sin(angle) * np.cross(n, x1)

    w1 = w + qd[0] * z
    w2 = w1 + qd[1] * n
    w3 = w2 + qd[2] * n
    a, b = u(q[1]), u(q[1] + q[2])
    a_dot, b_dot = np.cross(w2, a), np.cross(w3, b)

    def about(e: Vector, f: Vector, f_dot: Vector):
        return np.cross(e, f_dot) + np.cross(f, np.cross(w, e))

    along = [(x1, w), (z, w1), (a, w2), (n, w2), (b, w3), (n, w3)]
    Y = [
        *(_symmetric(e, f) @ w for e, f in ((x, x), (x, y), (x, z))),
        *(_symmetric(e, f) @ w for e, f in ((y, y), (y, z), (z, z))),
        *(e * (e @ rate) for e, rate in along),
        *(about(e, a, a_dot) for e in (y, z, x)),
        *(about(e, b, b_dot) for e in (y, z, x)),
        np.cross(a, b_dot) + np.cross(b, a_dot),
    ]
    W = [np.cross(w, x), np.cross(w, y), -b_dot, -a_dot, -np.cross(w, z)]
    return PaperColumns(np.stack(Y, axis=1), np.stack(W, axis=1), np.zeros(3))


def planar_columns(
    q: Float[np.ndarray, "2"],
    qd: Float[np.ndarray, "2"],
    w: Vector,
    r_joint1: tuple[float, float] = PLANAR_JOINT1,
) -> PaperColumns:
    """The 8 + 4 columns of the planar arm (Eqs. A.4 and A.7), base axes.

    `r_joint1` is from S to the first joint, base axes, m.
    """
    w0 = w[2]
    w1 = w0 + qd[0]
    w2 = w1 + qd[1]
    c1, s1 = np.cos(q[0]), np.sin(q[0])
    c12, s12 = np.cos(q[0] + q[1]), np.sin(q[0] + q[1])
    c2 = np.cos(q[1])
    Y = [c1 * (w0 + w1), c12 * (w0 + w2), s1 * (w0 + w1), s12 * (w0 + w2)]
    Y += [w0, c2 * (w1 + w2), w1, w2]
    # z x e for the base's axes and the links' directions
    W = np.stack(
        [
            w0 * np.array([0.0, 1.0]),
            w0 * np.array([-1.0, 0.0]),
            -w1 * np.stack([-s1, c1]),
            -w2 * np.stack([-s12, c12]),
        ],
        axis=1,
    )
    x = -w0 * np.array([-r_joint1[1], r_joint1[0]])
    return PaperColumns(np.stack(Y)[None], W, x)


def paper_basis(sets: MinimalSets, columns: Columns) -> PaperBasis:
    """The change from the automatic minimal sets to the paper's.

    The columns are `spatial_columns` or `planar_columns`.

    Raises:
        InputError: the robot is not the paper's: its regressors span another space.
    """
    planar = len(sets.regressors.momentum_axes) == 1
    motion = random_motion(SAMPLES, sets.regressors.joints, planar)
    Y, W = sets.regressors(*motion)
    samples = [columns(*state) for state in zip(*motion, strict=True)]
    paper = PaperColumns(*(np.array(part) for part in zip(*samples, strict=True)))
    phi = _coordinates(paper.W, np.concatenate([W, -paper.x[:, :, None]], axis=2))
    return PaperBasis(_coordinates(paper.Y, Y), phi[:, :-1], phi[:, -1])


def _coordinates(
    basis: Float[np.ndarray, "n axes k"], columns: Float[np.ndarray, "n axes m"]
) -> Float[np.ndarray, "k m"]:
    """`C` such that `columns = basis C`."""
    B = basis.reshape(-1, basis.shape[-1])
    X = columns.reshape(-1, columns.shape[-1])
    C = np.linalg.lstsq(B, X, rcond=None)[0]
    if np.abs(B @ C - X).max() > SAME_SPACE * np.abs(X).max():
        raise InputError("the paper's parameters are not those of this robot")
    return C


def _symmetric(e: Vector, f: Vector) -> Float[np.ndarray, "3 3"]:
    """The symmetric matrix with one at the entries `ef` and `fe`."""
    E = e[:, None] * f
    return np.maximum(E, E.T)
