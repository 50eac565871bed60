"""How good a trajectory is, by every criterion, on the motion it really makes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.excitation.criterion import (
    Basis,
    Objective,
    W_hat,
    Y_hat,
    basis_of,
    log_criterion,
    spectrum_of,
)
from orbident.excitation.floating import craft_of, was_at_rest
from orbident.excitation.guarantee import floated, smallest_table
from orbident.excitation.information import (
    Information,
    Sensing,
    sensing_of,
    weights_of,
)
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.simulation.free_floating import FreeFloating
from orbident.trajectories.trajectory import Trajectory

DETERMINED = 1e-13
"""Information whose eigenvalues spread farther does not fix all parameters."""

EVERY = 4
"""So many samples of a motion are one of its score."""


class Bounds(NamedTuple):
    """Standard deviations that the sensors allow (Cramer and Rao)."""

    mass: float
    """kg."""
    pi: Float[np.ndarray, " pi"]
    """kg m^2, automatic basis."""
    phi: Float[np.ndarray, " phi"]
    """m."""


class CriterionValues(NamedTuple):
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
    price: float | None
    """Of not knowing what acts from outside: by how much deviations of the base
    parameters grow, as a geometric mean; None where nothing may act."""
    deviations: Bounds | None


def scores_of(
    robot: Robot,
    trajectory: Trajectory,
    motion: FreeFloating,
    basis: Basis | None = None,
) -> CriterionValues:
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
    at_rest = was_at_rest(robot, trajectory.initial, trajectory.start)
    craft = craft_of(robot, sets, trajectory.initial, trajectory.start, at_rest)
    seen = craft.seen(
        motion.q[::EVERY],
        motion.qd[::EVERY],
        motion.w[::EVERY],
        motion.attitude[::EVERY],
        float(motion.t[EVERY] - motion.t[0]),
    )
    regressors, basis = sets.regressors, basis or basis_of(robot, sets)
    Y = Y_hat(seen, basis.pi_of, regressors.momentum_axes, at_rest)
    W = W_hat(seen, basis.phi_of, regressors.velocity_axes)
    sensing = sensing_of(robot, sets) if weights_of(robot.sensors) else None
    F = None if sensing is None else Information(sensing, seen, at_rest).F
    F = None if F is None or not _determined(F) else F
    # What only shows when coupled joints move apart has no deviation.
    whole = sensing is not None and np.ptp(sensing.beta_of.shape) == 0
    price = None
    if F is not None and sensing is not None and whole and sensing.acting:
        alone = Information(replace(sensing, acting=False), seen, at_rest).F
        growth = _std(sensing.beta_of, F) / _std(sensing.beta_of, alone)
        price = float(np.exp(np.log(growth).mean()))
    return CriterionValues(
        cond_Y=_condition(Y),
        cond_Y_normalised=_condition(Y / _norms(Y)),
        cond_W=_condition(W),
        cond_W_normalised=_condition(W / _norms(W)),
        d=None if F is None else _value("d", F),
        a=None if F is None else _value("a", F),
        e=None if F is None else _value("e", F),
        price=price,
        deviations=_deviations(sensing, F)
        if F is not None and sensing is not None and whole
        else None,
    )


def _condition(rows: Float[np.ndarray, "m n"]) -> float:
    # Its triangular factor has the same, and is small.
    if rows.shape[1] == 0:
        return 1.0
    return float(np.linalg.cond(np.linalg.qr(rows, mode="r")))


def _norms(rows: Float[np.ndarray, "m n"]) -> Float[np.ndarray, " n"]:
    norms = np.linalg.norm(rows, axis=0)
    return np.where(norms > 0, norms, 1.0)


def _value(objective: Objective, F: Float[np.ndarray, "n n"]) -> float:
    return float(np.exp(log_criterion(objective, spectrum_of(F).l, 1.0).exact))


def _determined(F: Float[np.ndarray, "u u"]) -> bool:
    eigenvalues = np.linalg.eigvalsh(F)
    return bool(eigenvalues[0] > DETERMINED * eigenvalues[-1])


def _deviations(sensing: Sensing, F: Float[np.ndarray, "u u"]) -> Bounds:
    beta, pi, phi = (
        _std(J, F) for J in (sensing.beta_of, sensing.pi_of, sensing.phi_of)
    )
    return Bounds(float(beta[0]), pi, phi)


def _std(
    J: Float[np.ndarray, "some u"], F: Float[np.ndarray, "u u"]
) -> Float[np.ndarray, " some"]:
    return np.sqrt(np.einsum("ij,jk,ik->i", J, np.linalg.inv(F), J))


class Scorecard(NamedTuple):
    """What each trajectory promises; the smaller, the better."""

    sources: tuple[str, ...]
    scores: tuple[CriterionValues, ...]
    parameters: tuple[str, ...]
    """`M`, `pi_1` .., `phi_1` .., automatic basis."""
    nominal: Float[np.ndarray, " parameters"]
    deviations: Float[np.ndarray, "trajectories parameters"]
    """Predicted standard deviations; NaN where not all is determined."""
    tables: tuple[tuple[float, float] | None, ...]
    """As of `smallest_table`."""


def compare_trajectories(
    robot: Robot, trajectories: Sequence[Trajectory], basis: Basis | None = None
) -> Scorecard:
    """Score each trajectory, with the nominal inertia and the robot file's sensors.

    Args:
        robot: with its nominal inertia.
        trajectories: each with its initial state.
        basis: of the condition numbers; the automatic one by default.

    Raises:
        InputError: a trajectory is not for this robot, or the base turns too fast.
    """
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    names = ["M"]
    names += [f"pi_{i + 1}" for i in range(pi.size)]
    names += [f"phi_{i + 1}" for i in range(phi.size)]
    scores, deviations, tables = [], [], []
    for trajectory in trajectories:
        ordered = trajectory.for_robot(robot)
        motion = floated(robot, ordered)
        score = scores_of(robot, ordered, motion, basis)
        tables.append(smallest_table(robot, ordered, motion))
        scores.append(score)
        std = score.deviations
        deviations.append(
            np.full(len(names), np.nan)
            if std is None
            else np.concatenate([[std.mass], std.pi, std.phi])
        )
    return Scorecard(
        sources=tuple(trajectory.source for trajectory in trajectories),
        scores=tuple(scores),
        parameters=tuple(names),
        nominal=np.concatenate([[robot.mass], pi, phi]),
        deviations=np.array(deviations),
        tables=tuple(tables),
    )
