"""Bodies that can exist and together have the identified parameters.

A body exists where its pseudo-inertia `P = [[E, s], [s^T, m]]` is positive definite,
with `E` its second moments, `I = tr(E) 1 - E` (Wensing, Kim and Slotine 2018). Among
those with the identified `beta` the nearest to the nominal bodies is taken, by the
divergence of their log-determinants, `tr(P0^-1 P) - log det(P0^-1 P)` (Lee, Wensing and
Park 2020): convex, and the same in all frames and units. So where only combinations of
bodies show, mass is shared between them as in the nominal ones.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import chdtri

from orbident.estimation.result import Result
from orbident.identified.semidefinite import nearest_to_one, nearest_within
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import check_known, root_of
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    inertia_matrix,
)

CONFIDENCE = 0.95
LIGHTEST = 1e-6
"""A nominal body counts as no less than this part of the robot's mass."""
THINNEST = 1e-4
"""A nominal body is no thinner than this part of the robot, in second moments."""


class PhysicalBodies(NamedTuple):
    """A `theta` of bodies that can exist."""

    theta: Float[np.ndarray, "bodies 10"]
    deviation: float
    """Mahalanobis distance of their `beta` from the identified one, in sigmas."""


def physical_bodies(
    result: Result, rotors: Float[np.ndarray, "bodies 10"]
) -> PhysicalBodies | None:
    """The bodies nearest to the nominal ones that have the identified parameters.

    Args:
        result: complete and not rejected.
        rotors: the part of each body that is known and stays as it is; the rest is to
            exist without it.

    Returns:
        The bodies, rotors included; None where there are none within the 95 % region
        of the identified `beta`.

    Raises:
        InputError: the result is rejected or not complete, or cvxpy is not installed.
    """
    result.check_accepted()
    robot, beta = result.robot, result.base.values
    check_known(robot, beta)
    met = _equations(robot, beta, rotors)
    found = _exactly(met) or _within_covariance(result, met)
    if found is None or np.linalg.eigvalsh(found[0]).min() <= 0:
        return None
    X, deviation = found
    theta = (met.theta_of_X @ X.ravel()).reshape(-1, PER_BODY) + rotors
    known = np.delete(np.arange(theta.size), robot.free_parameters)
    theta.ravel()[known] = 0.0
    return PhysicalBodies(theta, deviation)


class _Equations(NamedTuple):
    """`A vec(X) = b`: what the bodies `P_i = L X_i L^T` have to meet."""

    A: Float[np.ndarray, "equations entries"]
    b: Float[np.ndarray, " equations"]
    scale: Float[np.ndarray, " equations"]
    """What the rows were divided by; first those of `beta`."""
    theta_of_X: Float[np.ndarray, "theta entries"]


def _equations(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    rotors: Float[np.ndarray, "bodies 10"],
) -> _Equations:
    """`T theta = beta`, and zeros where `structure` has them."""
    zero = np.delete(np.eye(robot.theta.size), robot.free_parameters, axis=0)
    C = np.vstack([minimal_sets(robot).base.T, zero])
    theta_of_X = _theta_of_X(_nominal(robot, robot.theta - rotors))
    A = C @ theta_of_X
    b = np.concatenate([beta, np.zeros(len(zero))]) - C @ rotors.ravel()
    scale = np.linalg.norm(A, axis=1)
    return _Equations(A / scale[:, None], b / scale, scale, theta_of_X)


def _exactly(met: _Equations) -> tuple[Float[np.ndarray, "bodies 4 4"], float] | None:
    X = nearest_to_one(met.A, met.b)
    if X is None:
        return None
    # What the solver left over, by the least change of any body.
    off = met.b - met.A @ X.ravel()
    return X + np.linalg.lstsq(met.A, off)[0].reshape(X.shape), 0.0


def _within_covariance(
    result: Result, met: _Equations
) -> tuple[Float[np.ndarray, "bodies 4 4"], float] | None:
    size = result.base.values.size
    root = np.zeros((met.b.size, size))
    root[:size] = root_of(result.base_covariance) / met.scale[:size, None]
    if not np.isfinite(root).all():
        return None
    most = float(np.sqrt(chdtri(size, 1 - CONFIDENCE)))
    return nearest_within(met.A, met.b, root, most)


def _nominal(
    robot: Robot, theta: Float[np.ndarray, "bodies 10"]
) -> Float[np.ndarray, "bodies 4 4"]:
    """Pseudo-inertias of the nominal bodies, or of what is just not impossible."""
    total = sum(_second_moments(theta_i).trace() for theta_i in robot.theta)
    size2 = total / robot.mass
    return np.array([_possible(theta_i, robot.mass, size2) for theta_i in theta])


def _possible(
    theta_i: Float[np.ndarray, "10"], total: float, size2: float
) -> Float[np.ndarray, "4 4"]:
    m = max(theta_i[MASS], LIGHTEST * total)
    s = theta_i[FIRST_MOMENT] if theta_i[MASS] >= m else np.zeros(3)
    about_com = _second_moments(theta_i) - np.outer(s, s) / m
    values, vectors = np.linalg.eigh(about_com)
    values = np.maximum(values, THINNEST * m * size2)
    E = vectors * values @ vectors.T + np.outer(s, s) / m
    return np.block([[E, s[:, None]], [s[None], np.array([[m]])]])


def _second_moments(theta_i: Float[np.ndarray, "10"]) -> Float[np.ndarray, "3 3"]:
    I = inertia_matrix(theta_i)
    return np.trace(I) / 2 * np.eye(3) - I


def _theta_of_X(P0: Float[np.ndarray, "bodies 4 4"]) -> Float[np.ndarray, "theta X"]:
    """`theta` of the bodies with `P_i = L X_i L^T`, where `P0_i = L L^T`."""
    bodies = len(P0)
    theta_of_X = np.zeros((bodies, PER_BODY, bodies, 16))
    for i, L in enumerate(np.linalg.cholesky(P0)):
        theta_of_X[i, :, i] = _THETA_OF_P @ np.kron(L, L)
    return theta_of_X.reshape(bodies * PER_BODY, bodies * 16)


def _theta_of_P() -> Float[np.ndarray, "10 16"]:
    theta = np.zeros((PER_BODY, 4, 4))
    theta[MASS, 3, 3] = 1.0
    theta[FIRST_MOMENT, :3, 3] = theta[FIRST_MOMENT, 3, :3] = np.eye(3) / 2
    for k, (a, b) in enumerate(INERTIA_ENTRIES):
        # I = tr(E) 1 - E
        theta[4 + k, :3, :3] = np.eye(3) * (a == b)
        theta[4 + k, a, b] -= 0.5
        theta[4 + k, b, a] -= 0.5
    return theta.reshape(PER_BODY, 16)


_THETA_OF_P = _theta_of_P()
