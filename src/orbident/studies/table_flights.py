"""Section 5 on a real table: neither level nor even, with drag and motion capture.

The paper's motion read by the paper's method and by ours, and our own motion by ours.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.estimate import Estimate
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.result import Result
from orbident.estimation.solve import solve
from orbident.model.kinematics import JointState, inertia_at
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.units import STANDARD_GRAVITY
from orbident.simulation.control_laws import OpenLoop
from orbident.simulation.flight import FreeFlying, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.studies import paper_tables
from orbident.studies.paper_method import (
    Filters,
    PaperParameters,
    from_mocap,
    judged,
    paper_fits,
)
from orbident.studies.planar import FOLLOWING, planar_robot, planar_trajectory
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory
from orbident.trajectories.trajectory_file import load_trajectory

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
SLOW_TORQUE = {"std": 1e-4, "correlation_time": 200.0}
"""N m and s: a hose that pulls. A Gauss-Markov process is never smooth: one that lasts
20 s swings faster than what may act on a table, and is another world."""

DESIGNED = Path(__file__).with_name("table_motion.yaml")
"""The best motion of a minute's search, by `design_excitation(robot, conditions=given,
budget=60.0)`, with `robot` of `table_robot` and `given` the paper's conditions without
its basis and with any number of harmonics."""


class Delayed(NamedTuple):
    """A joint motion that begins later; until then joints stay where it begins."""

    motion: Trajectory
    by: float
    """s."""

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at these times."""
        return self.motion.at(np.maximum(t - self.by, 0.0))


def table_robot() -> Robot:
    """The planar study's robot, with pads below base and elbow, and such sensors.

    What may act on it is what may act on any table.
    """
    robot = planar_robot()
    pads = {robot.bodies[0]: np.zeros(3), robot.bodies[-1]: np.zeros(3)}
    sensors = declared_sensors(SENSORS)
    return replace(robot, pads=pads, sensors=sensors, disturbances=None)


def table_environment(robot: Robot) -> Environment:
    """What is usual on a table that was levelled with care."""
    films = {robot.bodies[0]: BASE_FILM, robot.bodies[-1]: ELBOW_FILM}
    given = {"tilt": TILT, "uneven": UNEVEN, "film_drag": films}
    return Environment.model_validate({**given, "slow_torque": SLOW_TORQUE})


def table_motions(robot: Robot) -> tuple[Trajectory, Trajectory]:
    """Table 5's motion and the one designed for a table, with what acts.

    Args:
        robot: `table_robot`.
    """
    environment = table_environment(robot)
    designed = load_trajectory(DESIGNED).for_robot(robot)
    paper, ours = (
        replace(each, environment=environment)
        for each in (planar_trajectory(robot), designed)
    )
    return paper, ours


def truly_acting(robot: Robot, motion: Trajectory) -> dict[str, float]:
    """What a result may call a disturbance, by its name; SI.

    Args:
        robot: `table_robot`.
        motion: the result's `uneven` is zero where the CM is at its start.
    """
    xx, xy, yy = UNEVEN["xx"], UNEVEN["xy"], UNEVEN["yy"]
    x, y, _ = inertia_at(robot, motion.start[:, 0]).r_cm
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


def fly_table(robot: Robot, trajectory: Trajectory, seed: int = 0) -> FreeFlying:
    """Fly from rest: the wheel spins up, then the arm moves.

    Args:
        robot: `table_robot`.
        trajectory: of `table_motions`.
        seed: of the slow torque.
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
        seed=seed,
    )


def _spinning_up(robot: Robot, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 1"]:
    """The torque `2 h / T sin^2(pi t / T)` on the rotor, until it has its momentum."""
    h = robot.wheels[0].inertia * paper_tables.PLANAR_WHEEL_SPEED
    during = np.sin(np.pi * np.minimum(t / SPIN_UP, 1.0)) ** 2
    return (2 * h / SPIN_UP * during)[:, None]


PAPER, WITH, OURS = "paper", "with", "ours"
"""The paper's motion by its method, by maximum likelihood, and our motion by it."""


class TableReading(NamedTuple):
    """Table 6's parameters as one way of reading has them, `M` last."""

    values: Float[np.ndarray, " parameters"]
    std: Float[np.ndarray, " parameters"]

    @classmethod
    def of(cls, estimate: Estimate, table: PaperParameters) -> "TableReading":
        """The found sets in the basis of the table."""
        found, M = estimate.parameters, estimate.mass
        pi, phi = table.basis.pi(found.pi.values), table.basis.phi(found.phi.values)
        C_pi = table.basis.pi_of_pi @ found.pi.covariance @ table.basis.pi_of_pi.T
        C_phi = table.basis.phi_of_phi @ found.phi.covariance @ table.basis.phi_of_phi.T
        variances = np.concatenate([np.diag(C_pi), np.diag(C_phi)])
        std = np.array([*np.sqrt(variances), M.std])
        return cls(np.array([*pi, *phi, M.value]), std)


class TableRun(NamedTuple):
    """One seed."""

    recording: Recording
    """The recording of our motion."""
    readings: dict[str, TableReading]
    """The parameters that each way has: `paper`, `with` and `ours`."""
    results: tuple[Result, Result]
    """Those of maximum likelihood, of the paper's motion and of ours."""
    refused: str
    """Why the paper's method refuses its result; empty where it does not."""


def read_table(
    robot: Robot,
    recordings: tuple[Recording, Recording],
    table: PaperParameters,
    filters: Filters,
) -> TableRun:
    """Read the paper's motion by its method, and both by maximum likelihood.

    Args:
        robot: `table_robot`.
        recordings: of `table_motions`, from rest.
        table: of Table 6.
        filters: of the paper's method.
    """
    paper = paper_fits(robot, from_mocap(robot, recordings[0], filters), "at-rest")
    both = [
        solve(robot, each, "at-rest", OutputError(), lambda _: None)
        for each in recordings
    ]
    readings = (TableReading.of(each.estimate, table) for each in (paper, *both))
    paper_result = judged(paper, LeastSquares.name)
    first, second = (judged(each, OutputError.name) for each in both)
    rejected = paper_result.status == "rejected"
    return TableRun(
        recordings[1],
        dict(zip((PAPER, WITH, OURS), readings, strict=True)),
        (first, second),
        paper_result.warnings[0] if rejected else "",
    )
