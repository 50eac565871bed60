"""Section 5 on a real table: neither level nor even, with drag and motion capture.

One recording from a real table, read in three ways.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.base_parameters import (
    EstimatedParameters,
    parameters_of_beta,
    prior_std,
)
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.estimator import OutputError, estimate_of
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.estimation.solve import solve
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.units import STANDARD_GRAVITY
from orbident.simulation.control_laws import OpenLoop
from orbident.simulation.flight import FreeFlying, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.studies import paper_tables
from orbident.studies.paper_method import Filters, PaperParameters, from_mocap
from orbident.studies.planar import FOLLOWING, planar_robot
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory

SPIN_UP = 14.0
"""s from rest; the recording begins before it. The motor gives 0.05 N m at most."""

TOLERANCE = 1e-7
"""rad or m: a hundredth of what motion capture sees."""

SENSORS = {
    "rate": 50.0,
    "joints": {"position": 2e-4},
    "wheels": {"position": 1e-5},
    "attitude": {"angle": 60e-6, "random_walk": (0.0, 0.0, 1e-6)},
    "position": {
        "std": 8.3e-6,
        "markov_std": (9.7e-6, 9.6e-6, 0.0),
        "correlation_time": (0.14, 0.20, 1.0),
        "random_walk": (3e-6, 3e-6, 0.0),
    },
}
"""Motion capture as that of Cepheus is at rest: most of its errors in place last. A
wheel that spins up needs finer encoders than one that keeps its speed."""

TILT = (20e-6, -35e-6)
"""rad."""
UNEVEN = {"xx": 8e-5, "xy": -5e-5, "yy": -6e-5}
"""1/s^2: 10 urad over a metre is 1e-4."""
BASE_FILM = {"c": 8e-3, "c_r": 1e-4}
ELBOW_FILM = {"c": 2e-3, "c_r": 0.0}
"""N s/m and N m s: some percent of the momentum in half a minute."""


class Delayed(NamedTuple):
    """A joint motion that begins later; until then joints stay where it begins."""

    motion: Trajectory
    by: float
    """s."""

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
    ]:
        """Positions, rates and accelerations at these times."""
        return self.motion.at(np.maximum(t - self.by, 0.0))


def table_robot() -> Robot:
    """The planar study's robot, with pads below base and elbow, and such sensors."""
    robot = planar_robot()
    pads = {robot.bodies[0]: np.zeros(3), robot.bodies[-1]: np.zeros(3)}
    return replace(robot, pads=pads, sensors=declared_sensors(SENSORS))


def table_environment(robot: Robot) -> Environment:
    """What is usual on a table that was levelled with care."""
    films = {robot.bodies[0]: BASE_FILM, robot.bodies[-1]: ELBOW_FILM}
    given = {"tilt": TILT, "uneven": UNEVEN, "film_drag": films}
    return Environment.model_validate(given)


def truly_acting(robot: Robot, flight: FreeFlying) -> dict[str, float]:
    """What a result may call a disturbance, by its name; SI.

    Args:
        robot: `table_robot`.
        flight: the result's `uneven` is zero where its CM was at first.
    """
    xx, xy, yy = UNEVEN["xx"], UNEVEN["xy"], UNEVEN["yy"]
    x, y, _ = flight.r_cm[0]
    acting = {
        "pull.x": STANDARD_GRAVITY * TILT[0] + xx * x + xy * y,
        "pull.y": STANDARD_GRAVITY * TILT[1] + xy * x + yy * y,
        **{f"uneven.{name}": a for name, a in UNEVEN.items()},
    }
    films = (robot.bodies[0], BASE_FILM), (robot.bodies[-1], ELBOW_FILM)
    for body, film in films:
        acting[f"drag.{body}"] = film["c"]
        acting[f"drag.{body}.turning"] = film["c_r"]
    return acting


