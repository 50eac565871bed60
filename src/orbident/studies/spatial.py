"""Section 4: the spatial three-joint servicer, from Table 1 to Table 4.

Whether an installation works: the paper's robot, simulated and identified. Under which
conditions the paper designed its two exciting trajectories.
"""

import time
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.least_squares import LeastSquares
from orbident.excitation.conditions import Conditions, conditions_for
from orbident.excitation.criterion import Basis
from orbident.excitation.floating import spun_up
from orbident.model.minimal_sets import minimal_sets
from orbident.model.paper_bases import (
    Columns,
    paper_basis,
    planar_columns,
    spatial_columns,
)
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies import paper_tables
from orbident.studies.planar import planar_trajectory
from orbident.trajectories.trajectory import InitialState, Trajectory


def spatial_robot() -> Robot:
    """Table 1's servicer."""
    return load_robot("paper-spatial")


def spatial_trajectory(robot: Robot) -> Trajectory:
    """Table 2's exciting trajectory with Table 3's initial conditions."""
    at_rest = np.zeros((len(robot.joints), 3))
    speeds = {
        wheel.name: momentum / wheel.inertia
        for wheel, momentum in zip(
            robot.wheels, paper_tables.SPATIAL_WHEEL_MOMENTUM, strict=True
        )
    }
    return Trajectory(
        duration=paper_tables.SPATIAL_DURATION,
        joints=robot.joint_names,
        a=np.array(paper_tables.SPATIAL_A),
        b=np.array(paper_tables.SPATIAL_B),
        start=at_rest,
        end=at_rest,
        initial=InitialState(
            angular_velocity=np.array(paper_tables.SPATIAL_ANGULAR_VELOCITY),
            attitude=np.array(paper_tables.SPATIAL_ATTITUDE),
            wheel_speed=speeds,
        ),
        source="Table 2",
    )


LARGEST_ERROR = 1e-6
"""Relative. Without noise only rounding is left, some 1e-14."""


@dataclass(frozen=True)
class SelfTest:
    """What came out."""

    robot: str
    parameters: int
    error: float
    """The largest error of a base parameter, relative to the true value."""
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every parameter was found."""
        # Not a number is no small error.
        return bool(self.error < LARGEST_ERROR)


def self_test() -> SelfTest:
    """Identifies the bundled robot of the paper's spatial study, without noise."""
    start = time.monotonic()
    robot = spatial_robot()
    recording = simulate(robot, spatial_trajectory(robot))
    base = identify(robot, recording, LeastSquares()).base
    scale = np.where(base.nominal == 0, np.abs(base.nominal).max(), base.nominal)
    error = float(np.max(np.abs((base.values - base.nominal) / scale)))
    return SelfTest(robot.name, len(base.names), error, time.monotonic() - start)


HARMONICS = 3


class PaperCase(NamedTuple):
    """One of the paper's two designs."""

    conditions: Conditions
    trajectory: Trajectory
    """The paper's own, Table 2 or 5."""
    quoted: float | None
    """The condition number of `Y-hat` that the paper gives for it."""


def paper_case(robot: Robot) -> PaperCase:
    """Tables 2 and 3, or Table 5 with Eqs. 45 and 46; condition in the paper's basis.

    Raises:
        InputError: the robot is neither `paper-spatial` nor `cepheus-like`.
    """
    cases = {"paper-spatial": _spatial, "cepheus-like": _planar}
    if robot.name not in cases:
        raise InputError(
            f"{robot.name}: --like-paper: the paper has no trajectory for it; use "
            f"{' or '.join(cases)}"
        )
    trajectory, columns, quoted = cases[robot.name](robot)
    basis = paper_basis(minimal_sets(robot), columns)
    given = conditions_for(robot, trajectory.duration, HARMONICS, like=trajectory)
    in_paper_basis = Basis(
        np.linalg.inv(basis.pi_of_pi), np.linalg.inv(basis.phi_of_phi)
    )
    return PaperCase(replace(given, basis=in_paper_basis), trajectory, quoted)


_Case = tuple[Trajectory, Columns, float | None]


def _spatial(robot: Robot) -> _Case:
    """Without limits in the paper; the robot file has what Table 2 reaches."""
    return spatial_trajectory(robot), spatial_columns, None


def _planar(robot: Robot) -> _Case:
    """All at rest, then the wheel spun up: the base turns when recording starts."""
    printed = planar_trajectory(robot)
    speeds = dict(printed.initial.wheel_speed)
    spinning = replace(printed, initial=spun_up(robot, speeds, printed.start))
    columns = planar_columns(paper_tables.PLANAR_JOINT1)
    return spinning, columns, paper_tables.PLANAR_CONDITION
