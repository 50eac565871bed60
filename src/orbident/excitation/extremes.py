"""How far a trajectory of Eq. 41 goes, between samples too.

Between two nodes a function exceeds them by at most `h^2/8 max|f''|`. The second
derivative is bounded in the same way by the fourth, and that by the coefficients, so
what is given here holds for all times (rounding apart).
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.trajectories.trajectory import Trajectory

NODES = 4001
DEGREE = 5


class Extremes(NamedTuple):
    """Bounds for all times, never too small."""

    position: Float[np.ndarray, "joints 2"]
    """Lowest and highest, rad or m."""
    velocity: Float[np.ndarray, " joints"]
    """Largest magnitude."""
    acceleration: Float[np.ndarray, " joints"]


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Any derivative of a trajectory, without compiling anything."""

    trajectory: Trajectory

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
    ]:
        """Positions, rates and accelerations."""
        return self.of_order(0, t), self.of_order(1, t), self.of_order(2, t)

    def of_order(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative at these times."""
        T = self.trajectory.duration
        powers = _powers(order, t / T) / T**order
        return self._series(order, t) + powers @ self._quintic.T

    def bound(self, order: int) -> Float[np.ndarray, " joints"]:
        """Of a derivative that the quintic has no part in: the sixth and later."""
        gain = self._frequencies ** (order - 1)
        return np.hypot(self.trajectory.a, self.trajectory.b) @ gain

    def _series(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """`w^(k-1) (a sin(w t + k pi/2) - b cos(w t + k pi/2))`, over harmonics."""
        w = self._frequencies
        phase = np.outer(t, w) + order * np.pi / 2
        sin, cos = np.sin(phase) * w ** (order - 1), np.cos(phase) * w ** (order - 1)
        return sin @ self.trajectory.a.T - cos @ self.trajectory.b.T

    @property
    def _frequencies(self) -> Float[np.ndarray, " harmonics"]:
        harmonics = np.arange(1, self.trajectory.a.shape[1] + 1)
        return 2 * np.pi * harmonics / self.trajectory.duration

    @cached_property
    def _quintic(self) -> Float[np.ndarray, "joints 6"]:
        """Coefficients over powers of t / t_f: what the ends need beyond the series."""
        T = self.trajectory.duration
        ends = np.array([0.0, T])
        rows, values = [], []
        for order in range(3):
            series = self._series(order, ends)
            rows += list(_powers(order, ends / T))
            for k, state in enumerate((self.trajectory.start, self.trajectory.end)):
                values.append((state[:, order] - series[k]) * T**order)
        return np.linalg.solve(np.array(rows), np.array(values)).T


def extremes_of(trajectory: Trajectory) -> Extremes:
    """The extremes of every joint over the whole duration."""
    t = np.linspace(0.0, trajectory.duration, NODES)
    derivatives = Derivatives(trajectory)
    beyond = t[1] ** 2 / 8
    most = [derivatives.bound(order) for order in range(8)]
    for order in (5, 4, 3, 2, 1):
        sampled = np.abs(derivatives.of_order(order, t)).max(axis=0)
        most[order] = sampled + beyond * most[order + 2]
    q = derivatives.of_order(0, t)
    over = beyond * most[2]
    position = np.stack([q.min(axis=0) - over, q.max(axis=0) + over], axis=1)
    return Extremes(position, most[1], most[2])


def _powers(order: int, s: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 6"]:
    """A derivative of `s^0` to `s^5`."""
    columns = [math.perm(j, order) * s ** max(j - order, 0) for j in range(DEGREE + 1)]
    return np.stack(columns, axis=1)
