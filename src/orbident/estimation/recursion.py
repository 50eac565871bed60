"""How a recursive estimate came about and what changed meanwhile, as data."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float


class Change(NamedTuple):
    """A change that was found."""

    t: float
    """When it was found, s."""
    onset: float
    """The first sample that shows it, most likely, s."""
    statistic: float
    """`g`, over its threshold."""
    confidence: float
    """One less the probability that a run without any change shows this much."""


class History(NamedTuple):
    """One row a sample that counted."""

    t: Float[np.ndarray, " n"]
    beta: Float[np.ndarray, "n beta"]
    std: Float[np.ndarray, "n beta"]
    pi: Float[np.ndarray, "n pi"]
    phi: Float[np.ndarray, "n phi"]
    M: Float[np.ndarray, " n"]
    nis: Float[np.ndarray, " n"]
    """Normalised innovation squared: chi-square with `dof` degrees of freedom."""
    dof: Float[np.ndarray, " n"]
    statistic: Float[np.ndarray, " n"]
    """The detector's statistic over its threshold."""
    changes: tuple[Change, ...]
    covariance: Float[np.ndarray, "beta beta"]
    """The covariance of the last `beta`."""
    determined: Bool[np.ndarray, " beta"]
    """Whether the samples, and not the prior, tell the last `beta`: without a wheel
    nothing tells the scale."""
    scale: bool
    """Whether the wheels' momentum told the scale of `pi`. Where it did not, `beta`,
    `pi` and `M` are NaN, and no change can be told."""
    declared: bool
    """Whether the noise of all sensors is, that the innovations are whitened with."""
    biases: dict[str, dict[str, float]]
    """Biases of the sensors at the end: `value` and `std`."""
