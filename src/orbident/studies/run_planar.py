"""Section 5, run: Table 6, the burn, and the validation, without noise and with it."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_trapezoid

from orbident.campaigns.seeds import ONE_RUN, SeedRuns, Series, StudyRuns
from orbident.choices import StudyNoise
from orbident.estimation.identify import Method as Estimator
from orbident.estimation.result import Result
from orbident.estimation.weigh import Weighing
from orbident.files.json_parts import nulled
from orbident.identified.prediction import predict
from orbident.identified.validate import SCORED, Validation
from orbident.preprocessing.low_pass import CutOff
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_blocks
from orbident.robot.description import Robot
from orbident.studies import paper_tables
from orbident.studies.paper_method import (
    Filters,
    PaperParameters,
    condition_in_basis,
    yaw_of,
)
from orbident.studies.paper_tables import PaperRow, planar_robot, planar_trajectory
from orbident.studies.planar import (
    PaperFilters,
    PlanarReading,
    PlanarRun,
    Records,
    fly_planar,
    run_ideal,
    run_noisy,
)
from orbident.trajectories.trajectory import Trajectory

EXACT = 1e-4
"""Relative error below which a noise-free parameter counts as recovered. That of M is
1e-5: between two rows of a burn the base does not turn evenly."""


class PredictionScores(NamedTuple):
    """How well the validation run was predicted."""

    first: Validation | None
    """Validation of the first seed; None where its result could not predict."""
    rms_nrmse: dict[str, float]
    """Over the seeds."""
    worst_nrmse: dict[str, float]

    def to_json(self) -> dict[str, Any]:
        """As `validate --json`, with RMS and worst over the seeds."""
        first = {"nrmse": None, "rms": None, "samples": None}
        return {
            **(first if self.first is None else self.first.to_json()),
            "rms_nrmse": {name: nulled(x) for name, x in self.rms_nrmse.items()},
            "worst_nrmse": {name: nulled(x) for name, x in self.worst_nrmse.items()},
        }


class MethodResult(NamedTuple):
    """What one way of signal processing comes to."""

    rows: tuple[PaperRow, ...]
    """Table 6's parameters; the last is M by Eq. 32."""
    result: Result
    """The result of the first seed."""
    validation: PredictionScores


class Weighed(NamedTuple):
    """The mass by the burn."""

    row: PaperRow
    """The mass by least squares over all samples."""
    slopes: PaperRow
    """The mass by the paper's two slopes."""
    weighing: Weighing
    """The weighing of the first seed."""

    def to_json(self) -> dict[str, Any]:
        """As `weigh --json`, with errors."""
        errors = ("error_percent", "rms_error_percent", "worst_error_percent")
        row, slopes = self.row.to_json(), self.slopes.to_json()
        return {
            **self.weighing.to_json(),
            **{name: row[name] for name in errors},
            "two_slopes": {name: slopes[name] for name in ("estimate", *errors)},
        }


Column = Float[np.ndarray, " n"]


class PaperFigure(NamedTuple):
    """What one figure of the paper shows."""

    title: str
    columns: Mapping[str, Column]
    """Columns by name with unit; time comes first."""


@dataclass(frozen=True)
class PlanarStudy(StudyRuns):
    """Table 6 and Figs. 6 to 13, and everything they were made from."""

    methods: Mapping[str, MethodResult]
    """The paper's first; with ideal sensors least squares alone."""
    mass: Weighed
    condition_number: dict[str, float]
    """Condition numbers in the paper's basis, by the first of the methods."""
    trajectory: Trajectory
    recordings: Records
    """The recordings of the first seed."""
    figures: Mapping[str, PaperFigure]
    """Figures of the first seed, by the first of the methods."""
    cut_offs: Mapping[str, CutOff]
    """Cut-offs of the filters of the paper's method, by signal; empty without noise."""
    noisy: bool
    """Whether the sensors had noise."""

    @property
    def main(self) -> MethodResult:
        """The first of the methods."""
        return next(iter(self.methods.values()))

    @property
    def rows(self) -> tuple[PaperRow, ...]:
        """Table 6's parameters, and M by the burn."""
        return (*self.main.rows[:-1], self.mass.row)

    @property
    def result(self) -> Result:
        """The result of the first seed, by the last of the methods: `identify`'s."""
        return list(self.methods.values())[-1].result

    @property
    def trusted(self) -> bool:
        """Whether everything was found, without noise exactly."""
        exact = all(abs(row.error_percent) < 100 * EXACT for row in self.rows)
        return (self.noisy or exact) and not self.rejected

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "parameters": [_row_json(row) for row in self.rows],
            "condition_number": self.condition_number,
            "weigh": self.mass.to_json(),
            "validation": self.main.validation.to_json(),
            "by_method": {
                name: {
                    "parameters": [_row_json(row) for row in method.rows],
                    "validation": method.validation.to_json(),
                }
                for name, method in self.methods.items()
            },
            **self.counts,
        }


