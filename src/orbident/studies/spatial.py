"""Section 4: the spatial three-joint servicer, from Table 1 to Table 4."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.seeds import ONE_RUN, SeedRuns, Series, StudyRuns
from orbident.choices import StudyNoise
from orbident.errors import InputError
from orbident.estimation.identify import Method, identify
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.result import Result
from orbident.excitation.bound import bound_of
from orbident.excitation.conditions import Conditions, conditions_for
from orbident.excitation.criterion import Basis
from orbident.excitation.floating import spun_up
from orbident.files.json_parts import nulled
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.low_pass import CutOff
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.measure import Truth, measure_truth, truth_of
from orbident.simulation.simulate import float_along, motion_recording, simulate
from orbident.studies import paper_tables
from orbident.studies.paper_method import (
    Filters,
    PaperParameters,
    condition_in_basis,
    from_imu,
    paper_method,
)
from orbident.studies.paper_tables import (
    PaperRow,
    paper_basis,
    planar_columns,
    planar_trajectory,
    spatial_columns,
    spatial_robot,
    spatial_trajectory,
)
from orbident.trajectories.trajectory import Trajectory

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
    if robot.name == "paper-spatial":
        # Without limits in the paper; the robot file has what Table 2 reaches.
        trajectory, columns, quoted = spatial_trajectory(robot), spatial_columns, None
    elif robot.name == "cepheus-like":
        # All at rest, then the wheel spun up: the base turns when recording starts.
        printed = planar_trajectory(robot)
        initial = spun_up(robot, dict(printed.initial.wheel_speed), printed.start)
        trajectory = replace(printed, initial=initial)
        columns, quoted = planar_columns, paper_tables.PLANAR_CONDITION
    else:
        raise InputError(
            f"{robot.name}: --like-paper: the paper has no trajectory for it; use "
            "paper-spatial or cepheus-like"
        )
    basis = paper_basis(minimal_sets(robot), columns)
    given = conditions_for(robot, trajectory.duration, HARMONICS, like=trajectory)
    in_paper_basis = Basis(
        np.linalg.inv(basis.pi_of_pi), np.linalg.inv(basis.phi_of_phi)
    )
    return PaperCase(replace(given, basis=in_paper_basis), trajectory, quoted)


EXACT = 1e-9
"""Relative error below which a noise-free parameter counts as recovered,"""

INTEGRATED = 1e-5
"""and where the motion between samples was integrated."""

SEEDS_BY_SENSOR = 20
"""Most seeds with one sensor's noise alone: they show which sensor an error comes from,
which takes fewer than its exact size."""


@dataclass(frozen=True)
class SpatialStudy(StudyRuns):
    """Table 4 and everything it was made from."""

    rows: tuple[PaperRow, ...]
    by_sensor: Mapping[str, Float[np.ndarray, " parameters"]]
    """RMS error (%) with the noise of one sensor alone, by the paper's method."""
    cut_offs: Mapping[str, CutOff]
    """Cut-offs of the paper's filters, by signal; empty without noise."""
    condition_number: dict[str, float]
    method: str
    noisy: bool
    """Whether the sensors had noise."""
    trajectory: Trajectory
    recording: Recording
    """The recording of the first seed, as the sensors have it."""
    result: Result
    """The result of the first seed."""

    @property
    def trusted(self) -> bool:
        """Whether Table 4's values were met, without noise exactly."""
        limit = INTEGRATED if self.method == "maximum-likelihood" else EXACT
        exact = self.noisy or all(
            abs(row.error_percent) < 100 * limit for row in self.rows
        )
        return exact and not self.rejected and all(row.as_printed for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "method": self.method,
            "parameters": [row.to_json() for row in self.rows],
            "rms_error_percent_by_sensor": {
                sensor: nulled(rms) for sensor, rms in self.by_sensor.items()
            },
            "condition_number": self.condition_number,
            **self.counts,
        }


