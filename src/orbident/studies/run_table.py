"""Section 5 on a real table: neither level nor even, with drag and motion capture.

The paper's motion read by the paper's method and by ours, and our own motion by ours.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.seeds import ONE_RUN, SeedRuns, Series, StudyRuns
from orbident.estimation.estimate import Estimate
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.result import Result
from orbident.estimation.solve import solve
from orbident.model.kinematics import JointState, inertia_at
from orbident.model.rotations import UNTURNED
from orbident.preprocessing.low_pass import CutOff
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.units import STANDARD_GRAVITY
from orbident.simulation.flight import FreeFlying, OpenLoop, standing
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
from orbident.studies.paper_tables import ParameterRow, planar_robot, planar_trajectory
from orbident.studies.planar import FOLLOWING, measured_record
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

DESIGNED = Path(__file__).with_name("table_motion.yaml")
"""What acts on the table, and the best motion there of a minute's search, by
`design_excitation(robot, conditions=given, budget=60.0)`, with `robot` of `table_robot`
and `given` the paper's conditions without its basis, with any number of harmonics."""


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


def table_motions(robot: Robot) -> tuple[Trajectory, Trajectory]:
    """Table 5's motion and the one designed for a table, with what acts."""
    ours = load_trajectory(DESIGNED).for_robot(robot)
    return replace(planar_trajectory(robot), environment=ours.environment), ours


def truly_acting(robot: Robot, motion: Trajectory) -> dict[str, float]:
    """What a result may call a disturbance, by its name; SI.

    The result's `uneven` is zero where the CM is at the start of the motion.
    """
    acts = motion.environment
    assert acts is not None
    assert acts.tilt is not None
    assert acts.uneven is not None
    A = acts.uneven
    x, y, _ = inertia_at(robot, motion.start[:, 0]).r_cm
    acting = {
        "pull.x": STANDARD_GRAVITY * acts.tilt[0] + A.xx * x + A.xy * y,
        "pull.y": STANDARD_GRAVITY * acts.tilt[1] + A.xy * x + A.yy * y,
        **{f"uneven.{name}": a for name, a in A},
    }
    for body, film in acts.film_drag.items():
        acting[f"drag.{body}"] = film.c
        acting[f"drag.{body}.turning"] = film.c_r
    return acting


def fly_table(robot: Robot, trajectory: Trajectory, seed: int = 0) -> FreeFlying:
    """Fly from rest: the wheel spins up, then the arm moves."""
    rate = robot.sensors.rows_per_second
    t = np.arange(round((SPIN_UP + trajectory.duration) * rate) + 1) / rate
    still = BaseState(np.zeros(3), UNTURNED, np.zeros(3), np.zeros(1))
    h = robot.wheels[0].inertia * paper_tables.PLANAR_WHEEL_SPEED

    def spinning_up(t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 1"]:
        # `2 h / T sin^2(pi t / T)` on the rotor, until it has its momentum.
        during = np.sin(np.pi * np.minimum(t / SPIN_UP, 1.0)) ** 2
        return (2 * h / SPIN_UP * during)[:, None]

    q, _, _ = trajectory.at(np.zeros(1))
    return free_flying(
        robot,
        t,
        standing(still, q[0]),
        Delayed(trajectory, SPIN_UP),
        FOLLOWING,
        wheels=OpenLoop(spinning_up),
        tolerance=TOLERANCE,
        environment=trajectory.environment,
        seed=seed,
    )


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
        return cls(np.array([*pi, *phi, M.value]), np.append(table.std(found), M.std))


class TableRun(NamedTuple):
    """One seed."""

    recording: Recording
    """The recording of our motion."""
    readings: dict[str, TableReading]
    """The parameters that each way has: `paper`, `with` and `ours`."""
    results: tuple[Result, ...]
    """Those of maximum likelihood, of the paper's motion and of ours."""
    refused: str
    """Why the paper's method refuses its result; empty where it does not."""


FAR = 5.0
"""Deviations that a parameter may be off."""


@dataclass(frozen=True)
class MethodParameter(ParameterRow):
    """A parameter as one way has it."""

    name: str
    true: float
    estimate: float
    """The estimate of the first seed, as `std` is."""
    std: float
    rms_error_percent: float
    """Over the seeds."""

    @property
    def std_percent(self) -> float:
        """Deviation of the estimate, of its true value."""
        return abs(100 * self.std / self.true)

    @property
    def sigmas(self) -> float:
        """The error in deviations of the estimate."""
        return (self.estimate - self.true) / self.std


class Acted(NamedTuple):
    """A disturbance, as it was and as the first result of our motion has it; SI."""

    name: str
    unit: str
    true: float
    estimate: float
    std: float

    @property
    def sigmas(self) -> float:
        """The error in deviations of the estimate."""
        return (self.estimate - self.true) / self.std


@dataclass(frozen=True)
class TableStudy(StudyRuns):
    """What a real table does to the paper's motion and method, and to ours."""

    methods: Mapping[str, tuple[MethodParameter, ...]]
    """The paper's motion by the `paper`'s method, `with` maximum likelihood, and a
    motion of `ours` by it."""
    acted: tuple[Acted, ...]
    """What the first result of our motion says that acted, where it is constant."""
    refused: str
    """Why the paper's method refuses the first recording; empty where it does not."""
    trajectory: Trajectory
    """Our motion."""
    recording: Recording
    """Its recording of the first seed."""
    result: Result
    """Maximum likelihood's result of it."""
    cut_offs: Mapping[str, CutOff]
    """Cut-offs of the filters of the paper's method, by signal."""

    @property
    def trusted(self) -> bool:
        """Whether no result was refused, and the first is right within deviations."""
        rows = [*self.methods[WITH], *self.methods[OURS]]
        return not self.rejected and max(abs(row.sigmas) for row in rows) < FAR

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "by_method": {
                name: [row.to_json() for row in rows]
                for name, rows in self.methods.items()
            },
            "acted": [each._asdict() for each in self.acted],
            "paper_refused": self.refused or None,
            **self.counts,
        }


