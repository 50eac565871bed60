"""A slow, obvious smoothing spline: regression with a dense covariance matrix."""

from math import factorial

import numpy as np

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def covariance(a, s, b, t):
    """Covariance of derivatives a and b of white snap integrated four times from zero.

    int_0^min(s, t) (s - u)^(3 - a) / (3 - a)! (t - u)^(3 - b) / (3 - b)! du, of which
    four Gauss nodes make no error: its degree is 6 at most.
    """
    s, t = s[:, None, None], t[None, :, None]
    half = np.minimum(s, t) / 2
    u = half * (1 + NODES)
    left = (s - u) ** (3 - a) / factorial(3 - a)
    right = (t - u) ** (3 - b) / factorial(3 - b)
    return (half * WEIGHTS * left * right).sum(axis=2)


def cubics(a, t):
    """Derivative a of 1, t, t^2 and t^3: nothing is known of their factors."""
    powers = np.polynomial.polynomial.Polynomial
    return np.stack(
        [powers(row).deriv(a)(t) if a else powers(row)(t) for row in np.eye(4)], 1
    )


class DenseSpline:
    """Times from zero on; `q` the density of the snap, `std` of the samples."""

    def __init__(self, t, y, q, std):
        self.t, self.q = t, q
        V, H = q * covariance(0, t, 0, t) + std**2 * np.eye(t.size), cubics(0, t)
        self.system = np.block([[V, H], [H.T, np.zeros((4, 4))]])
        self.weights = np.linalg.solve(self.system, np.append(y, np.zeros(4)))
        W = np.linalg.inv(V)
        information = H.T @ W @ H
        residual = W @ y - W @ H @ np.linalg.solve(information, H.T @ W @ y)
        self.cost = (
            np.linalg.slogdet(V)[1] + np.linalg.slogdet(information)[1] + y @ residual
        )
        """-2 log likelihood of the samples, the cubic integrated out."""

    def _cross(self, a, at):
        return np.hstack([self.q * covariance(a, at, 0, self.t), cubics(a, at)])

    def mean(self, a, at):
        """Mean of derivative a at these times."""
        return self._cross(a, at) @ self.weights

    def std(self, a, at):
        """Standard deviations of derivative a at these times.

        What samples explain is nearly all that there is: one step of refinement in
        longer numbers gives the digits that the difference of the two needs.
        """
        cross = self._cross(a, at).astype(np.longdouble)
        solution = np.linalg.solve(self.system, cross.T.astype(float))
        left = cross.T - self.system.astype(np.longdouble) @ solution
        solution = solution + np.linalg.solve(self.system, left.astype(float))
        explained = np.sum(cross * solution.T, axis=1)
        return np.sqrt(np.diag(self.q * covariance(a, at, a, at)) - explained)
