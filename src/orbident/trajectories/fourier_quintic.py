"""Eq. 41: a finite Fourier series plus the quintic that meets the ends."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.threads import processors

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
        q, qd, qdd = self._sums(range(3), t)
        return q, qd, qdd

    def derivative(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative of any order at the times `t`, s."""
        return self._sums([order], t)[0]

    def bound(self, order: int) -> Float[np.ndarray, " joints"]:
        """A bound of a derivative in which the quintic has no part: sixth or later."""
        return np.hypot(self.a, self.b) @ self._frequencies ** (order - 1)

    def _sums(
        self, orders: Iterable[int], t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "orders n joints"]:
        coefficients = np.stack([self._coefficients(order) for order in orders])
        return _core.fourier_quintic(coefficients, t / self.duration, processors())

    def _coefficients(self, order: int) -> Float[np.ndarray, "joints m"]:
        """Over the cosines and sines of the harmonics and the powers of `s = t / t_f`.

        The series' is `w^(k-1) (a sin(w t + k pi/2) - b cos(w t + k pi/2))`, the
        imaginary part of `w^(k-1) i^k (a - i b) exp(i w t)`; the quintic's is
        `sum_j j!/(j-k)! c_j s^(j-k) / t_f^k`.
        """
        gain = 1j**order * (self.a - 1j * self.b) * self._frequencies ** (order - 1)
        quintic = np.zeros_like(self._quintic)
        for j in range(order, DEGREE + 1):
            quintic[j - order] = math.perm(j, order) * self._quintic[j]
        quintic /= self.duration**order
        return np.concatenate([gain.imag, gain.real, quintic.T], axis=1)

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
