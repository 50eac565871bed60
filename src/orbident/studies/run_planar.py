"""Section 5, run: Table 6, the burn, and the validation, without noise and with it."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.seeds import ONE_RUN, Errors, SeedRuns, Series
from orbident.choices import StudyNoise
from orbident.estimation.identify import Method as Estimator
from orbident.estimation.result import Result
from orbident.estimation.weigh import Weighing
from orbident.files.json_parts import nulled
from orbident.identified.validate import SCORED, Validation
from orbident.model.paper_bases import planar_columns
from orbident.preprocessing.low_pass import CutOff
from orbident.robot.description import Robot
from orbident.studies import paper_tables
from orbident.studies.paper_method import Filters, PaperParameters, condition_in_basis
from orbident.studies.paper_tables import PaperRow
from orbident.studies.planar import fly_planar, planar_robot, planar_trajectory
from orbident.studies.planar_run import (
    Measured,
    PaperFigure,
    PaperFilters,
    PlanarReading,
    PlanarRun,
    Records,
    planar_figures,
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


@dataclass(frozen=True)
class PlanarStudy:
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
    seeds: int
    rejected: int
    """Seeds of which something could not be identified, weighed or predicted."""
    elapsed_s: float

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
            "seeds": self.seeds,
            "rejected": self.rejected,
            "elapsed_s": self.elapsed_s,
        }


def run_planar(
    noise: StudyNoise = "none",
    runs: SeedRuns = ONE_RUN,
    method: Estimator = "maximum-likelihood",
) -> PlanarStudy:
    """Fly, identify by Eqs. 24 and 31, weigh by Eq. 40, predict Eq. 47's run.

    Args:
        noise: `"paper"` adds the noise of encoders and motion capture. The robot is
            then identified twice: by the paper's method, which filters signals first,
            and by `method`, which takes them unfiltered.
        runs: with noise; the flights are the same.
        method: of `identify`; with ideal sensors there is no other.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = planar_robot()
    trajectory = planar_trajectory(robot)
    flights = fly_planar(robot, trajectory)
    table = PaperParameters.of(robot, planar_columns(paper_tables.PLANAR_JOINT1))
    filters = PaperFilters(Filters(), Filters())
    if noise == "none":
        runs, first = ONE_RUN, run_ideal(robot, flights, method)
        errors = Errors(first.quantities(table)[None])
    else:
        run = partial(run_noisy, robot, flights, filters, method=method)
        first, row_of = run(runs.first), partial(PlanarRun.quantities, table=table)
        (errors,) = runs.over(Series(run, runs.numbers, row_of, (first,)))
    columns = _Columns(errors, len(first.readings), noise == "paper")
    methods = {
        name: _method(reading, table, columns, k)
        for k, (name, reading) in enumerate(first.readings.items())
    }
    main = next(iter(methods.values()))
    return PlanarStudy(
        methods=methods,
        mass=_weighed(first, table, columns),
        condition_number={
            **condition_in_basis(table.basis, main.result),
            "Y_paper": paper_tables.PLANAR_CONDITION,
        },
        trajectory=trajectory,
        recordings=first.records,
        figures=_figures(robot, first),
        cut_offs=filters.identification.cut_offs,
        noisy=noise == "paper",
        seeds=runs.seeds,
        rejected=int(np.isnan(errors.runs).any(axis=1).sum()),
        elapsed_s=time.perf_counter() - started,
    )


class _Columns(NamedTuple):
    """What the columns of the errors over the seeds are."""

    errors: Errors
    methods: int
    noisy: bool

    def of_method(self, k: int) -> tuple[slice, slice]:
        """Table 6's parameters, and the scores."""
        width = (self.errors.runs.shape[1] - 2) // self.methods
        end = (k + 1) * width
        return slice(k * width, end - len(SCORED)), slice(end - len(SCORED), end)

    def over(
        self, columns: slice
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """RMS and worst of these columns; NaN without noise."""
        rms, worst = self.errors.rms[columns], self.errors.worst[columns]
        if not self.noisy:
            return np.full_like(rms, np.nan), np.full_like(worst, np.nan)
        return rms, worst


def _method(
    reading: PlanarReading, table: PaperParameters, columns: _Columns, k: int
) -> MethodResult:
    parameters, scores = columns.of_method(k)
    rms, worst = columns.over(parameters)
    rows = tuple(
        PaperRow(name, None, None, *map(float, numbers))
        for name, *numbers in zip(
            paper_tables.PLANAR_IDENTIFIED,
            table.true,
            table.found(reading.result),
            rms,
            worst,
            strict=True,
        )
    )
    over = [
        {str(name): float(x) for name, x in zip(SCORED, part, strict=True)}
        for part in columns.over(scores)
    ]
    return MethodResult(rows, reading.result, PredictionScores(reading.scores, *over))


def _weighed(first: PlanarRun, table: PaperParameters, columns: _Columns) -> Weighed:
    rms, worst = columns.over(slice(-2, None))
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


def _figures(robot: Robot, first: PlanarRun) -> dict[str, PaperFigure]:
    reading = next(iter(first.readings.values()))
    if reading.scores is None:
        return {}
    records = first.records
    return planar_figures(
        robot,
        Measured(records.identification, reading.identification),
        records.burn,
        Measured(records.validation, reading.validation),
        reading.result,
    )


def _row_json(row: PaperRow) -> dict[str, Any]:
    return {**row.to_json(), "paper_estimate": paper_tables.PLANAR_IDENTIFIED[row.name]}
