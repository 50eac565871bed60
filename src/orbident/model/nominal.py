"""What the robot's own inertia (CAD) says of its minimal sets."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS

ROUNDING = 1e-10
"""Over the size of the terms of a sum: a smaller sum is zero. A URDF writes a right
angle as 1.57079632679, which is off by 5e-12."""

MOMENTS = np.array([4, 6, 9])
"""Where `theta_i` holds `Ixx`, `Iyy` and `Izz`."""


class Nominal(NamedTuple):
    """The minimal sets of the nominal inertia; what is rounding of zero is zero."""

    base: Float[np.ndarray, " beta"]
    phi: Float[np.ndarray, " phi"]
    pi: Float[np.ndarray, " pi"]


def nominal_parameters(robot: Robot, sets: MinimalSets) -> Nominal:
    """The minimal sets of a robot's nominal `theta`.

    Args:
        robot: with its nominal inertia.
        sets: its minimal sets.
    """
    theta, size = robot.theta, _size(robot.theta)
    T = np.abs(sets.base.T)
    M, sigma, _ = sets.split(T @ size.ravel())
    a, b = sets.pairs.T
    size_pi = np.abs(sets.pi_of_beta) @ (T @ size.ravel())
    size_pi += abs(sets.pi_of_products) @ (sigma[a] * sigma[b] / M)
    return Nominal(
        base=_rounded(sets.beta(theta), T @ size.ravel()),
        phi=_rounded(sets.phi(theta), sigma / M),
        pi=_rounded(sets.pi(theta), size_pi),
    )


def _size(theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, "bodies 10"]:
    """How large each of a body's parameters could be: `|m c|^2 <= m tr(I) / 2`."""
    m, trace = theta[:, MASS], np.abs(theta[:, MOMENTS]).sum(axis=1)
    size = np.abs(theta)
    size[:, FIRST_MOMENT] += np.sqrt(np.abs(m) * trace)[:, None]
    size[:, INERTIA] += trace[:, None]
    return size


def _rounded(
    values: Float[np.ndarray, " n"], size: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    return np.where(np.abs(values) > ROUNDING * size, values, 0.0)
