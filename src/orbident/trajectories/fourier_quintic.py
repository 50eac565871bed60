"""Eq. 41: a finite Fourier series plus the quintic that meets the ends."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

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
        z, powers = self._harmonics(t), _powers(t / self.duration)
        position, rate, acceleration = (
            self._series(order, z) + self._polynomial(order, powers)
            for order in range(3)
        )
        return position, rate, acceleration

    def derivative(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative of any order at the times `t`, s."""
        polynomial = self._polynomial(order, _powers(t / self.duration))
        return self._series(order, self._harmonics(t)) + polynomial

    def bound(self, order: int) -> Float[np.ndarray, " joints"]:
        """A bound of a derivative in which the quintic has no part: sixth or later."""
        return np.hypot(self.a, self.b) @ self._frequencies ** (order - 1)

    def _harmonics(
        self, t: Float[np.ndarray, " n"]
    ) -> Complex[np.ndarray, "n harmonics"]:
        """`exp(i w_f l t)`, each harmonic from the one before."""
        first = np.exp(2j * np.pi / self.duration * t)
        return np.cumprod(np.tile(first[:, None], self.a.shape[1]), axis=1)

    def _series(
        self, order: int, z: Complex[np.ndarray, "n harmonics"]
    ) -> Float[np.ndarray, "n joints"]:
        """`w^(k-1) (a sin(w t + k pi/2) - b cos(w t + k pi/2))`, over harmonics.

        That is the imaginary part of `w^(k-1) i^k (a - i b) exp(i w t)`.
        """
        gain = 1j**order * (self.a - 1j * self.b) * self._frequencies ** (order - 1)
        return (z @ gain.T).imag

    def _polynomial(
        self, order: int, powers: Float[np.ndarray, "n 6"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative of the quintic: `sum_j j!/(j-k)! c_j s^(j-k) / t_f^k`."""
        factors = [math.perm(j, order) for j in range(order, DEGREE + 1)]
        c = np.array(factors, dtype=float)[:, None] * self._quintic[order:]
        return powers[:, : len(c)] @ c / self.duration**order

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


def _powers(s: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 6"]:
    """`s^0` to `s^5`."""
    return np.vander(s, DEGREE + 1, increasing=True)
