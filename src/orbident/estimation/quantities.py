"""Numbers with standard deviations: one, a named set, or all that is identified."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Float

from orbident.files.data_frames import frame

LISTED = 8
"""Parameters that a `repr` shows."""


@dataclass(frozen=True, repr=False)
class Parameters:
    """A set of parameters; NaN where the recording does not determine one."""

    names: tuple[str, ...]
    formulas: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    std: Float[np.ndarray, " n"]

    def __iter__(self) -> Iterator[tuple[str, str, float, float]]:
        """Name, formula, value and standard deviation of each."""
        return zip(self.names, self.formulas, self.values, self.std, strict=True)

    def __repr__(self) -> str:
        """The first of them, a line each, and how many more there are."""
        width = max(map(len, self.names[:LISTED]), default=0)
        lines = [
            f"{name:{width}} {value:12.6g} +- {std:<8.2g} {formula}".rstrip()
            for name, formula, value, std in islice(self, LISTED)
        ]
        left = len(self.names) - len(lines)
        more = [f"{left} more: .names, .values, .std, .formulas"] if left else []
        return "\n".join([*lines, *more]) or "no parameters"

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for NaN."""
        return {
            "names": list(self.names),
            "formulas": list(self.formulas),
            "values": nulled(self.values),
            "std": nulled(self.std),
        }


UNITS = {
    "M": "kg",
    "sigma": "kg m",
    "iota": "kg m^2",
    "phi": "m",
    "pi": "kg m^2",
}
"""Units by what a parameter's name begins with."""


@dataclass(frozen=True, repr=False)
class EstimatedSet(Parameters):
    """A minimal set of a robot, beside what its CAD inertia says of it."""

    nominal: Float[np.ndarray, " n"]
    """As CAD has it: zero where that is zero but for rounding."""

    @property
    def units(self) -> tuple[str, ...]:
        """SI."""
        return tuple(UNITS[name.partition("_")[0]] for name in self.names)

    @property
    def sigmas(self) -> Float[np.ndarray, " n"]:
        """How far each is from CAD, in its own standard deviations."""
        std = np.where(self.std > 0, self.std, np.nan)
        return (self.values - self.nominal) / std

    @property
    def percent(self) -> Float[np.ndarray, " n"]:
        """How far each is from CAD, in percent of it; NaN where CAD has zero."""
        cad = np.where(self.nominal == 0, np.nan, self.nominal)
        return 100 * (self.values / cad - 1)

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for NaN."""
        return {**super().to_json(), "nominal": nulled(self.nominal)}

    def to_frame(self) -> Any:
        """A `pandas.DataFrame` with a row for each parameter; NaN: not determined.

        Raises:
            MissingLibraryError: pandas is not installed.
        """
        columns = {
            "value": self.values,
            "std": self.std,
            "nominal": self.nominal,
            "sigmas": self.sigmas,
            "percent": self.percent,
            "unit": self.units,
            "formula": self.formulas,
        }
        return frame(columns, self.names, "parameter")


@dataclass(frozen=True, repr=False)
class MassRoutes(Parameters):
    """The total mass by every route that gives one, kg."""

    sigmas: Float[np.ndarray, " n"]
    """How far a form of Eq. 32 is from what all forms give together, and a route from
    the method's own mass, over the deviation of that difference; NaN for the last."""
    left_out: int
    """So many routes give no mass: their deviation is beyond a tenth of it."""

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for NaN."""
        more = {"sigmas": nulled(self.sigmas), "left_out": self.left_out}
        return {**super().to_json(), **more}


NO_ROUTES = MassRoutes((), (), np.zeros(0), np.zeros(0), np.zeros(0), 0)


@dataclass(frozen=True, repr=False)
class Quantity:
    """One number and its standard deviation; NaN where it is not determined."""

    value: float
    std: float

    def __repr__(self) -> str:
        """The number with its deviation."""
        return f"{self.value:.6g} +- {self.std:.2g}"


P = TypeVar("P", bound=Parameters)


def without_values(found: P) -> P:
    """The same names, without values."""
    nothing = np.full_like(found.values, np.nan)
    return replace(found, values=nothing, std=nothing)


def nulled(numbers: Float[np.ndarray, " n"] | float) -> Any:
    """Numbers as JSON has them: null for what is not finite."""
    if isinstance(numbers, np.ndarray):
        return [nulled(float(number)) for number in numbers]
    return float(numbers) if np.isfinite(numbers) else None


@dataclass(frozen=True, kw_only=True)
class Identified:
    """The identified parameters; NaN where the recording does not determine one."""

    mass: Quantity
    """Total mass, kg."""
    mass_forms: MassRoutes
    """Eq. 32: the mass by each product form, and by every route, kg."""
    pi: EstimatedSet
    phi: EstimatedSet
    base: EstimatedSet
    """The free-flying base parameters `M, sigma, iota`."""
    base_covariance: Float[np.ndarray, "beta beta"] = field(repr=False)
    """The covariance of `M, sigma, iota`; NaN where one is not determined."""
    covariance: Float[np.ndarray, "n n"] = field(compare=False, repr=False)
    """The covariance of `[pi, phi]`; NaN where one is not determined."""

    def nothing(self) -> "Identified":
        """The same parameters, none of them determined."""
        return Identified(
            mass=Quantity(np.nan, np.nan),
            mass_forms=NO_ROUTES,
            pi=without_values(self.pi),
            phi=without_values(self.phi),
            base=without_values(self.base),
            base_covariance=np.full_like(self.base_covariance, np.nan),
            covariance=np.full_like(self.covariance, np.nan),
        )

    def parameters_to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for what is not determined."""
        covariance = [nulled(row) for row in self.base_covariance]
        return {
            "mass": {
                "value": nulled(self.mass.value),
                "std": nulled(self.mass.std),
                "forms": self.mass_forms.to_json(),
            },
            "pi": self.pi.to_json(),
            "phi": self.phi.to_json(),
            "base": {**self.base.to_json(), "covariance": covariance},
            # Symmetric: each row ends with its variance.
            "covariance": [
                nulled(row[: k + 1]) for k, row in enumerate(self.covariance)
            ],
        }
