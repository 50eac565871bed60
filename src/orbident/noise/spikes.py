"""Noise at rest without its spikes: samples that no noise explains."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.noise.noise_model import NoiseModel, best_model

OUTLYING = 6.0
"""Deviations: noise is beyond them once in half a thousand million samples."""

ROUNDING = 1e-14

ROUNDS = 4
"""Rounds that leave out outlying samples: after a jump there is always another."""


class CleanModel(NamedTuple):
    """The noise of samples, those that are outliers apart."""

    model: NoiseModel
    kept: Bool[np.ndarray, " n"]
    settled: bool
    """Whether no further sample is an outlier."""


def clean_model(
    t: Float[np.ndarray, " n"],
    y: Float[np.ndarray, " n"],
    parts: Sequence[tuple[str, ...]],
) -> CleanModel:
    """As `best_model`, without the samples that it does not explain."""
    kept = np.ones(t.size, dtype=bool)
    model = best_model(t, y, parts)
    for _ in range(ROUNDS):
        outlying = np.abs(model.innovations) > OUTLYING
        if not outlying.any():
            return CleanModel(model, kept, True)
        kept[np.flatnonzero(kept)[outlying]] = False
        if not varies(y[kept]):
            break
        model = best_model(t[kept], y[kept], parts)
    return CleanModel(model, kept, False)


def varies(x: Float[np.ndarray, " n"]) -> bool:
    """Whether samples differ by more than rounding, of rotations too."""
    return bool(np.ptp(x) > ROUNDING * max(1.0, float(np.abs(x).max())))