def run_planar(
    noise: StudyNoise = "none",
    runs: SeedRuns = ONE_RUN,
    method: Estimator = "maximum-likelihood",
) -> PlanarStudy:
    """Fly, identify by Eqs. 24 and 31, weigh by Eq. 40, predict Eq. 47's run.

    With the noise of `"paper"`, that of encoders and motion capture, the robot is
    identified twice: by the paper's method, which filters signals first, and by a
    method of `identify`, which takes them unfiltered. All runs have the same flights.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = planar_robot()
    trajectory = planar_trajectory(robot)
    flights = fly_planar(robot, trajectory)
    table = PaperParameters.of(robot, paper_tables.planar_columns)
    filters = PaperFilters(Filters(), Filters())
    if noise == "none":
        runs, first = ONE_RUN, run_ideal(robot, flights, method)
        found = first.quantities(table)[None]
        over = np.full((2, found.size), np.nan)
    else:
        run = partial(run_noisy, robot, flights, filters, method=method)
        first, row_of = run(runs.first), partial(PlanarRun.quantities, table=table)
        (errors,) = runs.over(Series(run, runs.numbers, row_of, (first,)))
        found, over = errors.runs, np.stack([errors.rms, errors.worst])
    parts = np.split(over[:, :-2], len(first.readings), axis=1)
    methods = {
        name: _method(reading, table, part)
        for (name, reading), part in zip(first.readings.items(), parts, strict=True)
    }
    return PlanarStudy(
        methods=methods,
        mass=_weighed(first, table, over[:, -2:]),
        condition_number={
            **condition_in_basis(table.basis, next(iter(methods.values())).result),
            "Y_paper": paper_tables.PLANAR_CONDITION,
        },
        trajectory=trajectory,
        recordings=first.records,
        figures=planar_figures(robot, first),
        cut_offs=filters.identification.cut_offs,
        noisy=noise == "paper",
        seeds=runs.seeds,
        rejected=int(np.isnan(found).any(axis=1).sum()),
        elapsed_s=time.perf_counter() - started,
    )


def _method(
    reading: PlanarReading,
    table: PaperParameters,
    over: Float[np.ndarray, "2 quantities"],
) -> MethodResult:
    """A way's part of the RMS and the worst over the seeds: parameters, then scores."""
    parameters, scores = np.split(over, [-len(SCORED)], axis=1)
    columns = table.true, table.found(reading.result), *parameters
    rows = tuple(
        PaperRow(name, None, None, *map(float, numbers))
        for name, *numbers in zip(paper_tables.PLANAR_IDENTIFIED, *columns, strict=True)
    )
    nrmse = [
        {str(name): float(x) for name, x in zip(SCORED, part, strict=True)}
        for part in scores
    ]
    return MethodResult(rows, reading.result, PredictionScores(reading.scores, *nrmse))


def _weighed(
    first: PlanarRun, table: PaperParameters, over: Float[np.ndarray, "2 2"]
) -> Weighed:
    rms, worst = over
    rows = [
        PaperRow(
            name="M",
            paper_true=paper_tables.PLANAR_MASS_WEIGHED,
            paper_error_percent=paper_tables.PLANAR_MASS_ERROR,
            true=float(table.true[-1]),
            estimate=estimate,
            rms_error_percent=float(rms[k]),
            worst_error_percent=float(worst[k]),
        )
        for k, estimate in enumerate((first.weighing.mass.value, first.by_slopes))
    ]
    return Weighed(*rows, weighing=first.weighing)


