"""Deviations that are widened by how far an estimate is from what the sensors show."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.optimize import root_scalar
from scipy.special import ndtr

from orbident.estimation.base_parameters import EstimatedParameters, Known
from orbident.estimation.estimate import Estimate
from orbident.estimation.quantities import Quantity
from orbident.gaussian import NINETY_FIVE

WITHIN = 0.95
"""So often an interval of 95 % holds what is true."""


def difference(one: Known, other: Known) -> float:
    """The largest one, in deviations of the first."""
    off, std = _off(one, other), np.sqrt(np.maximum(np.diag(one.covariance), 0.0))
    sure = std > 0
    return float(np.max(np.abs(off[sure]) / std[sure], initial=0.0))


def widened(estimate: Estimate, shown: Estimate, whole: bool) -> Estimate:
    """Widen deviations by how far an estimate is from what the sensors show.

    Maximum likelihood has the least variance, so that a difference from it has no part
    in common with its error (Hausman 1978): the mean square error of another estimate
    is that variance and the square of the difference. Intervals by that variance would
    hold more than they say, because the difference is known: a part of its square is
    enough, by which those of the base parameters hold 95 % in the mean.

    Args:
        estimate: by any method.
        shown: by output error.
        whole: whether of the same samples; where of a part of them, the method's own
            variance and the whole square count.
    """
    mine, theirs = estimate.parameters, shown.parameters
    both = np.concatenate([_off(mine.pi, theirs.pi), _off(mine.phi, theirs.phi)])
    least = shown if whole else estimate
    part = 1.0
    if whole:
        part = _part(_off(mine.base, theirs.base), theirs.base.covariance)

    def known(one: Known, other: Known, variance: Known) -> Known:
        off = _off(one, other)
        return Known(
            one.values,
            variance.covariance + part * np.outer(off, off),
            one.determined & other.determined,
        )

    M = estimate.mass.value
    std = float(np.hypot(least.mass.std, np.sqrt(part) * (M - shown.mass.value)))
    mass, routes = Quantity(M, std), list(estimate.masses)
    return replace(
        estimate,
        parameters=EstimatedParameters(
            known(mine.pi, theirs.pi, least.parameters.pi),
            known(mine.phi, theirs.phi, least.parameters.phi),
            known(mine.base, theirs.base, least.parameters.base),
            least.parameters.covariance + part * np.outer(both, both),
        ),
        mass=mass,
        masses={**estimate.masses, routes[-1]: mass},
        sensitivity=shown.sensitivity,
        sources=shown.sources,
        disturbances=shown.disturbances,
        drives=shown.drives,
        allowed=shown.allowed,
        widened_by=shown.widened_by,
        unexpected=shown.unexpected,
    )


def _off(one: Known, other: Known) -> np.ndarray:
    return np.where(one.determined & other.determined, one.values - other.values, 0.0)


def _part(off: Float[np.ndarray, " n"], C: Float[np.ndarray, "n n"]) -> float:
    """The part of squared differences by which intervals hold 95 % in the mean.

    Errors are normal about `off`, with the covariance `C`; an interval of

        1.96 sqrt(1 + part r^2)   deviations,   r = off / deviation,

    holds too much with all of the square, and a quarter is enough where `r` is large.
    """
    std = np.sqrt(np.diag(C))
    r = off[std > 0] / std[std > 0]

    def more(part: float) -> float:
        half = NINETY_FIVE * np.sqrt(1 + part * r**2)
        return float(np.mean(ndtr(half - r) - ndtr(-half - r)) - WITHIN)

    # Differences of rounding size change no interval.
    if more(0.0) >= 0 or more(1.0) <= 0:
        return 1.0
    return float(root_scalar(more, bracket=(0.0, 1.0)).root)
