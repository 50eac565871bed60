"""Bodies that can exist and together have the identified parameters.

A body exists where its pseudo-inertia `P = [[E, s], [s^T, m]]` is positive definite,
with `E` its second moments, `I = tr(E) 1 - E` (Wensing, Kim and Slotine 2018). Among
those with the identified `beta` the nearest to the nominal bodies is taken, by the
divergence of their log-determinants, `tr(P0^-1 P) - log det(P0^-1 P)` (Lee, Wensing and
Park 2020): convex, and the same in all frames and units. So where only combinations of
bodies show, mass is shared between them as in the nominal ones.
"""

import warnings
from dataclasses import replace
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import chdtri

from orbident.estimation.result import Result
from orbident.extras import extra
from orbident.model.core_robot import spinning_parts, theta_with_rotors
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics, check_known, reconstructed, root_of
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    Structure,
    inertia_matrix,
)

SMALLEST = 1e-3
"""The least eigenvalue of a matrix that could not stay near 1."""
ROOM = 1.05
"""So much further from the equations than need be may the nearest matrices lie."""
TOLERANCE = 1e-10
"""Of the solver: feasibility, and the gap to the least cost."""


def _sought(
    cp: ModuleType, A: Float[np.ndarray, "equations entries"]
) -> tuple[list[Any], Any, Any]:
    """The matrices `X`, `A vec(X)`, and how far they are from one."""
    X = [cp.Variable((4, 4), symmetric=True) for _ in range(A.shape[1] // 16)]
    sides = A @ cp.hstack([cp.vec(each, order="C") for each in X])
    return X, sides, cp.sum([cp.trace(each) - cp.log_det(each) for each in X])


def _solved(
    cp: ModuleType, X: list[Any], cost: Any, constraints: list[Any]
) -> Float[np.ndarray, "n 4 4"] | None:
    problem = cp.Problem(cp.Minimize(cost), constraints)
    tolerances = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), TOLERANCE)
    with warnings.catch_warnings():
        # Of a solution that is a little less accurate; the caller checks it.
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver=cp.CLARABEL, **tolerances)
        except cp.SolverError:
            return None
    if problem.status not in {cp.OPTIMAL, cp.OPTIMAL_INACCURATE}:
        return None
    return np.array([each.value for each in X])


def _cvxpy() -> ModuleType:
    # Late: the import takes more than a second.
    with extra("export", "the search for physically possible bodies"):
        import cvxpy

    return cvxpy


CONFIDENCE = 0.95
"""Of the ellipsoid about the identified parameters where bodies are sought."""
LIGHTEST = 1e-6
"""A nominal body counts as no less than this part of the robot's mass."""
ROUNDING = 1e-9
"""Coefficients of standard parameters that are nothing: others are lengths, products of
these, or one."""
THINNEST = 1e-4
"""A nominal body is no thinner than this part of the robot, in second moments."""


class PhysicalBodies(NamedTuple):
    """A `theta` of possible bodies, with declared rotors as momentum sees them."""

    theta: Float[np.ndarray, "bodies 10"]
    deviation: float
    """Mahalanobis distance of their `beta` from the identified one, in sigmas."""


def physical_bodies(
    result: Result,
    apart: Float[np.ndarray, "bodies 10"],
    covariance: Float[np.ndarray, "beta beta"],
) -> PhysicalBodies | None:
    """The bodies nearest to the nominal ones that have the identified parameters.

    The part of each body that is `apart`, wheels and the like, is known and stays as it
    is; the rest is to exist without it. The covariance is of the base parameters and of
    what is known. The bodies are given with what is apart; None where there are none
    within the 95 % region of the identified `beta`.

    Raises:
        InputError: the result is rejected or not complete, or cvxpy is not installed.
    """
    result.check_model()
    robot, beta = result.robot, result.base.values
    check_known(robot, beta)
    by_beta = (minimal_sets(robot).base.theta_of @ beta).reshape(apart.shape)
    apart = apart + spinning_parts(robot, by_beta - apart)
    met = _equations(robot, beta, apart)
    found = _exactly(met) or _within_covariance(covariance, met)
    if found is None or np.linalg.eigvalsh(found[0]).min() <= 0:
        return None
    X, deviation = found
    theta = (met.theta_of_X @ X.ravel()).reshape(-1, PER_BODY) + apart
    known = np.delete(np.arange(theta.size), robot.free_parameters)
    theta.ravel()[known] = 0.0
    return PhysicalBodies(theta, deviation)