def run_spatial(
    noise: StudyNoise = "none",
    runs: SeedRuns = ONE_RUN,
    method: Literal["paper"] | Method = "paper",
) -> SpatialStudy:
    """Simulate, identify by Eqs. 24 and 31, compare with Table 4.

    The noise of `"paper"` is Section 3.5's. The method `"paper"` filters the recordings
    and solves Eq. 24 with the first sample subtracted; every other one is a method of
    `identify`, which takes the recordings unfiltered.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = spatial_robot()
    trajectory = spatial_trajectory(robot)
    motion = float_along(robot, trajectory, paper_tables.SPATIAL_RATE)
    table = PaperParameters.of(robot, spatial_columns)
    filters = Filters()
    true = truth_of(robot, motion, trajectory)
    noisy = _NoisyMotion(robot, trajectory, motion.t, true, table, filters, method)
    by_sensor, over = {}, np.full((3, table.true.size), np.nan)
    if noise == "none":
        recording = motion_recording(robot, motion)
        result = noisy.identified(recording)
        runs, rejected = ONE_RUN, result.status == "rejected"
    else:
        first = recording, result = noisy.run(runs.first)
        bound = bound_of(robot, trajectory).parameters
        std = np.append(table.std(bound), np.sqrt(bound.base.covariance[0, 0]))
        least = 100 * np.abs(std / table.true)
        sensors = list(robot.sensors.declared) if method == "paper" else []
        some = runs.numbers[:SEEDS_BY_SENSOR]
        errors, *parts = runs.over(
            Series(noisy.run, runs.numbers, noisy.errors_of, (first,)),
            *(Series(noisy.alone(each).run, some, noisy.errors_of) for each in sensors),
        )
        by_sensor = {s: part.rms for s, part in zip(sensors, parts, strict=True)}
        over = np.stack([errors.rms, errors.worst, least])
        rejected = np.isnan(errors.runs).any(axis=1).sum()
    return SpatialStudy(
        rows=_rows(table, result, over, noise == "paper"),
        by_sensor=by_sensor,
        cut_offs=filters.cut_offs,
        condition_number=condition_in_basis(table.basis, result),
        method=method,
        noisy=noise == "paper",
        trajectory=trajectory,
        recording=recording,
        result=result,
        seeds=runs.seeds,
        rejected=int(rejected),
        elapsed_s=time.perf_counter() - started,
    )


def _rows(
    table: PaperParameters,
    result: Result,
    over: Float[np.ndarray, "3 parameters"],
    noisy: bool,
) -> tuple[PaperRow, ...]:
    """Table 4; `over` the seeds RMS and worst error, and the least RMS that can be."""
    # The paper prints no true value of M; Table 1's masses add up to it.
    printed = {
        **paper_tables.SPATIAL_TRUE,
        "M": (None, None, paper_tables.SPATIAL_MASS_ERROR),
    }
    return tuple(
        PaperRow(name, true, with_noise if noisy else exact, *map(float, numbers))
        for (name, (true, exact, with_noise)), *numbers in zip(
            printed.items(), table.true, table.found(result), *over, strict=True
        )
    )


class _NoisyMotion(NamedTuple):
    """The same motion, measured anew with every seed."""

    robot: Robot
    trajectory: Trajectory
    t: Float[np.ndarray, " rows"]
    true: Truth
    table: PaperParameters
    filters: Filters
    method: Literal["paper"] | Method

    def alone(self, sensor: str) -> "_NoisyMotion":
        """The same with the noise of one sensor; the others are ideal."""
        sensors = self.robot.sensors
        ideal = {
            name: each.ideal()
            for name, each in sensors.declared.items()
            if name != sensor
        }
        return self._replace(
            robot=replace(self.robot, sensors=sensors.model_copy(update=ideal))
        )

    def run(self, seed: int) -> tuple[Recording, Result]:
        recording = measure_truth(self.robot, self.t, self.true, seed)
        if self.method != "paper":
            return recording, self.identified(recording)
        ready = from_imu(self.robot, recording, self.trajectory.initial, self.filters)
        return recording, self.identified(ready)

    def identified(self, recording: Recording) -> Result:
        if self.method == "paper":
            return paper_method(self.robot, recording, "first-sample")
        return identify(self.robot, recording, self.method)

    def errors_of(
        self, made: tuple[Recording, Result]
    ) -> Float[np.ndarray, " parameters"]:
        return self.table.errors(self.table.found(made[1]))
