"""The overlapping Allan deviation, from its definition (IEEE 952, Annex C.1)."""

from collections.abc import Sequence

import numpy as np


def allan_deviation(rate: np.ndarray, dt: float, means: Sequence[int]) -> np.ndarray:
    """Over means of so many samples, all axes pooled.

    `sigma^2(m dt) = < (mean of m samples - mean of the m before)^2 > / 2`.
    """
    angle = np.concatenate([np.zeros((1, rate.shape[1])), dt * np.cumsum(rate, axis=0)])
    deviations = []
    for m in means:
        change = angle[2 * m :] - 2 * angle[m:-m] + angle[: -2 * m]
        deviations.append(np.sqrt(np.mean(change**2) / 2) / (m * dt))
    return np.array(deviations)
