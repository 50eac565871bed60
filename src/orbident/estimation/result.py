"""What identification found: the object that all later stages are given."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.least_squares import Fits
from orbident.estimation.predicted import Signals
from orbident.estimation.recursive.history import History
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.preprocessing.delays import Delay
from orbident.robot.description import Robot

SCHEMA = "orbident/result/1"


@dataclass(frozen=True)
class Estimates:
    """A set of parameters; NaN where the recording does not determine one."""

    names: tuple[str, ...]
    formulas: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    std: Float[np.ndarray, " n"]

    def __iter__(self) -> Iterator[tuple[str, str, float, float]]:
        """Name, formula, value and standard deviation of each."""
        return zip(self.names, self.formulas, self.values, self.std, strict=True)

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for NaN."""
        return {
            "names": list(self.names),
            "formulas": list(self.formulas),
            "values": nulled(self.values),
            "std": nulled(self.std),
        }


@dataclass(frozen=True)
class Estimate:
    """One number and its standard deviation; NaN where it is not determined."""

    value: float
    std: float


@dataclass(frozen=True)
class Result:
    """Everything identified from one recording."""

    robot: Robot
    method: str
    initial_momentum: str
    status: Literal["ok", "rejected"]
    warnings: tuple[str, ...]
    mass: Estimate
    """Total mass, kg."""
    mass_forms: Estimates
    """Eq. 32: the mass by each product form, kg."""
    pi: Estimates
    phi: Estimates
    base: Estimates
    """The free-flying base parameters `M, sigma, iota`."""
    condition_number: dict[str, float]
    residual: dict[str, Any]
    biases: dict[str, dict[str, float]]
    """Of sensors, with their standard deviations; SI."""
    clocks: dict[str, Delay]
    """By sensor, by how much its clock is behind that of the base rate."""
    rejected: Mapping[str, Mapping[str, int]]
    """By column and reason, how many samples were left out."""
    origins: dict[str, str]
    """How rates and velocities were obtained: measured, or derived."""
    samples: int
    elapsed_s: float
    versions: dict[str, str]
    base_covariance: Float[np.ndarray, "beta beta"] = field(repr=False)
    """Of `M, sigma, iota`; NaN where one is not determined."""
    fits: Fits | None = field(default=None, compare=False, repr=False)
    """The linear fits; not kept in `result.json`."""
    covariance: Float[np.ndarray, "n n"] | None = field(
        default=None, compare=False, repr=False
    )
    """Of `[pi, phi]`; None for a result that was read from a file."""
    history: History | None = field(default=None, compare=False, repr=False)
    """How a recursive estimate came about; in a RUN it is `history.csv`."""
    motion: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """How far and how fast all moved that was recorded."""
    input: Mapping[str, Any] = field(default_factory=dict)
    """The recording's `file` and its `sha256`, and the `seed` of a simulated one."""
    signals: Callable[[], Signals] = field(default=tuple, compare=False, repr=False)
    """What was measured and predicted; in a RUN it is `signals.parquet`."""

    def check_accepted(self) -> None:
        """Refuse to go on with what must not be trusted.

        Raises:
            InputError: the result is rejected.
        """
        if self.status == "rejected":
            reason = next(iter(self.warnings), "no reason given")
            raise InputError(
                f"the result for '{self.robot.name}' is rejected, so no model is made "
                f"of it: {reason}"
            )

    def dynamics(self) -> Dynamics:
        """`H+`, `c+` and Jacobians from `(pi, phi, M)` (Eq. 16); no CAD inertia used.

        Raises:
            InputError: the result is rejected or not complete, or no mechanism has
                such parameters.
        """
        self.check_accepted()
        return reconstructed(self.robot, self.base.values, self.base_covariance)

    def to_json(self) -> dict[str, Any]:
        """The content of `result.json`."""
        return {
            "schema": SCHEMA,
            "robot": self.robot.name,
            "method": self.method,
            "initial_momentum": self.initial_momentum,
            "status": self.status,
            "warnings": list(self.warnings),
            "mass": {
                "value": nulled(self.mass.value),
                "std": nulled(self.mass.std),
                "forms": self.mass_forms.to_json(),
            },
            "pi": self.pi.to_json(),
            "phi": self.phi.to_json(),
            "base": {
                **self.base.to_json(),
                "covariance": [nulled(row) for row in self.base_covariance],
            },
            "condition_number": {
                k: nulled(v) for k, v in self.condition_number.items()
            },
            "residual": self.residual,
            "biases": self.biases,
            "clocks": {
                sensor: {
                    "late": nulled(delay.late),
                    "std": nulled(delay.std),
                    "corrected": delay.believed,
                }
                for sensor, delay in self.clocks.items()
            },
            "rejected": {name: dict(why) for name, why in self.rejected.items()},
            "signals": self.origins,
            "samples": self.samples,
            "motion": dict(self.motion),
            "input": dict(self.input),
            "elapsed_s": self.elapsed_s,
            "versions": self.versions,
        }


def nulled(numbers: Float[np.ndarray, " n"] | float) -> Any:
    """Numbers as JSON has them: null for what is not finite."""
    if isinstance(numbers, np.ndarray):
        return [nulled(float(number)) for number in numbers]
    return float(numbers) if np.isfinite(numbers) else None
