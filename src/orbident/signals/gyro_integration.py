"""The attitude by integrating a gyro from a known start."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.compilation import compiled
from orbident.dynamics.batches import BATCH
from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import quaternion_rate

_GAUSS = np.sqrt(3) / 6


@in_float64
def integrate_gyro(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    x_start: Float[np.ndarray, "4"],
) -> Float[np.ndarray, "n 4"]:
    """The attitude whose rate is the cubic spline through the gyro's samples.

    By the fourth-order Magnus expansion (Iserles et al. 2000), from one row to the
    next, with `w_1`, `w_2` at the two Gauss points of the step `h`:

        x(t + h) = x(t) (x) exp(h/4 (w_1 + w_2) + sqrt(3)/24 h^2 w_1 x w_2)

    Args:
        t: times, s.
        w: angular rate of the base, base axes, rad/s; NaN where there is no sample.
        x_start: attitude at the gyro's first sample, unit quaternion, scalar last.

    Returns:
        Unit quaternions; NaN before the first and after the last sample.

    Raises:
        InputError: the gyro has fewer than four samples.
    """
    measured = np.isfinite(w).all(axis=1)
    if measured.sum() < 4:
        raise InputError(f"gyro has {measured.sum()} samples; give at least 4")
    rate = CubicSpline(t[measured], w[measured])
    first, last = np.flatnonzero(measured)[[0, -1]]
    inside = t[first : last + 1]
    x = np.full((t.size, 4), np.nan)
    x[first] = x_start
    for start in range(0, inside.size - 1, BATCH):
        h = np.diff(inside[start : start + BATCH + 1])
        middle = inside[start : start + h.size] + h / 2
        w_1, w_2 = rate(middle - _GAUSS * h), rate(middle + _GAUSS * h)
        pad = ((0, BATCH - h.size), (0, 0))
        steps = np.pad(_rotation_vectors(h[:, None], w_1, w_2), pad)
        rows = np.asarray(_turn(x[first + start], steps))[: h.size]
        x[first + start + 1 : first + start + 1 + h.size] = rows
    return x


def _rotation_vectors(h: np.ndarray, w_1: np.ndarray, w_2: np.ndarray) -> np.ndarray:
    return h / 2 * (w_1 + w_2) + np.sqrt(3) / 12 * h**2 * np.cross(w_1, w_2)


@compiled
def _turn(
    x: Float[AnyArray, "4"], steps: Float[AnyArray, "m 3"]
) -> Float[AnyArray, "m 4"]:
    """The attitude after each of these rotations, in the turning axes."""

    def turn(x, step):
        half = jnp.linalg.norm(step) / 2
        # x (x) (v, cos) with v = sin(half) step/|step|; quaternion_rate(x, 2 v) is
        # the product of x and (v, 0).
        v = jnp.sinc(half / jnp.pi) * step / 2
        x = jnp.cos(half) * x + quaternion_rate(x, 2 * v)
        x = x / jnp.linalg.norm(x)
        return x, x

    return jax.lax.scan(turn, x, steps)[1]
