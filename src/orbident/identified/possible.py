"""Whether a body can have an inertia, within what is known of it."""

import numpy as np
from jaxtyping import Float

from orbident.robot.parameters import INERTIA, INERTIA_ENTRIES, SYMBOLS

CERTAIN = 3.0
"""Standard deviations below zero that are no chance."""


def impossible(
    I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]
) -> str | None:
    """Why no body can have this inertia about its CM; None where one can.

    Second moments are not negative in any direction `v`: `tr I / 2 - v^T I v >= 0`,
    which is least along the axis of the largest moment. Where not all of `I` is
    determined, what is determined of its diagonal must not be negative.

    Args:
        I_com: kg m^2; NaN where not determined.
        C: its covariance.
    """
    if np.isfinite(I_com).all():
        return _flat(I_com, C)
    for k, (a, b) in enumerate(INERTIA_ENTRIES):
        if a == b and I_com[k] < -CERTAIN * np.sqrt(C[k, k]):
            symbol = SYMBOLS[INERTIA][k]
            return f"{symbol} about its CM, {I_com[k]:.4g} kg m^2, is negative"
    return None


def _flat(I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]) -> str | None:
    I = np.zeros((3, 3))
    for value, (a, b) in zip(I_com, INERTIA_ENTRIES, strict=True):
        I[a, b] = I[b, a] = value
    moments, axes = np.linalg.eigh(I)
    v = axes[:, -1]
    g = np.array(
        [0.5 - v[a] ** 2 if a == b else -2 * v[a] * v[b] for a, b in INERTIA_ENTRIES]
    )
    if g @ I_com >= -CERTAIN * np.sqrt(g @ C @ g):
        return None
    x, y, z = (f"{moment:.4g}" for moment in moments)
    return (
        f"its principal moments {x}, {y}, {z} kg m^2 violate the triangle inequality "
        "by more than chance"
    )
