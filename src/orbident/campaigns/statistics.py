"""What the runs of a campaign say of a method: errors, intervals, dependences."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from jaxtyping import Float
from scipy import stats

from orbident.campaigns.folder import column
from orbident.gaussian import NINETY_FIVE

DRAW = "draw."


class Parameter(NamedTuple):
    """One base parameter by one method, over all results that were not refused."""

    name: str
    error: Float[np.ndarray, " results"]
    """Estimate less truth, SI."""
    z: Float[np.ndarray, " results"]
    """Errors over the deviations that the results state."""

    @property
    def bias(self) -> tuple[float, float]:
        """The mean error, and its own standard deviation."""
        return float(self.error.mean()), float(stats.sem(self.error))

    @property
    def rms(self) -> float:
        """The root mean square of the errors."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def covered(self) -> int:
        """How many 95 % intervals hold the truth."""
        return int(np.count_nonzero(np.abs(self.z) <= NINETY_FIVE))

    def coverage(self, confidence: float = 0.95) -> tuple[float, float]:
        """The interval of the share that holds the truth (Clopper and Pearson 1934)."""
        found = stats.binomtest(self.covered, self.z.size)
        return tuple(found.proportion_ci(confidence, "exact"))


class MethodStatistics:
    """The results of one robot by one method."""

    def __init__(self, robot: str, method: str, rows: pa.Table) -> None:
        """Take the rows of this robot and method."""
        self.robot, self.method, self.rows = robot, method, rows
        self.accepted = rows.filter(pc.field("level") != "do not trust")

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those that the results determine."""
        found = []
        ends = (n for n in self.rows.schema.names if n.endswith(".value"))
        for name in (end.removesuffix(".value") for end in ends):
            error, std = self._errors(name)
            known = np.isfinite(error) & (std > 0)
            # A deviation of errors needs two of them.
            if np.count_nonzero(known) > 1:
                found.append(Parameter(name, error[known], error[known] / std[known]))
        return tuple(found)

    def _errors(self, name: str) -> "tuple[np.ndarray, np.ndarray]":
        """The errors of a parameter, and the deviations that the results state."""
        value, std, true = (
            column(self.accepted, f"{name}.{what}") for what in ("value", "std", "true")
        )
        return value - true, std

    @cached_property
    def _z(self) -> Float[np.ndarray, "results parameters"]:
        """NaN where a result does not determine one."""
        errors = (self._errors(each.name) for each in self.parameters)
        return np.column_stack([error / std for error, std in errors])

    def worst(self, count: int) -> list[tuple[int, str, float]]:
        """Run, parameter and error over deviation of the results farthest off."""
        if not self.parameters:
            return []
        z = np.nan_to_num(self._z)
        run = column(self.accepted, "run").astype(int)
        most = np.abs(z).argmax(axis=1)
        far = z[np.arange(len(z)), most]
        order = np.argsort(-np.abs(far), kind="stable")[:count]
        return [
            (int(run[i]), self.parameters[most[i]].name, float(far[i])) for i in order
        ]

    def dependences(self, count: int) -> "list[Dependence]":
        """The strongest rank correlations of errors, and of their sizes, with draws."""
        names = [
            name
            for name in self.accepted.schema.names
            if name.startswith(DRAW) and self.accepted[name].null_count == 0
        ]
        if not names or not self.parameters:
            return []
        whole = np.flatnonzero(np.isfinite(self._z).all(axis=1))
        n = whole.size
        if n < FEWEST:
            return []
        x = np.column_stack([column(self.accepted, name) for name in names])[whole]
        z = self._z[whole]
        both = np.hstack([z, np.abs(z)])
        rho = _rank_correlation(x, both)
        found = []
        for at in np.argsort(-np.abs(rho), axis=None)[:count]:
            i, j = np.unravel_index(at, rho.shape)
            k, sized = int(j) % z.shape[1], int(j) >= z.shape[1]
            found.append(
                Dependence(
                    names[i].removeprefix(DRAW),
                    self.parameters[k].name,
                    sized,
                    float(rho[i, j]),
                    _chance(float(rho[i, j]), n, rho.size),
                    x[:, i],
                    both[:, j],
                )
            )
        return found


FEWEST = 10
"""Results from which a correlation says anything."""


class Dependence(NamedTuple):
    """How an error goes with a quantity that was drawn."""

    draw: str
    parameter: str
    of_size: bool
    """Whether the size of the error does, not the error."""
    rho: float
    """Spearman's rank correlation."""
    chance: float
    """Probability that any of all pairs is so strongly correlated by chance."""
    x: Float[np.ndarray, " results"]
    y: Float[np.ndarray, " results"]
    """The error over its deviation, or its size."""


def method_statistics(rows: pa.Table) -> Sequence[MethodStatistics]:
    """The results of each robot by each method."""
    keys = zip(*(rows[name].to_pylist() for name in ("robot", "method")), strict=True)
    return [
        MethodStatistics(
            robot,
            method,
            rows.filter((pc.field("robot") == robot) & (pc.field("method") == method)),
        )
        for robot, method in dict.fromkeys(keys)
    ]


def _rank_correlation(
    x: Float[np.ndarray, "n a"], y: Float[np.ndarray, "n b"]
) -> Float[np.ndarray, "a b"]:
    """Spearman's; zero for what does not vary."""
    ranks = stats.rankdata(np.hstack([x, y]), axis=0)
    with np.errstate(invalid="ignore"):
        rho = np.nan_to_num(np.corrcoef(ranks, rowvar=False))
    return rho[: x.shape[1], x.shape[1] :]


def _chance(rho: float, n: int, pairs: int) -> float:
    """The chance of a rank correlation by Student's t, times the pairs (Bonferroni)."""
    t = abs(rho) * np.sqrt((n - 2) / max(1 - rho**2, 1e-300))
    return float(min(1.0, pairs * 2 * stats.t.sf(t, n - 2)))
