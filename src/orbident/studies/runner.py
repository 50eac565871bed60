"""Run a study of the paper and set the result beside the paper's own numbers."""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.estimation.triangular import condition_numbers
from orbident.precision import in_float64
from orbident.recordings.recording import Recording
from orbident.regressors.minimal_sets import minimal_sets
from orbident.regressors.paper_bases import paper_basis, spatial_columns
from orbident.sensing.simulate import simulate
from orbident.studies import tables
from orbident.studies.spatial import PRINTED, spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory import Trajectory

EXACT = 1e-9
"""Relative error below which a noise-free parameter counts as recovered."""


@dataclass(frozen=True)
class Row:
    """One parameter of Table 4, the paper's numbers and ours."""

    name: str
    paper_true: float | None
    paper_error_percent: float | None
    true: float
    estimate: float

    @property
    def error_percent(self) -> float:
        """Relative error of the estimate, signed."""
        return 100 * (self.estimate / self.true - 1)

    @property
    def as_printed(self) -> bool:
        """Whether the true value is the paper's, to its printed decimals."""
        return self.paper_true is None or abs(self.true - self.paper_true) <= PRINTED


@dataclass(frozen=True)
class StudyResult:
    """A study's table and everything it was made from."""

    rows: tuple[Row, ...]
    condition_number: dict[str, float]
    trajectory: Trajectory
    recording: Recording
    result: Result
    elapsed_s: float

    @property
    def trusted(self) -> bool:
        """Whether every value is the paper's and was recovered exactly."""
        return self.result.status == "ok" and all(
            row.as_printed and abs(row.error_percent) < 100 * EXACT for row in self.rows
        )

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "parameters": [
                {
                    "name": row.name,
                    "paper_true": row.paper_true,
                    "paper_error_percent": row.paper_error_percent,
                    "true": row.true,
                    "estimate": row.estimate,
                    "error_percent": row.error_percent,
                    "rms_error_percent": None,
                    "worst_error_percent": None,
                    "cramer_rao_percent": None,
                }
                for row in self.rows
            ],
            "condition_number": self.condition_number,
            "seeds": 1,
            "elapsed_s": self.elapsed_s,
        }


@in_float64
def run_spatial() -> StudyResult:
    """Section 4 without noise: simulate, identify by Eqs. 24 and 31, compare."""
    started = time.perf_counter()
    robot = spatial_robot()
    trajectory = spatial_trajectory(robot)
    recording = simulate(robot, trajectory, rate=tables.SPATIAL_RATE)
    result = identify(robot, recording, initial_momentum="first-sample")
    sets = minimal_sets(robot)
    basis = paper_basis(sets, spatial_columns)
    true = [*basis.pi(sets.pi(robot.theta)), *basis.phi(sets.phi(robot.theta))]
    found = [*basis.pi(result.pi.values), *basis.phi(result.phi.values)]
    names = list(tables.SPATIAL_TRUE)
    rows = [
        Row(name, *tables.SPATIAL_TRUE[name][:2], float(was), float(is_))
        for name, was, is_ in zip(names, true, found, strict=True)
    ]
    # The paper prints no true value of M; Table 1's masses add up to it.
    rows.append(Row("M", None, None, robot.mass, result.mass.value))
    assert result.fits is not None
    Y = condition_numbers(result.fits.pi.factor @ np.linalg.inv(basis.pi_of_pi))
    W = condition_numbers(result.fits.phi.factor @ np.linalg.inv(basis.phi_of_phi))
    return StudyResult(
        rows=tuple(rows),
        condition_number={
            "Y": Y[0],
            "Y_normalised": Y[1],
            "W": W[0],
            "W_normalised": W[1],
        },
        trajectory=trajectory,
        recording=recording,
        result=result,
        elapsed_s=time.perf_counter() - started,
    )
