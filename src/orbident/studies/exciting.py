"""The conditions under which the paper designed its two exciting trajectories."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.errors import InputError
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
from orbident.studies import paper_tables
from orbident.studies.planar import planar_trajectory
from orbident.studies.spatial import spatial_trajectory
from orbident.trajectories.trajectory import Trajectory

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
