"""What residuals say of the sensors: their noise, outliers, whiteness."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.segment import Shown

NORMAL = 1.4826
"""Std over median absolute value, of Gaussian noise."""

HUBER = 4.0
"""Residuals beyond so many deviations count less (Huber, 1964)."""

LEAST = 1e-3
"""Noise is not found to be smaller by more than this at once."""

Residuals = Mapping[str, Float[np.ndarray, "s rows axes"]]


class Whitened(NamedTuple):
    """One sensor's residuals over the noise that was assumed."""

    values: Float[np.ndarray, "samples axes"]
    """Rows without a sample and axes that do not count are left out."""
    unknowns: float
    """How many it took to make them small."""

    @property
    def scale(self) -> float:
        """The noise over what was assumed, outliers left out."""
        size = np.abs(self.values)
        if not size.size:
            return 1.0
        inside = self.values[size <= HUBER * NORMAL * np.median(size)]
        left = max(inside.size - self.unknowns, 1.0)
        return max(float(np.sqrt(np.sum(inside**2) / left)), LEAST)

    @property
    def whiteness(self) -> float:
        """Correlation of neighbours: 0 for white noise."""
        power = np.sum(self.values**2)
        between = np.sum(self.values[:-1] * self.values[1:])
        return float(between / power) if power else 0.0


def whitened(
    shown: Shown, residuals: Residuals, unknowns: Mapping[str, float]
) -> dict[str, Whitened]:
    """By sensor."""
    found = {}
    for name, table in residuals.items():
        seen = shown.weights[name] > 0
        values = table[seen.any(axis=2)][:, seen.any(axis=(0, 1))]
        found[name] = Whitened(values, unknowns[name])
    return found


def rescaled(shown: Shown, scales: Mapping[str, float]) -> Shown:
    """For noise so many times as large."""
    weights = {name: weight / scales[name] for name, weight in shown.weights.items()}
    return Shown(shown.values, weights)


def robust(shown: Shown, residuals: Residuals) -> Shown:
    """With Huber's weights for outliers among the whitened residuals."""
    weights = {
        name: weight * np.sqrt(HUBER / np.maximum(np.abs(residuals[name]), HUBER))
        for name, weight in shown.weights.items()
    }
    return Shown(shown.values, weights)


def reweighted(residuals: Residuals, old: Shown, new: Shown) -> dict[str, np.ndarray]:
    """Residuals whitened by other weights."""
    return {
        name: table * new.weights[name] / np.where(weight > 0, weight, 1.0)
        for (name, table), weight in zip(
            residuals.items(), (old.weights[name] for name in residuals), strict=True
        )
    }


def change(old: Shown, new: Shown) -> float:
    """The largest relative change of a weight."""
    changes = [
        np.abs(new.weights[name] / np.where(weight > 0, weight, 1.0) - 1)[weight > 0]
        for name, weight in old.weights.items()
    ]
    return max((float(part.max(initial=0.0)) for part in changes), default=0.0)
