"""Section 5 on a real table, run: the paper's motion and method beside ours."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.seeds import ONE_RUN, SeedRuns, Series
from orbident.estimation.result import Result
from orbident.files.json_parts import nulled
from orbident.model.paper_bases import planar_columns
from orbident.preprocessing.low_pass import CutOff
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies import paper_tables
from orbident.studies.paper_method import Filters, PaperParameters
from orbident.studies.planar import measured_record
from orbident.studies.table_flights import (
    OURS,
    PAPER,
    WITH,
    TableRun,
    fly_table,
    read_table,
    table_motions,
    table_robot,
    truly_acting,
)
from orbident.trajectories.trajectory import Trajectory

FAR = 5.0
"""Deviations that a parameter may be off."""


class MethodParameter(NamedTuple):
    """A parameter as one way has it."""

    name: str
    true: float
    estimate: float
    """The estimate of the first seed, as `std` is."""
    std: float
    rms_error_percent: float
    """Over the seeds."""

    @property
    def error_percent(self) -> float:
        """Relative error of the estimate, signed."""
        return 100 * (self.estimate / self.true - 1)

    @property
    def std_percent(self) -> float:
        """Deviation of the estimate, of its true value."""
        return abs(100 * self.std / self.true)

    @property
    def sigmas(self) -> float:
        """The error in deviations of the estimate."""
        return (self.estimate - self.true) / self.std

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        numbers = {**self._asdict(), "error_percent": self.error_percent}
        del numbers["name"]
        return {"name": self.name, **{key: nulled(x) for key, x in numbers.items()}}


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
class TableStudy:
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
    seeds: int
    rejected: int
    """Seeds of which a result of maximum likelihood was refused."""
    elapsed_s: float

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
            "seeds": self.seeds,
            "rejected": self.rejected,
            "elapsed_s": self.elapsed_s,
        }


def run_table(runs: SeedRuns = ONE_RUN) -> TableStudy:
    """Fly both motions with each seed, and read their recordings.

    Args:
        runs: each with another slow torque, and other noise of encoders and motion
            capture.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = table_robot()
    motions = table_motions(robot)
    noisy = _NoisyTable(
        robot,
        motions,
        PaperParameters.of(robot, planar_columns(paper_tables.PLANAR_JOINT1)),
        Filters(),
    )
    table, first = noisy.table, noisy.run(runs.first)
    (errors,) = runs.over(
        Series(noisy.run, runs.numbers, noisy.quantities_of, (first,))
    )
    rms = errors.rms[1:].reshape(3, -1)
    return TableStudy(
        methods={
            name: _rows(first, name, table, over)
            for name, over in zip((PAPER, WITH, OURS), rms, strict=True)
        },
        acted=_acted(robot, motions[1], first.results[1]),
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
        paper, ours = (
            measured_record(self.robot, fly_table(self.robot, each, seed), seed)
            for each in self.motions
        )
        return read_table(self.robot, (paper, ours), self.table, self.filters)

    def quantities_of(self, run: TableRun) -> Float[np.ndarray, " quantities"]:
        """Whether it is refused, then the errors of each way of reading."""
        readings = run.readings.values()
        errors = (self.table.errors(reading.values) for reading in readings)
        rejected = any(result.status == "rejected" for result in run.results)
        return np.concatenate([[rejected], *errors])


def _rows(
    first: TableRun,
    method: str,
    table: PaperParameters,
    rms: Float[np.ndarray, " parameters"],
) -> tuple[MethodParameter, ...]:
    reading = first.readings[method]
    names, columns = paper_tables.PLANAR_IDENTIFIED, (table.true, *reading, rms)
    return tuple(
        MethodParameter(name, *map(float, numbers))
        for name, *numbers in zip(names, *columns, strict=True)
    )


def _acted(robot: Robot, motion: Trajectory, result: Result) -> tuple[Acted, ...]:
    true = truly_acting(robot, motion)
    return tuple(
        Acted(name, fit.unit, float(true[name]), fit.value, fit.std)
        for name, fit in result.disturbances.items()
        if name in true
    )
