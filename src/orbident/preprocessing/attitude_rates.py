"""The rate of the base from its attitude alone."""

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.settings import Settings
from orbident.preprocessing.smoothing import fits_of, smooth_rates


def attitude_rates(
    t: Float[np.ndarray, " n"],
    fixes: Float[np.ndarray, "n 4"],
    name: str = "attitude",
    settings: Settings | None = None,
) -> tuple[Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"]]:
    """Attitude and rate, each component of the quaternion smoothed for itself.

    `w = 2 vec(conj(x) (x) dx/dt)`, the inverse of `dx/dt = 1/2 x (x) (w, 0)`.

    Args:
        t: times, s.
        fixes: unit quaternions of either sign, scalar last; NaN where there is none.
        name: what this is, for messages.
        settings: of the whole recording, where these are a stretch of it.

    Returns:
        The smoothed attitude, and the rate in base axes, rad/s; NaN on rows without a
        fix.

    Raises:
        InputError: there are fewer than four fixes.
    """
    label, signed = f"{name}: attitude", same_sign(fixes)
    settings = settings or Settings()
    fits = settings.smoothers("attitude", lambda: fits_of(t, signed, name=label))
    smoothed = smooth_rates(t, signed, t, label, fits)
    size = np.linalg.norm(smoothed.x, axis=1, keepdims=True)
    # Of the unit quaternion x / |x|; what changes |x| drops out of the vector part.
    x, x_dot = smoothed.x / size, smoothed.rate / size
    v, s, v_dot, s_dot = x[:, :3], x[:, 3:], x_dot[:, :3], x_dot[:, 3:]
    w = 2 * (s * v_dot - s_dot * v - np.cross(v, v_dot))
    missing = np.isnan(fixes).any(axis=1)
    x[missing], w[missing] = np.nan, np.nan
    return x, w


def same_sign(x: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
    """The same attitudes, each on the side of the one before: `x` and `-x` are equal.

    Args:
        x: unit quaternions; NaN where there is none.
    """
    valid = ~np.isnan(x).any(axis=1)
    product = np.sum(x[valid][1:] * x[valid][:-1], axis=1)
    signs = np.cumprod(np.concatenate([[1.0], np.where(product < 0, -1.0, 1.0)]))
    turned = x.copy()
    turned[valid] *= signs[: valid.sum(), None]
    return turned
