"""Eq. 41: a finite Fourier series plus the quintic that meets the ends."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

DEGREE = 5


@dataclass(frozen=True, eq=False)
class FourierQuintic:
    r"""Joint motions whose boundary values hold whatever `a` and `b` are.

    q_i(t) = sum_l a_il/(w_f l) sin(w_f l t) - b_il/(w_f l) cos(w_f l t)
             + sum_{j=0..5} c_ij t^j,      w_f = 2 pi / t_f      (Eq. 41)
    """

    a: Float[np.ndarray, "joints harmonics"]
    """Cosine amplitudes of the rate, rad/s or m/s."""
    b: Float[np.ndarray, "joints harmonics"]
    """Sine amplitudes of the rate, rad/s or m/s."""
    start: Float[np.ndarray, "joints 3"]
    """Position, velocity and acceleration at t = 0."""
    end: Float[np.ndarray, "joints 3"]
    """The same at t = t_f."""
    duration: float
    """t_f, s."""

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
    ]:
        """Positions, rates and accelerations at the times `t`, s."""
        return self.derivative(0, t), self.derivative(1, t), self.derivative(2, t)

    def derivative(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative of any order at the times `t`, s."""
        T = self.duration
        return self._series(order, t) + _powers(order, t / T) @ self._quintic / T**order

    def bound(self, order: int) -> Float[np.ndarray, " joints"]:
        """A bound of a derivative in which the quintic has no part: sixth or later."""
        return np.hypot(self.a, self.b) @ self._frequencies ** (order - 1)

    def _series(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """`w^(k-1) (a sin(w t + k pi/2) - b cos(w t + k pi/2))`, over harmonics."""
        w = self._frequencies
        sin, cos = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        for _ in range(order % 4):
            sin, cos = cos, -sin
        gain = w ** (order - 1)
        return (sin * gain) @ self.a.T - (cos * gain) @ self.b.T

    @property
    def _frequencies(self) -> Float[np.ndarray, " harmonics"]:
        """`w_f l`, rad/s."""
        return 2 * np.pi * np.arange(1, self.a.shape[1] + 1) / self.duration

    @cached_property
    def _quintic(self) -> Float[np.ndarray, "6 joints"]:
        """Coefficients over powers of t / t_f: what the ends need beyond the series."""
        w = self._frequencies
        # The series has the same values at both ends.
        series = np.stack(
            [-(self.b / w).sum(axis=1), self.a.sum(axis=1), self.b @ w], axis=1
        )
        rates = self.duration ** np.arange(3)
        p0, v0, a0 = ((self.start - series) * rates).T
        p1, v1, a1 = ((self.end - series) * rates).T
        p, v, a = p1 - p0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
        return np.stack(
            [
                p0,
                v0,
                a0 / 2,
                10 * p - 4 * v + a / 2,
                -15 * p + 7 * v - a,
                6 * p - 3 * v + a / 2,
            ]
        )


def _powers(order: int, s: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 6"]:
    """A derivative of `s^0` to `s^5`."""
    columns = [math.perm(j, order) * s ** max(j - order, 0) for j in range(DEGREE + 1)]
    return np.stack(columns, axis=1)