def _row_json(row: PaperRow) -> dict[str, Any]:
    return {**row.to_json(), "paper_estimate": paper_tables.PLANAR_IDENTIFIED[row.name]}


class Measured(NamedTuple):
    """A recording as the sensors gave it, and what was made of it."""

    raw: Recording
    ready: Recording
    """The recording with rates of joints and base, and the velocity of S."""


def planar_figures(robot: Robot, run: PlanarRun) -> dict[str, PaperFigure]:
    """The figures by name, `fig06` to `fig13`, of the first way to read a run.

    There are none where its result predicts nothing.
    """
    reading, burn = next(iter(run.readings.values())), run.records.burn
    if reading.scores is None:
        return {}
    identification = Measured(run.records.identification, reading.identification)
    validation = Measured(run.records.validation, reading.validation)
    rate, moved, velocity = _predicted(reading.result, validation)
    thrust = {f"force {k} (N)": burn.column(f"force.{k}") for k in "xy"}
    return {
        "fig06": PaperFigure(
            "Measured joint angles and rates", _joints(robot, identification)
        ),
        "fig07": PaperFigure("Measured base angle and rate", _base(identification)),
        "fig08": PaperFigure(
            "Measured position and velocity of S",
            _position(identification.raw) | _velocity(identification.ready),
        ),
        "fig09": PaperFigure("Translation of S in the burn", _position(burn) | thrust),
        "fig10": PaperFigure(
            "Validation: joint angles and rates", _joints(robot, validation)
        ),
        "fig11": PaperFigure(
            "Validation: base angle, and rate with its prediction",
            _base(validation) | rate,
        ),
        "fig12": PaperFigure(
            "Validation: position of S with its prediction",
            _position(validation.raw) | moved,
        ),
        "fig13": PaperFigure(
            "Validation: velocity of S with its prediction",
            _velocity(validation.ready) | velocity,
        ),
    }


def write_figures(figures: Mapping[str, PaperFigure], folder: Path) -> None:
    """Each as a CSV file, one column a curve.

    Raises:
        InputError: no permission.
    """
    for name, figure in figures.items():
        table = np.column_stack(list(figure.columns.values()))
        write_blocks(folder / f"{name}.csv", list(figure.columns), [table])


def _joints(robot: Robot, seen: Measured) -> dict[str, Column]:
    columns = {"t (s)": seen.raw.t}
    for name in robot.joint_names:
        columns[f"{name} angle (rad)"] = seen.raw.column(f"joint.{name}.position")
    for name in robot.joint_names:
        columns[f"{name} rate (rad/s)"] = seen.ready.column(f"joint.{name}.velocity")
    return columns


def _base(seen: Measured) -> dict[str, Column]:
    return {
        "t (s)": seen.raw.t,
        "base angle z (rad)": yaw_of(seen.raw.vector("attitude", "xyzw")),
        "base rate z (rad/s)": seen.ready.column("gyro.z"),
    }


def _position(raw: Recording) -> dict[str, Column]:
    return {"t (s)": raw.t} | {f"S {k} (m)": raw.column(f"position.{k}") for k in "xy"}


def _velocity(ready: Recording) -> dict[str, Column]:
    rate = {f"S velocity {k} (m/s)": ready.column(f"velocity.{k}") for k in "xy"}
    return {"t (s)": ready.t, **rate}


def _predicted(result: Result, seen: Measured) -> tuple[dict[str, Column], ...]:
    """Base rate, position and velocity of S; where S is on average is not predicted."""
    prediction = predict(result, seen.ready)
    v_S = prediction.v_S[:, :2]
    r_S = cumulative_trapezoid(v_S, prediction.t, axis=0, initial=0)
    r_S += np.mean(seen.raw.vector("position")[:, :2] - r_S, axis=0)
    return (
        {"base rate z predicted (rad/s)": prediction.w[:, 2]},
        {f"S {k} predicted (m)": x for k, x in zip("xy", r_S.T, strict=True)},
        {
            f"S velocity {k} predicted (m/s)": v
            for k, v in zip("xy", v_S.T, strict=True)
        },
    )