def fly_table(robot: Robot, trajectory: Trajectory) -> FreeFlying:
    """Fly from rest: the wheel spins up, then the arm moves.

    Args:
        robot: `table_robot`.
        trajectory: `planar_trajectory`, with what acts.
    """
    end = SPIN_UP + trajectory.duration
    rate = robot.sensors.rows_per_second
    t = np.arange(round(end * rate) + 1) / rate
    level = np.array([0.0, 0.0, 0.0, 1.0])
    still = BaseState(np.zeros(3), level, np.zeros(3), np.zeros(1))
    q, _, _ = trajectory.at(np.zeros(1))
    return free_flying(
        robot,
        t,
        standing(still, q[0]),
        Delayed(trajectory, SPIN_UP),
        FOLLOWING,
        wheels=OpenLoop(partial(_spinning_up, robot)),
        tolerance=TOLERANCE,
        environment=trajectory.environment,
    )


def _spinning_up(robot: Robot, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 1"]:
    """The torque `2 h / T sin^2(pi t / T)` on the rotor, until it has its momentum."""
    h = robot.wheels[0].inertia * paper_tables.PLANAR_WHEEL_SPEED
    during = np.sin(np.pi * np.minimum(t / SPIN_UP, 1.0)) ** 2
    return (2 * h / SPIN_UP * during)[:, None]


PAPER, WITHOUT, WITH = "paper", "without", "with"


class TableReading(NamedTuple):
    """Table 6's parameters as one way of reading has them, `M` last."""

    values: Float[np.ndarray, " parameters"]
    std: Float[np.ndarray, " parameters"]

    @classmethod
    def of(
        cls, found: EstimatedParameters, M: tuple[float, float], table: PaperParameters
    ) -> "TableReading":
        """The found sets in the basis of the table."""
        pi, phi = table.basis.pi(found.pi.values), table.basis.phi(found.phi.values)
        C_pi = table.basis.pi_of_pi @ found.pi.covariance @ table.basis.pi_of_pi.T
        C_phi = table.basis.phi_of_phi @ found.phi.covariance @ table.basis.phi_of_phi.T
        variances = np.concatenate([np.diag(C_pi), np.diag(C_phi)])
        return cls(np.array([*pi, *phi, M[0]]), np.array([*np.sqrt(variances), M[1]]))


class TableRun(NamedTuple):
    """One seed."""

    recording: Recording
    readings: dict[str, TableReading]
    """The parameters that each way of reading has: `paper`, `without` and `with`."""
    result: Result
    """The result of maximum likelihood that looks for what acts."""
    refused: str
    """Why the paper's method refuses its result; empty where it does not."""


def read_table(
    robot: Robot, flight: Recording, table: PaperParameters, filters: Filters
) -> TableRun:
    """Read a recording by the paper's method, and by maximum likelihood twice.

    Args:
        robot: `table_robot`.
        flight: as its sensors recorded it, from rest.
        table: of Table 6.
        filters: of the paper's method.
    """
    paper, paper_result = _by_paper(robot, from_mocap(robot, flight, filters))
    solved = solve(robot, flight, "at-rest", OutputError(), lambda _: None)
    estimate, sets = solved.estimate, solved.problem.sets
    # The same search, where nothing is known to act and nothing is tested yet.
    bare = replace(robot, disturbances={}, pads={})
    without = solve(bare, flight, "at-rest", OutputError(), lambda _: None).estimate
    assert without.solution is not None
    plain = estimate_of(without.solution, prior_std(robot, sets))
    readings = {
        PAPER: _reading(paper, table),
        WITHOUT: TableReading.of(
            parameters_of_beta(robot, sets, plain), plain.mass, table
        ),
        WITH: _reading(estimate, table),
    }
    result = _judged(solved, "maximum-likelihood")
    rejected = paper_result.status == "rejected"
    return TableRun(
        flight, readings, result, paper_result.warnings[0] if rejected else ""
    )


def _by_paper(robot: Robot, recording: Recording) -> tuple[Estimate, Result]:
    """The linear fits of filtered signals, and what is thought of them."""
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    estimate = LeastSquares().estimate(problem, lambda _: None)
    solved = Solved(problem, obstacles(problem), estimate, None)
    return estimate, _judged(solved, "least-squares")


def _judged(solved: Solved, name: str) -> Result:
    masses = dict(solved.estimate.masses)
    judgement = judge(solved, masses)
    return result_of(
        solved.problem, name, solved.estimate, judgement, masses, None, 0.0
    )


def _reading(estimate: Estimate, table: PaperParameters) -> TableReading:
    M = estimate.mass.value, estimate.mass.std
    return TableReading.of(estimate.parameters, M, table)
