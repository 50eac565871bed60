"""What is believed of the parameters before any sample."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.errors import InputError
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotor_momentum import rotor_deviations
from orbident.robot.description import Robot
from orbident.robot.parameters import INERTIA, MASS, PER_BODY

UNCERTAINTY = 0.3
"""The relative uncertainty of CAD values."""


class GaussianPrior(NamedTuple):
    """Gaussian; `root^T root` is the inverse of the covariance."""

    beta: Float[np.ndarray, " beta"]
    root: Float[np.ndarray, "beta beta"]
    """Upper triangular."""


def prior_from(
    beta: Float[np.ndarray, " beta"], covariance: Float[np.ndarray, "beta beta"]
) -> GaussianPrior:
    """The prior with this mean and covariance.

    Raises:
        InputError: the covariance is not positive definite.
    """
    L = factor_of(covariance)
    inverse = solve_triangular(L, np.eye(len(L)), lower=True)
    root = np.linalg.qr(inverse, mode="r")
    return GaussianPrior(beta, np.ascontiguousarray(root))


def factor_of(
    covariance: Float[np.ndarray, "beta beta"],
) -> Float[np.ndarray, "beta beta"]:
    """Lower triangular `L` of `L L^T`.

    Raises:
        InputError: the covariance is not positive definite.
    """
    std = np.sqrt(np.diag(covariance))
    try:
        # With unit variances: kg and kg m^2 differ by orders of magnitude.
        L = np.linalg.cholesky(covariance / np.outer(std, std))
    except np.linalg.LinAlgError:
        raise InputError(
            "the covariance of beta is not positive definite; give that of an "
            "estimate that determines every parameter"
        ) from None
    return np.ascontiguousarray(std[:, None] * L)


def cad_prior(robot: Robot, uncertainty: float = UNCERTAINTY) -> GaussianPrior:
    """The nominal values, wrong by so much.

    Of a body of mass `m` and size `l` the standard deviations are `uncertainty` times
    `m`, `m l` (first moments) and `m l^2` (inertias), each parameter for itself.

    Args:
        robot: with its nominal inertia.
        uncertainty: relative.
    """
    covariance = cad_covariance(robot, uncertainty)
    return prior_from(minimal_sets(robot).beta(robot.theta), covariance)


def cad_covariance(robot: Robot, uncertainty: float) -> Float[np.ndarray, "beta beta"]:
    """The covariance of `beta`, as `cad_prior` has it."""
    m = robot.theta[:, MASS]
    trace = robot.theta[:, INERTIA][:, [0, 2, 5]].sum(axis=1)
    # A body's trace is twice its second moment, m l^2.
    size = np.sqrt(trace / 2 / np.where(m > 0, m, 1.0))[:, None]
    powers = np.array([0] + [1] * 3 + [2] * (PER_BODY - 4))
    T = minimal_sets(robot).base.T
    of_bodies = T * (uncertainty * m[:, None] * size**powers).ravel()
    of_rotors = T @ rotor_deviations(robot)
    return of_bodies @ of_bodies.T + of_rotors @ of_rotors.T
