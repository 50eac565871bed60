"""Numbers with standard deviations: one, a named set, or all that is identified."""

from collections.abc import Iterable, Iterator, Sized
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from textwrap import shorten
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Float, Int

from orbident.data_table import (
    Interval,
    Numeric,
    TableRow,
    frame,
)
from orbident.errors import InputError
from orbident.files.json_parts import (
    Count,
    JsonPart,
    NullableNumber,
    NullableSquare,
    NullableStd,
    NullableStds,
    NullableVector,
    Symmetric,
)
from orbident.files.names import counted, joined, suggestion
from orbident.model.formulas import Formulas, of_width, physical_name

LISTED = 8
"""Parameters that a `repr` shows."""


@dataclass(frozen=True, repr=False)
class Parameters(JsonPart):
    """A set of parameters; NaN where the recording does not determine one."""

    names: tuple[str, ...]
    formulas: tuple[str, ...]
    values: NullableVector
    std: NullableStds

    def __post_init__(self) -> None:
        """Refuse columns that do not stand side by side."""
        sizes = {k: len(v) for k, v in vars(self).items() if isinstance(v, Sized)}
        if len(set(sizes.values())) > 1:
            raise InputError(f"{joined(sizes)} are not of one length")

    def __iter__(self) -> Iterator[tuple[str, str, float, float]]:
        """Name, formula, value and standard deviation of each."""
        return zip(self.names, self.formulas, self.values, self.std, strict=True)

    def __getitem__(self, name: str | int) -> "Quantity":
        """One parameter by its name, such as `sigma_1`, or by its number, from 0.

        Raises:
            InputError: there is none of that name or number.
        """
        k = self.names.index(name) if name in self.names else name
        if isinstance(k, str) or k not in range(-len(self.names), len(self.names)):
            hint = suggestion(str(name), self.names, "names")
            raise InputError(f"no parameter {name!r}; {hint}")
        return Quantity(float(self.values[k]), float(self.std[k]))

    def __repr__(self) -> str:
        """The first of them, a line each, and how many more there are."""
        width = max(map(len, self.names[:LISTED]), default=0)
        lines = [
            f"{name:{width}} {Numeric(value, '.6g', std)!s:>12} +- {std:<8.2g} "
            f"{formula}".rstrip()
            for name, formula, value, std in islice(self, LISTED)
        ]
        left = len(self.names) - len(lines)
        more = [f"{left} more: .names, .values, .std, .formulas"] if left else []
        return "\n".join([*lines, *more]) or "no parameters"


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

    nominal: NullableVector
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
class BaseSet(EstimatedSet):
    """The free-flying base parameters `M, sigma, iota`."""

    covariance: NullableSquare
    """NaN where one is not determined."""

    def __post_init__(self) -> None:
        """Refuse a covariance of other parameters."""
        size = len(self.names)
        if self.covariance.shape != (size, size):
            raise InputError(f"the covariance is not {size} by {size}")
        super().__post_init__()


@dataclass(frozen=True, repr=False)
class MassRoutes(Parameters):
    """The total mass by every route that gives one, kg."""

    sigmas: NullableVector
    """How far a form of Eq. 32 is from what all forms give together, and a route from
    the method's own mass, over the deviation of that difference; NaN for the last."""
    left_out: Count
    """So many routes give no mass: their deviation is beyond a tenth of it."""


NO_ROUTES = MassRoutes((), (), np.zeros(0), np.zeros(0), np.zeros(0), 0)


@dataclass(frozen=True, repr=False)
class Quantity:
    """One number and its standard deviation; NaN where it is not determined."""

    value: NullableNumber
    std: NullableStd

    def __float__(self) -> float:
        """The number alone."""
        return float(self.value)

    def __repr__(self) -> str:
        """The number with its deviation."""
        if np.isnan(self.value):
            return "not determined"
        return f"{Numeric(self.value, '.6g', self.std)} +- {self.std:.2g}"


@dataclass(frozen=True, repr=False)
class TotalMass(Quantity):
    """The total mass, kg."""

    forms: MassRoutes = field(compare=False)
    """Eq. 32: the mass by each product form, and by every route, kg."""

    def __repr__(self) -> str:
        """The mass with its deviation and unit."""
        return super().__repr__() + (" kg" if np.isfinite(self.value) else "")


P = TypeVar("P", bound=Parameters)


def without_values(found: P) -> P:
    """The same names, without values."""
    nothing = np.full_like(found.values, np.nan)
    return replace(found, values=nothing, std=nothing)


def fields_as(whole: Any, kind: type) -> dict[str, Any]:
    """The fields that an object has from one of its base classes."""
    return {each.name: getattr(whole, each.name) for each in fields(kind)}


