"""Section 4, run: Table 4 without noise and with it.

Which sensor an error comes from: all others without noise.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.executors import Executors, InThisProcess
from orbident.campaigns.seeds import Errors, Series, check_seeds, over_seeds
from orbident.choices import StudyNoise
from orbident.estimation.found import EstimatedParameters
from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.excitation.bound import cramer_rao
from orbident.files.json_parts import nulled
from orbident.model.minimal_sets import minimal_sets
from orbident.model.paper_bases import PaperBasis, paper_basis, spatial_columns
from orbident.preprocessing.low_pass import CutOff
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import SensorsSpec
from orbident.simulation.free_floating import FreeFloating
from orbident.simulation.measure import measure
from orbident.simulation.simulate import float_along, motion_recording
from orbident.studies import paper_tables
from orbident.studies.paper_method import (
    Filters,
    condition_in_basis,
    from_imu,
    paper_method,
)
from orbident.studies.paper_tables import PaperRow
from orbident.studies.spatial import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory import Trajectory


def sensors_alone(sensors: SensorsSpec, noisy: str) -> SensorsSpec:
    """Sensors of which only one is noisy; the others are ideal.

    Args:
        sensors: of a robot.
        noisy: the sensor that keeps its noise.
    """
    others = {
        name: sensor.ideal()
        for name, sensor in sensors.declared.items()
        if name != noisy
    }
    return sensors.model_copy(update=others)


EXACT = 1e-9
"""Relative error below which a noise-free parameter counts as recovered,"""

INTEGRATED = 1e-5
"""and where the motion between samples was integrated."""

SEEDS_BY_SENSOR = 20
"""Most seeds with one sensor's noise alone: they show which sensor an error comes from,
which takes fewer than its exact size."""


@dataclass(frozen=True)
class SpatialStudy:
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
    seeds: int
    rejected: int
    """Seeds whose result was."""
    elapsed_s: float

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
            "seeds": self.seeds,
            "rejected": self.rejected,
            "elapsed_s": self.elapsed_s,
        }


def run_spatial(
    noise: StudyNoise = "none",
    seeds: int = 1,
    first_seed: int = 0,
    method: Literal["paper"] | Method = "paper",
    progress: Callable[[float], object] = lambda _: None,
    executors: Executors = InThisProcess,
) -> SpatialStudy:
    """Simulate, identify by Eqs. 24 and 31, compare with Table 4.

    Args:
        noise: `"paper"` for Section 3.5's.
        seeds: runs with noise, one a seed.
        first_seed: of them.
        method: `"paper"` filters the recordings and solves Eq. 24 with the first sample
            subtracted. Every other one is a method of `identify`, which takes the
            recordings unfiltered.
        progress: is called with the fraction done.
        executors: where all seeds but the first are run.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    check_seeds(seeds)
    robot = spatial_robot()
    trajectory = spatial_trajectory(robot)
    motion = float_along(robot, trajectory, paper_tables.SPATIAL_RATE)
    table = _Table.of(robot)
    filters = Filters()
    noisy = _NoisyMotion(robot, trajectory, motion, table, filters, method)
    bound, by_sensor = None, {}
    if noise == "none":
        recording = motion_recording(robot, motion)
        result, errors = noisy.identified(recording), None
    else:
        recording, result = noisy.run(first_seed)
        bound = cramer_rao(robot, trajectory)
        sensors = list(robot.sensors.declared) if method == "paper" else []
        all_seeds = range(first_seed, first_seed + seeds)
        errors, *parts = over_seeds(
            [
                Series(noisy.errors, all_seeds, (noisy.errors_of(result),)),
                *(
                    Series(noisy.alone(sensor).errors, all_seeds[:SEEDS_BY_SENSOR])
                    for sensor in sensors
                ),
            ],
            executors,
            progress,
        )
        by_sensor = {s: part.rms for s, part in zip(sensors, parts, strict=True)}
    return SpatialStudy(
        rows=table.rows(result, errors, bound),
        by_sensor=by_sensor,
        cut_offs=filters.cut_offs,
        condition_number=condition_in_basis(table.basis, result),
        method=method,
        noisy=noise == "paper",
        trajectory=trajectory,
        recording=recording,
        result=result,
        seeds=seeds if errors is not None else 1,
        rejected=_rejected(result, errors),
        elapsed_s=time.perf_counter() - started,
    )


