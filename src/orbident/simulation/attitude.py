"""The one differential equation of free floating: the attitude of the base.

Momentum conservation makes the base rate an algebraic function of time and attitude,

    w = E(t) R_0^T h_cm - b(t).

`E` and `b` do not depend on the attitude, so they are known for all times at once;
only the quaternion is integrated.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix, rotate, rotate_back
from orbident.threads import processors

MOST_SUBSTEPS = 256


class RateLaw(NamedTuple):
    """`w = E R_0^T h_cm - b` at some times; base axes."""

    E: Float[np.ndarray, "*n 3 3"]
    b: Float[np.ndarray, "*n 3"]

    def rate(
        self, x_WB: Float[np.ndarray, "*n 4"], h_cm: Float[np.ndarray, "*#n 3"]
    ) -> Float[np.ndarray, "*n 3"]:
        """The base rate, rad/s, base axes."""
        h_B = rotate_back(quaternion_matrix(x_WB), h_cm)
        return rotate(self.E, h_B) - self.b

    def every(self, stride: int) -> "RateLaw":
        """The law at every so many of its times."""
        return RateLaw(self.E[::stride], self.b[::stride])


def rate_law(
    D: Float[np.ndarray, "n 3 3"], h_moving: Float[np.ndarray, "n 3"], planar: bool
) -> RateLaw:
    """The law from `D w + h_moving = R_0^T h_cm`; in the plane of its z row alone."""
    return RateLaw(*_core.rate_laws(D, h_moving, planar, processors()))


def step_nodes(t: Float[np.ndarray, " n"], substeps: int) -> Float[np.ndarray, " m"]:
    """The ends and middles of `substeps` equal steps from each sample to the next."""
    parts = np.arange(2 * substeps) / (2 * substeps)
    inner = t[:-1, None] + np.diff(t)[:, None] * parts
    return np.append(inner.ravel(), t[-1])


def integrate_attitude(
    law: RateLaw,
    h_cm: Float[np.ndarray, "nodes 3"],
    x_WB: Float[np.ndarray, "4"],
    t: Float[np.ndarray, " n"],
    substeps: int,
) -> tuple[Float[np.ndarray, "n 4"], float]:
    """The base's quaternion at the samples, and the estimate of its largest error, rad.

    Args:
        law: at the `step_nodes`.
        h_cm: angular momentum about the system CM at the same nodes, inertial axes.
        x_WB: attitude at the first sample.
        t: sample times, s.
        substeps: RK4 steps from one sample to the next, an even number.
    """
    x, apart = _core.attitudes(law.E, law.b, h_cm, x_WB, t, substeps)
    # Richardson: halving the step of RK4 divides its error by 16.
    return x, apart / 15


class AttitudeHistory(NamedTuple):
    """The attitude at the samples, and how good it is."""

    x_WB: Float[np.ndarray, "n 4"]
    law: RateLaw
    """The law of the base rate at the samples."""
    error: float
    """Estimate of the largest error, rad."""
    substeps: int
    """RK4 steps from one sample to the next."""


def float_attitude(
    law_at: Callable[[Float[np.ndarray, " nodes"]], RateLaw],
    t: Float[np.ndarray, " n"],
    h_cm: Float[np.ndarray, "3"],
    x_WB: Float[np.ndarray, "4"],
    tolerance: float,
) -> AttitudeHistory:
    """Integrate with steps that are halved until the error is below `tolerance`.

    Args:
        law_at: the rate law at any times.
        t: sample times, s.
        h_cm: angular momentum about the system CM, inertial axes, N m s.
        x_WB: attitude at the first sample.
        tolerance: of the attitude, rad.

    Raises:
        InputError: the base turns too fast for these sample times.
    """
    substeps = 2
    while True:
        nodes = step_nodes(t, substeps)
        law, momentum = law_at(nodes), np.tile(h_cm, (nodes.size, 1))
        x, error = integrate_attitude(law, momentum, x_WB, t, substeps)
        if error <= tolerance:
            return AttitudeHistory(x, law.every(2 * substeps), error, substeps)
        if substeps == MOST_SUBSTEPS:
            raise InputError(
                f"the base turns too fast for samples up to {np.diff(t).max():g} s "
                f"apart: attitude error {error:.2g} rad with {substeps} steps a "
                f"sample, more than {tolerance:g}; sample faster or start with less "
                "momentum"
            )
        substeps *= 2