@dataclass(frozen=True, kw_only=True)
class Identified(JsonPart):
    """The identified parameters; NaN where the recording does not determine one."""

    mass: TotalMass
    """Total mass, kg."""
    pi: EstimatedSet
    phi: EstimatedSet
    base: BaseSet
    """The free-flying base parameters `M, sigma, iota`."""
    covariance: Symmetric = field(compare=False, repr=False)
    """The covariance of `[pi, phi]`; NaN where one is not determined."""

    def __post_init__(self) -> None:
        """Refuse a covariance of other parameters."""
        size = len(self.pi.names) + len(self.phi.names)
        if len(self.covariance) != size:
            raise InputError(f"the covariance of pi and phi is not {size} by {size}")

    def __getitem__(self, name: str) -> Quantity:
        """One parameter by its name: `M`, `sigma_1`, `iota_1`, `pi_1` or `phi_1`.

        Raises:
            InputError: there is none of that name.
        """
        for each in (self.base, self.pi, self.phi):
            if name in each.names:
                return each[name]
        names = [n for each in (self.base, self.pi, self.phi) for n in each.names]
        raise InputError(f"no parameter {name!r}; {suggestion(name, names, 'names')}")

    @property
    def mass_forms(self) -> MassRoutes:
        """Eq. 32: the mass by each product form, and by every route, kg."""
        return self.mass.forms

    @property
    def base_covariance(self) -> Float[np.ndarray, "beta beta"]:
        """The covariance of `M, sigma, iota`; NaN where one is not determined."""
        return self.base.covariance

    def nothing(self) -> "Identified":
        """The same parameters, none of them determined."""
        unknown = np.full_like(self.base.covariance, np.nan)
        return Identified(
            mass=TotalMass(np.nan, np.nan, NO_ROUTES),
            pi=without_values(self.pi),
            phi=without_values(self.phi),
            base=replace(without_values(self.base), covariance=unknown),
            covariance=np.full_like(self.covariance, np.nan),
        )


MOST = 9
"""Parameters that fit, with what stands around them, a terminal of 24 lines."""

WIDEST = 25
"""Letters of a physical name that stand, with all beside it, on a line of 80."""

BESIDE = f"{'':8} {'estimate':>10} {'std':>7} {'CAD':>10} {'sigmas':>6}"
"""The head of what stands there."""


def most_different(found: EstimatedSet, most: int) -> Int[np.ndarray, " rows"]:
    """Which parameters to show where not all can be.

    Args:
        found: a set whose first parameter is always shown, as the total mass is.
        most: so many parameters at most.

    Returns:
        All in their order where they are few enough; else the first, and after it those
        that differ from CAD by the most standard deviations, the furthest first.
    """
    if len(found.names) <= most:
        return np.arange(len(found.names))
    off = np.nan_to_num(np.abs(found.sigmas), nan=-1.0)
    order = 1 + np.argsort(-off[1:], kind="stable")
    return np.concatenate([[0], order[: most - 1]])


def parameter_rows(found: EstimatedSet, which: Iterable[int]) -> Iterator[TableRow]:
    """Rows of the parameters with these numbers; the note is the formula.

    Cells are the name, estimate, deviation, unit, 95 %, CAD, sigmas and percent.
    """
    units, sigmas, percent = found.units, found.sigmas, found.percent
    for k in which:
        cells = (
            found.names[k],
            Numeric(found.values[k], ".6g", found.std[k]),
            Numeric(found.std[k], ".2g"),
            units[k],
            Interval(found.values[k], found.std[k]),
            Numeric(found.nominal[k], ".6g", found.std[k]),
            Numeric(sigmas[k], "+.1f" if abs(sigmas[k]) < 1000 else "+.1e"),
            Numeric(percent[k], "+.2g"),
        )
        yield TableRow(cells, found.formulas[k])


def short_table(found: EstimatedSet) -> list[str]:
    """Lines of at most `MOST` parameters, and how far the others are from CAD."""
    shown, what = most_different(found, MOST), physical_names(found)
    lines = [
        f"{'':{WIDEST}} {BESIDE}",
        *(_short_line(found, k, what[k]) for k in shown.tolist()),
    ]
    left = np.setdiff1d(np.arange(len(found.names)), shown)
    off = np.abs(found.sigmas[left])
    near, lost = np.isfinite(off), np.isnan(found.values[left])
    words = []
    if near.any():
        many = counted(int(near.sum()), "more is", "more are")
        most = float(off[near].max())
        within = f"{most:.2g}" if most < 100 else f"{most:.0f}"
        words.append(f"{many} within {within} sigmas of CAD")
    if lost.any():
        many = counted(int(lost.sum()), "more is", "more are")
        words.append(f"{many} not determined")
    return [*lines, f"  {', '.join(words)}"] if words else lines


def physical_names(base: EstimatedSet | Formulas) -> list[str]:
    """What each base parameter is, in `WIDEST` letters; its symbol if need be.

    Of `pi` it is the beginning of the formula.
    """
    if base.names[:1] == ("pi_1",):
        return [shorten(x, WIDEST, placeholder=" ...") for x in base.formulas]
    pairs = zip(base.names, base.formulas, strict=True)
    return of_width([physical_name(*pair) for pair in pairs], WIDEST)


def _short_line(found: EstimatedSet, k: int, what: str) -> str:
    """What a parameter is, its symbol and numbers."""
    ((name, value, std, unit, _, nominal, *_),) = (
        map(str, row.cells) for row in parameter_rows(found, [k])
    )
    far = abs(found.sigmas[k])
    form = "+.1f" if far < 100 else "+.0f" if far < 10_000 else "+.1e"
    off = Numeric(found.sigmas[k], form)
    numbers = f"{name:8} {value:>10} {std:>7} {nominal:>10} {off!s:>6} {unit}"
    return f"{what:{WIDEST}} {numbers}"