def _rejected(result: Result, errors: Errors | None) -> int:
    if errors is None:
        return int(result.status == "rejected")
    return int(np.isnan(errors.runs).any(axis=1).sum())


class _Table(NamedTuple):
    """Table 4's parameters: how to get them from a result, and what they are."""

    basis: PaperBasis
    true: Float[np.ndarray, " parameters"]

    @classmethod
    def of(cls, robot: Robot) -> "_Table":
        sets = minimal_sets(robot)
        basis = paper_basis(sets, spatial_columns)
        pi, phi = basis.pi(sets.pi(robot.theta)), basis.phi(sets.phi(robot.theta))
        return cls(basis, np.concatenate([pi, phi, [robot.mass]]))

    def found(self, result: Result) -> Float[np.ndarray, " parameters"]:
        pi, phi = self.basis.pi(result.pi.values), self.basis.phi(result.phi.values)
        return np.concatenate([pi, phi, [result.mass.value]])

    def bounds(self, bound: EstimatedParameters) -> Float[np.ndarray, " parameters"]:
        """Bounds of the parameters' deviations, in percent."""
        pi = self.basis.pi_of_pi, bound.pi.covariance
        phi = self.basis.phi_of_phi, bound.phi.covariance
        M = np.eye(1), bound.base.covariance[:1, :1]
        std = [np.sqrt(np.einsum("ij,jk,ik->i", J, C, J)) for J, C in (pi, phi, M)]
        return 100 * np.abs(np.concatenate(std) / self.true)

    def rows(
        self, result: Result, errors: Errors | None, bound: EstimatedParameters | None
    ) -> tuple[PaperRow, ...]:
        # The paper prints no true value of M; Table 1's masses add up to it.
        printed = {
            **paper_tables.SPATIAL_TRUE,
            "M": (None, None, paper_tables.SPATIAL_MASS_ERROR),
        }
        unknown = np.full(self.true.size, np.nan)
        rms = unknown if errors is None else errors.rms
        worst = unknown if errors is None else errors.worst
        least = unknown if bound is None else self.bounds(bound)
        return tuple(
            PaperRow(
                name=name,
                paper_true=paper_true,
                paper_error_percent=exact if errors is None else noisy,
                true=float(true),
                estimate=float(found),
                rms_error_percent=float(rms[k]),
                worst_error_percent=float(worst[k]),
                cramer_rao_percent=float(least[k]),
            )
            for k, ((name, (paper_true, exact, noisy)), true, found) in enumerate(
                zip(printed.items(), self.true, self.found(result), strict=True)
            )
        )


class _NoisyMotion(NamedTuple):
    """The same motion, measured anew with every seed."""

    robot: Robot
    trajectory: Trajectory
    motion: FreeFloating
    table: _Table
    filters: Filters
    method: Literal["paper"] | Method

    def alone(self, sensor: str) -> "_NoisyMotion":
        sensors = sensors_alone(self.robot.sensors, sensor)
        return self._replace(robot=replace(self.robot, sensors=sensors))

    def run(self, seed: int) -> tuple[Recording, Result]:
        recording = measure(self.robot, self.motion, self.trajectory, seed)
        if self.method != "paper":
            return recording, self.identified(recording)
        initial = self.trajectory.initial
        ready = from_imu(self.robot, recording, initial, self.filters)
        return recording, self.identified(ready)

    def identified(self, recording: Recording) -> Result:
        if self.method == "paper":
            return paper_method(self.robot, recording, "first-sample")
        return identify(self.robot, recording, self.method)

    def errors(self, seed: int) -> Float[np.ndarray, " parameters"]:
        _, result = self.run(seed)
        return self.errors_of(result)

    def errors_of(self, result: Result) -> Float[np.ndarray, " parameters"]:
        return 100 * (self.table.found(result) / self.table.true - 1)
