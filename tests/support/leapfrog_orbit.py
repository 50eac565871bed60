"""An orbit about an oblate Earth that is not ours: a symplectic integrator, and a force
that is the gradient of the potential by complex steps."""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicHermiteSpline

MU, J2, R_E = 3.986004418e14, 1.08262668e-3, 6378137.0
EARTH_RATE = np.array([0.0, 0.0, 7.2921159e-5])

W_1 = 1 / (2 - 2 ** (1 / 3))
"""Yoshida's weight of fourth order."""

Place = Callable[[float | np.ndarray], np.ndarray]


def pull(r: np.ndarray) -> np.ndarray:
    """The gradient of `mu / R (1 - J2 (R_E / R)^2 P_2(z / R))`, m/s^2."""
    steps = r + 1e-20j * R_E * np.eye(3)
    R = np.sqrt(np.sum(steps**2, axis=1))
    oblate = J2 * (R_E / R) ** 2 * (3 * (steps[:, 2] / R) ** 2 - 1) / 2
    return np.imag(MU / R * (1 - oblate)) / (1e-20 * R_E)


def leapfrog(x: np.ndarray, end: float, steps: int) -> np.ndarray:
    """States from 0 to `end` after each step."""
    states = [x]
    for _ in range(steps):
        r, v = states[-1][:3], states[-1][3:]
        for w in (W_1, 1 - 2 * W_1, W_1):
            h = w * end / steps
            r = r + h / 2 * v
            v = v + h * pull(r)
            r = r + h / 2 * v
        states.append(np.concatenate([r, v]))
    return np.array(states)


def from_perigee_at_the_node(a: float, e: float, inclination: float) -> np.ndarray:
    """The state there, above inertial x."""
    speed = np.sqrt(MU / a * (1 + e) / (1 - e))
    c, s = np.cos(inclination), np.sin(inclination)
    return np.array([a * (1 - e), 0.0, 0.0, 0.0, speed * c, speed * s])


def flown_orbit(x: np.ndarray, end: float) -> CubicHermiteSpline:
    """The place over time, m, by steps of some five seconds."""
    steps = int(end / 5) + 1
    states = leapfrog(x, end, steps)
    t = np.linspace(0.0, end, steps + 1)
    return CubicHermiteSpline(t, states[:, :3], states[:, 3:])
