"""How good a trajectory is, by every criterion, on the motion it really makes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import FREE
from orbident.excitation.conditions import Limits
from orbident.excitation.criterion import (
    Basis,
    Objective,
    W_hat,
    Y_hat,
    basis_of,
    log_criterion,
    spectrum_of,
)
from orbident.excitation.floating import NodalMotion, craft_of, was_at_rest
from orbident.excitation.guarantee import Flown, proven
from orbident.excitation.information import (
    Information,
    Sensing,
    of_parameters,
    sensing_of,
    weights_of,
)
from orbident.excitation.outside_changes import OutsideChanges, anything_may_act
from orbident.excitation.table_points import TableSize
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.simulation.free_floating import FreeFloating
from orbident.trajectories.trajectory import Trajectory

DETERMINED = 1e-13
"""Information whose eigenvalues spread farther does not fix all parameters."""

EVERY = 4
"""So many samples of a motion are one of its score."""


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
    price_of_tolerances: float | None
    """The same of what may be off about instruments; None where all are exact."""
    deviations: Float[np.ndarray, " parameters"] | None
    """Standard deviations that the sensors allow (Cramer and Rao), of `M` (kg), `pi`
    (kg m^2, automatic basis) and `phi` (m)."""
    drift: float | None
    """How far what may act moves a robot on its table in a recording, one standard
    deviation, m; None in space or where nothing may act."""


def scores_of(
    robot: Robot, flown: Sequence[Flown], basis: Basis | None = None
) -> CriterionValues:
    """Score a motion by every criterion, or the motions of several recordings together.

    Parameters and errors of instruments are common to all recordings, and all else is
    each one's own.

    d, a and e are of the free-flying base parameters, in units in which random motion
    shows all alike; so they depend on no choice of basis. Inertia is nominal, and
    motions are at times that are evenly spaced. The basis, of the condition numbers, is
    the automatic one by default.
    """
    sets = minimal_sets(robot)
    seen = [_seen(robot, sets, *each) for each in flown]
    regressors, basis = sets.regressors, basis or basis_of(robot, sets)
    h, v = regressors.momentum_axes, regressors.velocity_axes
    Y = np.concatenate([Y_hat(m, basis.pi_of, h, at_rest) for m, at_rest in seen])
    W = np.concatenate([W_hat(m, basis.phi_of, v) for m, _ in seen])
    sensing = sensing_of(robot, sets) if weights_of(robot.sensors) else None
    F = None if sensing is None else _sum(sensing, seen)
    values: dict[Objective, float | None] = {"d": None, "a": None, "e": None}
    if F is not None:
        eigenvalues = np.linalg.eigvalsh(F)
        F = F if eigenvalues[0] > DETERMINED * eigenvalues[-1] else None
    if F is not None:
        l = spectrum_of(F).l
        values |= {x: float(np.exp(log_criterion(x, l, 1.0).exact)) for x in values}
    # What only shows when coupled joints move apart has no deviation.
    whole = sensing is not None and np.ptp(sensing.beta_of.shape) == 0
    price = of_tolerances = deviations = drift = None
    if anything_may_act(robot) and robot.motion == "planar":
        drift = max(OutsideChanges(motion).drift for motion, _ in seen)
    if F is not None and sensing is not None and whole:
        beta, pi, phi = (
            _std(J, F) for J in (sensing.beta_of, sensing.pi_of, sensing.phi_of)
        )
        deviations = np.concatenate([beta[:1], pi, phi])
        if sensing.acting:
            price = _growth(beta, replace(sensing, acting=False), seen)
        # What is free, as friction beside torques, has no tolerance.
        free = tuple(each for each in sensing.errors if each.std == FREE)
        if free != sensing.errors:
            of_tolerances = _growth(beta, replace(sensing, errors=free), seen)
    return CriterionValues(
        cond_Y=_condition(Y),
        cond_Y_normalised=_condition(Y / _norms(Y)),
        cond_W=_condition(W),
        cond_W_normalised=_condition(W / _norms(W)),
        **values,
        price=price,
        price_of_tolerances=of_tolerances,
        deviations=deviations,
        drift=drift,
    )


def _seen(
    robot: Robot, sets: MinimalSets, trajectory: Trajectory, motion: FreeFloating
) -> tuple[NodalMotion, bool]:
    """The motion at some of its samples, and whether all was at rest before."""
    at_rest = was_at_rest(robot, trajectory.initial, trajectory.start)
    craft = craft_of(robot, sets, trajectory.initial, trajectory.start, at_rest)
    seen = craft.seen(
        motion.q[::EVERY],
        motion.qd[::EVERY],
        motion.w[::EVERY],
        motion.attitude[::EVERY],
        float(motion.t[EVERY] - motion.t[0]),
    )
    return seen, at_rest


def _sum(
    sensing: Sensing, seen: list[tuple[NodalMotion, bool]]
) -> Float[np.ndarray, "u u"]:
    """What recordings tell of the parameters, with errors within their tolerances."""
    F = np.sum([Information(sensing, *each).F for each in seen], axis=0)
    return of_parameters(sensing, F).F


def _growth(
    std: Float[np.ndarray, " beta"],
    without: Sensing,
    seen: list[tuple[NodalMotion, bool]],
) -> float:
    """By how much deviations grow, beside those with less unknown."""
    growth = std / _std(without.beta_of, _sum(without, seen))
    return float(np.exp(np.log(growth).mean()))


def information_of(
    robot: Robot, flown: Sequence[Flown]
) -> Float[np.ndarray, "common common"]:
    """What recordings tell of parameters and errors of instruments.

    They are in the units of `sensing_of` and at their deviations. The motions are as of
    `scores_of`.

    Raises:
        InputError: the robot file has no sensor of the base's motion.
    """
    sets = minimal_sets(robot)
    sensing = sensing_of(robot, sets)
    seen = (_seen(robot, sets, *each) for each in flown)
    return np.sum([Information(sensing, *each).F for each in seen], axis=0)


def _condition(rows: Float[np.ndarray, "m n"]) -> float:
    # Its triangular factor has the same, and is small.
    if rows.shape[1] == 0:
        return 1.0
    return float(np.linalg.cond(np.linalg.qr(rows, mode="r")))


def _norms(rows: Float[np.ndarray, "m n"]) -> Float[np.ndarray, " n"]:
    norms = np.linalg.norm(rows, axis=0)
    return np.where(norms > 0, norms, 1.0)


def _std(
    J: Float[np.ndarray, "some u"], F: Float[np.ndarray, "u u"]
) -> Float[np.ndarray, " some"]:
    return np.sqrt(np.einsum("ij,jk,ik->i", J, np.linalg.inv(F), J))


class Scorecard(NamedTuple):
    """What each trajectory promises, or several together; smaller is better."""

    sources: tuple[str, ...]
    scores: tuple[CriterionValues, ...]
    parameters: tuple[str, ...]
    """`M`, `pi_1` .., `phi_1` .., automatic basis."""
    nominal: Float[np.ndarray, " parameters"]
    deviations: Float[np.ndarray, "trajectories parameters"]
    """Predicted standard deviations; NaN where not all is determined."""
    tables: tuple[TableSize | None, ...]
    """The smallest that holds each one's motions; None in space, and infinite where
    nothing can be proven."""
    exceeded: tuple[tuple[str, ...], ...]
    """Which of each one's motions do not keep to a limit, in words."""