def run_table(runs: SeedRuns = ONE_RUN) -> TableStudy:
    """Fly both motions with each seed, and read their recordings.

    Each seed has another slow torque, and other noise of encoders and motion capture.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = table_robot()
    motions = table_motions(robot)
    table = PaperParameters.of(robot, paper_tables.planar_columns)
    noisy = _NoisyTable(robot, motions, table, Filters())
    first = noisy.run(runs.first)
    series = Series(noisy.run, runs.numbers, noisy.quantities_of, (first,))
    (errors,) = runs.over(series)
    methods = {}
    for name, rms in zip(
        (PAPER, WITH, OURS), errors.rms[1:].reshape(3, -1), strict=True
    ):
        columns = table.true, *first.readings[name], rms
        methods[name] = tuple(
            MethodParameter(parameter, *map(float, numbers))
            for parameter, *numbers in zip(
                paper_tables.PLANAR_IDENTIFIED, *columns, strict=True
            )
        )
    true = truly_acting(robot, motions[1])
    return TableStudy(
        methods=methods,
        acted=tuple(
            Acted(name, fit.unit, float(true[name]), fit.value, fit.std)
            for name, fit in first.results[1].disturbances.items()
            if name in true
        ),
        refused=first.refused,
        trajectory=motions[1],
        recording=first.recording,
        result=first.results[1],
        cut_offs=noisy.filters.cut_offs,
        seeds=runs.seeds,
        rejected=int(errors.runs[:, 0].sum()),
        elapsed_s=time.perf_counter() - started,
    )


class _NoisyTable(NamedTuple):
    """The same motions, flown and measured anew with every seed."""

    robot: Robot
    motions: tuple[Trajectory, Trajectory]
    table: PaperParameters
    filters: Filters

    def run(self, seed: int) -> TableRun:
        """Fly both; read the paper's by its method, and both by maximum likelihood."""
        robot = self.robot
        recordings = [
            measured_record(robot, fly_table(robot, each, seed), seed)
            for each in self.motions
        ]
        filtered = from_mocap(robot, recordings[0], self.filters)
        paper = paper_fits(robot, filtered, "at-rest")
        both = [
            solve(robot, each, "at-rest", OutputError(), lambda _: None)
            for each in recordings
        ]
        result = judged(paper, LeastSquares.name)
        return TableRun(
            recording=recordings[1],
            readings={
                name: TableReading.of(each.estimate, self.table)
                for name, each in zip((PAPER, WITH, OURS), (paper, *both), strict=True)
            },
            results=tuple(judged(each, OutputError.name) for each in both),
            refused=result.warnings[0] if result.status == "rejected" else "",
        )

    def quantities_of(self, run: TableRun) -> Float[np.ndarray, " quantities"]:
        """Whether it is refused, then the errors of each way of reading."""
        errors = (self.table.errors(each.values) for each in run.readings.values())
        rejected = any(result.status == "rejected" for result in run.results)
        return np.concatenate([[rejected], *errors])
