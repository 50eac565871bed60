"""What deviations are made of: a budget, as metrology has it (GUM, JCGM 100:2008).

With `F_s` the information of sensor `s` and `P_k` that of what is known of family `k`
beforehand, an estimate's covariance is `C = (sum F_s + sum P_k)^-1`, and so

    C = sum C F_s C + sum C P_k C

The shares of a variance are positive and add up to one. If a source had `1 / r` of its
deviation, a variance of which it has the share `f` would be at most `1 - f (1 - 1/r^2)`
times as large: so it is with the weights of before, and the best ones do no worse.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Annotated, Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from pydantic import Field

from orbident.data_table import DataTable, table_of
from orbident.errors import InputError
from orbident.estimation.base_parameters import prior_std
from orbident.files.json_parts import JsonPart, NullableTable
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot

Kind = Literal["noise", "recording", "instrument", "other"]
"""The `noise` of a sensor; what is another one in each `recording`, such as its
momentum and what acts from outside; an error of an `instrument`, the same in all. What
is known of the parameters beforehand is an `other`."""

SHOWN = 0.005
"""Smaller shares, and deviations wider by less, are not in tables."""

BETTER = {
    "noise": "one {} times better",
    "instrument": "a calibration {} times better",
}
"""What a smaller source is, by its kind."""


class ErrorSource(NamedTuple):
    """One source of the errors of `beta = [M, sigma, iota]`."""

    kind: Kind
    part: Float[np.ndarray, "beta beta"]
    """What it has of the covariance; those of all sources add up to it."""
    known: Float[np.ndarray, "beta beta"] | None = None
    """The covariance if its unknowns were known; None where it is no unknown."""


ErrorSources = Mapping[str, ErrorSource]
"""All of them, by their names."""


@dataclass(frozen=True, repr=False)
class Budget(JsonPart):
    """What the variance of each parameter is made of."""

    parameters: tuple[str, ...]
    """The base parameters, the total mass first, then `phi` and `pi`."""
    least_sure: str
    """The base parameter whose deviation is largest for a robot of this size."""
    sources: tuple[str, ...]
    """Sensors, drifts, families of what else is unknown, what is known beforehand."""
    kinds: tuple[Kind, ...]
    """What each of them is."""
    shares: NullableTable
    """A row a parameter, a column a source: the part of the variance, in all one; NaN
    for a parameter that is not determined."""
    costs: Annotated[NullableTable, Field(alias="deviation_over_that_if_known")]
    """In the same order, how many times as wide the deviation is as if a family were
    known; NaN for sources that are no unknowns."""

    def __post_init__(self) -> None:
        """Refuse a table that lacks a row or a column."""
        size = len(self.parameters), len(self.sources)
        tables = self.shares.shape, self.costs.shape
        if {*tables} != {size} or len(self.kinds) != size[1] or not self.sources:
            raise InputError(f"the budget is not {size[0]} by {size[1]}")
        if self.least_sure not in self.parameters:
            raise InputError(f"'{self.least_sure}' is no parameter of the budget")

    def __repr__(self) -> str:
        """What limits the mass, and the parameter that is least sure."""
        return self.in_words()

    def table(self) -> DataTable:
        """Sources by parameter, the largest first: shares, then what unknowns cost."""
        head = ("", "shares of its variance, %", "times as wide as if this were known")
        rows = (
            (
                name,
                self._sorted(100 * share, 100 * SHOWN, ".0f"),
                self._sorted(cost, 1 + SHOWN, ".3g"),
            )
            for name, share, cost in zip(
                self.parameters, self.shares, self.costs, strict=True
            )
        )
        title = "budget: what the deviation of each parameter is made of"
        table = table_of(title, head, rows, in_words=True)
        return table._replace(folded=True)

    def _sorted(self, x: Float[np.ndarray, " sources"], least: float, form: str) -> str:
        order = [k for k in np.argsort(-x, kind="stable") if x[k] >= least]
        return ", ".join(f"{self.sources[k]} {x[k]:{form}}" for k in order)

    def in_words(self) -> str:
        """What limits the mass and what is least sure, and what would halve that."""
        mass, least = self.parameters[0], self.least_sure
        limit, of_least = self._limit(mass), self._limit(least)
        words = [f"{mass} {limit}"] if limit else []
        if least != mass and limit == of_least:
            words.append(f"So is {least}, the least sure.")
        elif least != mass and of_least:
            words.append(f"{least}, the least sure, {of_least}")
        return " ".join(words)

    def _limit(self, parameter: str) -> str:
        shares = self.shares[self.parameters.index(parameter)]
        if not np.isfinite(shares).all():
            return ""
        most = int(shares.argmax())
        of = "noise of the " if self.kinds[most] == "noise" else ""
        return (
            f"is limited by {of}{self.sources[most]} "
            f"({100 * shares[most]:.0f} % of its variance); {self.halving(parameter)}."
        )

    def halving(self, parameter: str) -> str:
        """What would at least halve the deviation of a parameter, in words.

        A quarter of its variance is left with `1 - f (1 - 1/r^2) = 1/4`, where `f` is
        the largest share; and with `g + (1 - g) / n = 1/4` of `n` recordings instead of
        one, where `g` is the share of what is the same in all of them.
        """
        row = self.parameters.index(parameter)
        shares, costs = self.shares[row], np.nan_to_num(self.costs[row])
        own = np.isin(self.kinds, ["noise", "recording"])
        most, f, g = int(shares.argmax()), shares.max(), shares[~own].sum()
        r = 1 / np.sqrt(1 - 0.75 / f) if f > 0.75 else np.inf
        # A share of rounding's size asks for no fifth recording.
        n = ceil((1 - g) / (0.25 - g) - 0.01) if g < 0.25 else np.inf
        if r < np.inf and r <= n:
            better = BETTER.get(self.kinds[most], "{} times less of that")
            return f"{better.format(f'{np.ceil(10 * r) / 10:.3g}')} halves its std"
        if n < np.inf:
            return f"{n} times as many recordings halve its std"
        if costs.max() >= 2:
            known = self.sources[int(costs.argmax())]
            return (
                f"its std is {costs.max():.2g} times as wide as if {known} were known"
            )
        return "no source is three quarters of that, and another motion may do more"


def budget_of(
    sources: ErrorSources,
    names: tuple[str, ...],
    robot: Robot,
    sets: MinimalSets,
    beta: Float[np.ndarray, " beta"],
    determined: Bool[np.ndarray, " parameters"],
) -> Budget:
    """The budget of the base parameters, and of `phi` and `pi`, which follow from them.

    Args:
        sources: of the errors of `beta`.
        names: of all parameters, in this order.
        robot: whose parameters they are.
        sets: its minimal sets.
        beta: base parameters.
        determined: which of all the recording determines.
    """
    dpi, dphi = sets.derivatives(beta)
    J = np.vstack([np.eye(beta.size), dphi, dpi])

    def variances(
        C: Float[np.ndarray, "beta beta"],
    ) -> Float[np.ndarray, " parameters"]:
        # Rounding may leave less than zero of nothing.
        of_all = np.maximum(np.einsum("ib,bc,ic->i", J, C, J), 0.0)
        return np.where(determined, of_all, np.nan)

    parts = np.column_stack([variances(each.part) for each in sources.values()])
    whole = parts.sum(axis=1, keepdims=True)
    nothing = np.full_like(determined, np.nan, dtype=float)
    known = (
        nothing if each.known is None else variances(each.known)
        for each in sources.values()
    )
    relative = np.sqrt(whole[: beta.size, 0]) / prior_std(robot, sets)
    return Budget(
        names,
        names[int(np.argmax(np.nan_to_num(relative)))],
        tuple(sources),
        tuple(each.kind for each in sources.values()),
        parts / whole,
        np.sqrt(whole / np.column_stack([*known])),
    )


@dataclass(frozen=True, repr=False)
class SensitivityTable(JsonPart):
    """Shifts of the base parameters, in their own standard deviations."""

    parameters: tuple[str, ...]
    errors: tuple[str, ...]
    """Such as `joint.elbow.zero`."""
    units: tuple[str, ...]
    """The unit of each error: shifts are for one mrad, mm, % or ms."""
    shifts: Annotated[NullableTable, Field(alias="in_deviations")]
    """A row a parameter, a column an error; NaN for a parameter that is not determined.
    """

    def __post_init__(self) -> None:
        """Refuse a table that lacks a row or a column."""
        rows, columns = len(self.parameters), len(self.errors)
        if self.shifts.shape != (rows, columns) or len(self.units) != columns:
            raise InputError(f"the table is not {rows} by {columns}")

    def __repr__(self) -> str:
        """How large it is, and the largest shift by an instrument."""
        size = f"{len(self.parameters)} parameters, {len(self.errors)} errors"
        if not self.errors:
            return size
        error, unit, parameter, shift = self.worst()
        return (
            f"{size}; 1 {unit} of {error} shifts {parameter} most, by {shift:.3g} of "
            "its deviations"
        )

    def worst(self) -> tuple[str, str, str, float]:
        """The error that shifts most, its unit, what, and by how much."""
        size = np.nan_to_num(np.abs(self.shifts))
        row, column = np.unravel_index(size.argmax(), size.shape)
        where = self.errors[column], self.units[column], self.parameters[row]
        return *where, float(size[row, column])
