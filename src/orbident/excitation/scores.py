"""How good a trajectory is, by every criterion, on the motion it really makes."""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.free_floating import FreeFloating
from orbident.errors import InputError
from orbident.excitation.floating import (
    Spacecraft,
    seen_along,
    shown_along,
    spacecraft_of,
)
from orbident.excitation.hats import Basis, W_hat, Y_hat
from orbident.excitation.information import Sensing, information, sensing_of
from orbident.excitation.spectra import Objective, log_eigenvalues, log_objective
from orbident.excitation.start import was_at_rest
from orbident.regressors.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.trajectories.trajectory import Trajectory

# An information matrix whose eigenvalues spread farther does not fix all parameters.
DETERMINED = 1e-13

EVERY = 4
"""So many samples of a motion are one of its score."""


class Deviations(NamedTuple):
    """Standard deviations that the sensors allow (Cramer and Rao)."""

    mass: float
    """kg."""
    pi: Float[np.ndarray, " pi"]
    """kg m^2, automatic basis."""
    phi: Float[np.ndarray, " phi"]
    """m."""


class Scores(NamedTuple):
    """Every criterion; the smaller the better."""

    cond_Y: float
    cond_Y_normalised: float
    cond_W: float
    cond_W_normalised: float
    d: float | None
    """Geometric mean of the standard deviations; None where sensors or motion do not
    determine all parameters."""
    a: float | None
    """Their root mean square."""
    e: float | None
    """The largest."""
    deviations: Deviations | None


def scores_of(
    robot: Robot,
    trajectory: Trajectory,
    motion: FreeFloating,
    basis: Basis | None = None,
) -> Scores:
    """Score a trajectory by every criterion.

    d, a and e are of the free-flying base parameters, in units in which random motion
    shows all alike; so they depend on no choice of basis.

    Args:
        robot: with its nominal inertia.
        trajectory: for this robot, rows in its order.
        motion: along it, at times that are evenly spaced.
        basis: of the condition numbers; the automatic one by default.
    """
    sets = minimal_sets(robot)
    try:
        sensing = sensing_of(robot, sets)
    except InputError:
        sensing = None
    at_rest = was_at_rest(robot, trajectory.initial, trajectory.start)
    craft = spacecraft_of(robot, sets.regressors, trajectory.initial, at_rest)
    Y, W, F = _stacked(
        craft,
        (sets.pi(robot.theta), sets.phi(robot.theta)),
        basis or basis_of(sets),
        sensing,
        jax.tree.map(
            lambda history: history[::EVERY],
            Seen(motion.q, motion.qd, motion.w, motion.attitude, motion.qd_rw),
        ),
        motion.t[EVERY] - motion.t[0],
    )
    F = None if sensing is None or not _determined(F) else np.asarray(F)
    return Scores(
        cond_Y=_condition(Y),
        cond_Y_normalised=_condition(Y / _norms(Y)),
        cond_W=_condition(W),
        cond_W_normalised=_condition(W / _norms(W)),
        d=None if F is None else _value("d", F),
        a=None if F is None else _value("a", F),
        e=None if F is None else _value("e", F),
        deviations=None if F is None or sensing is None else _deviations(sensing, F),
    )


def _condition(rows: Float[AnyArray, "m n"]) -> float:
    # Its triangular factor has the same, and is small.
    if rows.shape[1] == 0:
        return 1.0
    return float(np.linalg.cond(np.linalg.qr(np.asarray(rows), mode="r")))


def _norms(rows: Float[AnyArray, "m n"]) -> Float[np.ndarray, " n"]:
    norms = np.linalg.norm(np.asarray(rows), axis=0)
    return np.where(norms > 0, norms, 1.0)


def _value(objective: Objective, F: Float[AnyArray, "n n"]) -> float:
    return float(np.exp(log_objective(objective, log_eigenvalues(F), 1.0).exact))


def _determined(F: Float[AnyArray, "u u"]) -> bool:
    eigenvalues = np.linalg.eigvalsh(F)
    return bool(eigenvalues[0] > DETERMINED * eigenvalues[-1])


def basis_of(sets: MinimalSets) -> Basis:
    """The automatic parameters themselves."""
    return Basis(np.eye(sets.pi_of_beta.shape[0]), np.eye(sets.base.sigmas))


class Seen(NamedTuple):
    """What of a motion is scored."""

    q: Float[AnyArray, "n joints"]
    qd: Float[AnyArray, "n joints"]
    w: Float[AnyArray, "n 3"]
    x_WB: Float[AnyArray, "n 4"]
    qd_rw: Float[AnyArray, "n wheels"]


@compiled
def _stacked(
    craft: Spacecraft,
    pi_phi: tuple[Float[AnyArray, " pi"], Float[AnyArray, " phi"]],
    basis: Basis,
    sensing: Sensing | None,
    seen: Seen,
    dt: float | Float[AnyArray, ""],
):
    """`Y-hat`, `W-hat` and the information."""
    shown = shown_along(craft.regressors, seen.q, seen.qd)
    w = seen.w[:, craft.regressors.momentum_axes]
    motion = seen_along(craft, shown, pi_phi, w, seen.x_WB, seen.qd_rw)
    F = None if sensing is None else information(sensing, motion, dt, craft.at_rest)
    return (
        Y_hat(motion, basis.pi_of, craft.at_rest),
        W_hat(motion, basis.phi_of),
        F,
    )


def _deviations(sensing: Sensing, F: Float[AnyArray, "u u"]) -> Deviations:
    C = np.linalg.inv(np.asarray(F))
    beta, pi, phi = (
        np.sqrt(np.einsum("ij,jk,ik->i", J, C, J))
        for J in (sensing.beta_of, sensing.pi_of, sensing.phi_of)
    )
    return Deviations(float(beta[0]), pi, phi)