def nearest_dynamics(result: Result) -> Dynamics | None:
    """`H+` of the nearest bodies that can exist; None where `physical_bodies` is.

    Raises:
        InputError: the result is rejected or not complete, or cvxpy is not installed.
    """
    robot, C = result.robot, result.base_covariance
    bodies = physical_bodies(result, np.zeros_like(robot.theta), C)
    if bodies is None:
        return None
    beta = minimal_sets(robot).base.T @ bodies.theta.ravel()
    return replace(reconstructed(robot, beta, C), moved=bodies.deviation)


class _Equations(NamedTuple):
    """`A vec(X) = b`: what the bodies `P_i = L X_i L^T` have to meet.

    It is over all entries of all matrices, row after row.
    """

    A: Float[np.ndarray, "equations entries"]
    b: Float[np.ndarray, " equations"]
    scale: Float[np.ndarray, " equations"]
    """What the rows were divided by; first those of `beta`."""
    known: Bool[np.ndarray, " beta"]
    """Those of `beta` that bodies have."""
    theta_of_X: Float[np.ndarray, "theta entries"]


def _equations(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    apart: Float[np.ndarray, "bodies 10"],
) -> _Equations:
    """`T theta = beta`, and zeros where `structure` has them.

    Bodies that are known to be massless are none.
    """
    known = (robot.structure.get(body, Structure()) for body in robot.bodies)
    exist = np.array([each.has_mass for each in known])
    size2 = sum(_second_moments(each).trace() for each in robot.theta) / robot.mass
    bodies = theta_with_rotors(robot) - apart
    nominal = np.array([_possible(each, robot.mass, size2) for each in bodies])
    theta_of_X = _theta_of_X(nominal)[:, np.repeat(exist, 16)]
    zero = np.delete(np.eye(robot.theta.size), robot.free_parameters, axis=0)
    zero = zero[zero @ np.repeat(exist, PER_BODY) > 0]
    C = np.vstack([minimal_sets(robot).base.T, zero])
    b = np.concatenate([beta, np.zeros(len(zero))]) - C @ apart.ravel()
    # What rotors alone have, no body has.
    shown = np.abs(C * np.repeat(exist, PER_BODY)).max(axis=1) > ROUNDING
    A, b = C[shown] @ theta_of_X, b[shown]
    scale = np.linalg.norm(A, axis=1)
    known = shown[: beta.size]
    return _Equations(A / scale[:, None], b / scale, scale, known, theta_of_X)


def _exactly(met: _Equations) -> tuple[Float[np.ndarray, "bodies 4 4"], float] | None:
    """Symmetric `X_i > 0` with `A vec(X) = b`, least `sum tr X_i - log det X_i`."""
    cp = _cvxpy()
    X, sides, divergence = _sought(cp, met.A)
    found = _solved(cp, X, divergence, [sides == met.b])
    if found is None:
        return None
    # What the solver left over, by the least change of any body.
    off = met.b - met.A @ found.ravel()
    return found + np.linalg.lstsq(met.A, off)[0].reshape(found.shape), 0.0


def _within_covariance(
    covariance: Float[np.ndarray, "beta beta"], met: _Equations
) -> tuple[Float[np.ndarray, "bodies 4 4"], float] | None:
    """Symmetric `X_i > 0` with `A vec(X) = b + root z`, with nearly the shortest `z`.

    The covariance of `b` is `root root^T`. With the matrices comes `|z|`, in standard
    deviations; None where it would leave the ellipsoid of `CONFIDENCE`.
    """
    size = len(covariance)
    root = np.zeros((met.b.size, size))
    rows = root_of(covariance)[met.known]
    root[: len(rows)] = rows / met.scale[: len(rows), None]
    if not np.isfinite(root).all():
        return None
    cp = _cvxpy()
    (X, sides, divergence), z = _sought(cp, met.A), cp.Variable(size)
    off, most = cp.norm(z), float(np.sqrt(chdtri(size, 1 - CONFIDENCE)))
    equations = [sides == met.b + root @ z]
    bounded = [*equations, *(each >> SMALLEST * np.eye(4) for each in X)]
    if _solved(cp, X, off, bounded) is None or off.value > most:
        return None
    within = [*equations, off <= ROOM * float(off.value)]
    found = _solved(cp, X, divergence, within)
    return None if found is None else (found, float(off.value))


def _possible(
    theta_i: Float[np.ndarray, "10"], total: float, size2: float
) -> Float[np.ndarray, "4 4"]:
    """The pseudo-inertia of a nominal body, or of what is just not impossible."""
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