def compare_trajectories(
    robot: Robot,
    experiments: Sequence[Sequence[Trajectory]],
    basis: Basis | None = None,
    limits: Limits | None = None,
) -> Scorecard:
    """Score experiments, with the nominal inertia and the robot file's sensors.

    Each experiment is the trajectories of its recordings. The basis, of the condition
    numbers, is the automatic one by default.

    Raises:
        InputError: a trajectory is not for this robot, the base turns too fast, or a
            joint is passive.
    """
    inspected = "'orbident inspect ROBOT --trajectory TRAJ' tells what one promises"
    require_measured(robot, "a comparison of motions", inspected)
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    names = ["M"]
    names += [f"pi_{i + 1}" for i in range(pi.size)]
    names += [f"phi_{i + 1}" for i in range(phi.size)]
    scores, deviations, tables, exceeded = [], [], [], []
    for trajectories in experiments:
        found = [proven(robot, each.for_robot(robot)) for each in trajectories]
        score = scores_of(robot, [(x.trajectory, x.motion) for x in found], basis)
        sides = np.array([each.base.table for each in found if each.base.table])
        tables.append(TableSize(*sides.max(axis=0).tolist()) if sides.size else None)
        broken = [(each, each.broken(limits)) for each in found] if limits else []
        exceeded.append(
            tuple(
                f"{each.trajectory.source}: {words}" for each, words in broken if words
            )
        )
        scores.append(score)
        unknown = np.full(len(names), np.nan)
        deviations.append(unknown if score.deviations is None else score.deviations)
    ends = [(*each[:1], *each[1:][-1:]) for each in experiments]
    return Scorecard(
        sources=tuple(" to ".join(motion.source for motion in each) for each in ends),
        scores=tuple(scores),
        parameters=tuple(names),
        nominal=np.concatenate([[robot.mass], pi, phi]),
        deviations=np.array(deviations),
        tables=tuple(tables),
        exceeded=tuple(exceeded),
    )
