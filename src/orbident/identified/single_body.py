"""A difference of base parameters, explained by one body that joined another."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.special import chdtrc

from orbident.identified.difference import Difference, determined_combinations
from orbident.robot.description import Robot, Structure
from orbident.robot.parameters import PER_BODY, SYMBOLS


class ChiSquare(NamedTuple):
    """A sum of squares of white noise, if nothing else is in it."""

    value: float
    dof: int

    @property
    def p(self) -> float:
        """The probability that chance alone gives as much."""
        return float(chdtrc(self.dof, self.value)) if self.dof else 1.0

    def to_json(self) -> dict[str, float]:
        """As in the JSON of `compare`."""
        return {"chi2": self.value, "dof": self.dof, "p": self.p}


class Explanation(NamedTuple):
    """The body that joined `body`, by generalised least squares."""

    body: str
    theta: Float[np.ndarray, "10"]
    """About the origin of `body`'s frame, its axes; NaN where not determined."""
    covariance: Float[np.ndarray, "10 10"]
    left: ChiSquare
    """Chi-square of what it leaves unexplained."""
    probability: float
    """That it is this body, if it is one (Akaike's weight)."""


def total(difference: Difference) -> ChiSquare:
    """Chi-square of the difference itself: only noise where nothing changed."""
    return ChiSquare(
        float(np.sum((difference.W @ difference.d) ** 2)), difference.d.size
    )


def explanations(difference: Difference, robot: Robot) -> tuple[Explanation, ...]:
    """Every body in turn, the most probable first; of equals the ends of the arms.

    Args:
        difference: of two results.
        robot: that holds what was captured, with its structure.
    """
    fits = [_fit(difference, robot, i) for i in range(len(robot.bodies))]
    # -2 log likelihood, and 2 for every parameter (Akaike 1974).
    criteria = np.array([fit.left.value - 2.0 * fit.left.dof for fit in fits])
    weights = np.exp(-(criteria - criteria.min()) / 2)
    weights /= weights.sum()
    parents = {joint.parent for joint in robot.joints}
    order = sorted(range(len(fits)), key=lambda i: (criteria[i].round(6), i in parents))
    return tuple(fits[i]._replace(probability=float(weights[i])) for i in order)


def free_columns(robot: Robot, i: int) -> Int[np.ndarray, " free"]:
    """The columns of `theta` that the structure of body `i` leaves free."""
    zero = robot.structure.get(robot.bodies[i], Structure()).zero_parameters()
    return np.array([k for k in range(PER_BODY) if SYMBOLS[k] not in zero])


def _fit(difference: Difference, robot: Robot, i: int) -> Explanation:
    d, T, W, _ = difference
    free = free_columns(robot, i)
    X = T[:, PER_BODY * i + free]
    V, alone = determined_combinations(X)
    # d = X V z + e, of which W e is white; theta_t = V z.
    WX = W @ X @ V
    inverse = np.linalg.pinv(WX)
    G = V @ inverse
    known = np.outer(alone, alone)
    theta, covariance = np.full(PER_BODY, np.nan), np.full((PER_BODY, PER_BODY), np.nan)
    theta[free] = np.where(alone, G @ W @ d, np.nan)
    covariance[np.ix_(free, free)] = np.where(known, G @ G.T, np.nan)
    residual = W @ d - WX @ (inverse @ W @ d)
    return Explanation(
        body=robot.bodies[i],
        theta=theta,
        covariance=covariance,
        left=ChiSquare(float(residual @ residual), d.size - V.shape[1]),
        probability=0.0,
    )
