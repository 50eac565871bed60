"""Gyros at the end of their range, where they show one rate however fast it is."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import binary_closing

FEWEST = 5
"""Samples: two or three that are equal a coarse gyro has by chance."""

OFTENER = 4.0
"""Times any other value: the highest count of a coarse gyro is 2.4 times as frequent as
the next at the crest of a sine."""

BETWEEN = np.ones(5, dtype=bool)
"""Samples between two at the end of the range: noise lets them drop below it."""


def saturated(
    w: Float[np.ndarray, " n"], moving: Bool[np.ndarray, " n"]
) -> dict[str, Bool[np.ndarray, " n"]]:
    """Which samples of one axis of a gyro are at the end of its range, by reason.

    Args:
        w: rad/s; NaN where there is no sample.
        moving: whether the robot moves: at rest it may show one rate for long.
    """
    shown, counts = np.unique(w[moving & ~np.isnan(w)], return_counts=True)
    if shown.size < FEWEST:
        return {}
    ends = [
        k for k in (0, -1) if counts[k] >= max(FEWEST, OFTENER * counts[1:-1].max())
    ]
    levels = [float(shown[k]) for k in ends if shown[k]]
    if not levels:
        return {}
    sign = "+-" if len(levels) > 1 else ""
    at_end = np.isin(w, levels) & moving
    beyond = np.logical_or(binary_closing(at_end, BETWEEN), at_end)
    reason = f"sample saturated at {sign}{levels[-1]:.4g} rad/s"
    return {reason: beyond & ~np.isnan(w)}
