"""Momentum that walks at random, where a planar robot's pose alone shows it.

A white torque or force of the density `p`, over inertia or mass, makes a rate walk, and
the pose with it. To the samples that is noise which lasts (`whitening.hpp`); it has as
many unknowns as samples, so its waves would be too many. Its density is what makes the
innovations of the pose most likely, beside the level of their white noise.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from orbident import _core
from orbident.environment.agents import WALKS
from orbident.environment.motion import by_step, integral
from orbident.estimation.output_error.looseness import TURN_AND_BIASES
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.sensors import (
    RATE_WALK,
    TRACKERS,
    parts_of_boundaries,
)
from orbident.estimation.solution import Solution, Unknowns
from orbident.model.core_robot import wheels_of

RANGE = 1e6
"""How far a density may be from the last guess, as a factor."""

LEAST = 0.01
"""Deviations of the pose, as all samples tell it, by which a walk moves it over all of
the recording at least: where none is seen, any smaller one is as likely."""

STEP = 0.05
"""Step of a density's logarithm for second differences: it is known to some tenths."""

LOOK = 0.5
"""How far from the guesses of density and level the search looks first, as logarithms:
by half as much again."""

SETTLED = 0.1
"""Change of a density's logarithm that changes no deviation by more than a tenth."""


class Density(NamedTuple):
    """How strong a walk most likely is: N m/sqrt(Hz), or N/sqrt(Hz).

    That of a rate is over inertia or mass.
    """

    value: float
    std: float


def near(one: Density, other: Density) -> bool:
    """Whether two densities differ by so little that no deviation changes."""
    return bool(abs(np.log(one.value / other.value)) < SETTLED)


def densities_of_rates(
    problem: Problem, solution: Solution, first: Problem
) -> dict[str, Density]:
    """The most likely density of every rate that walks, by its group.

    Args:
        problem: a recording's equations.
        solution: of these.
        first: with the first guess, which would have moved the robot without thrust: no
            walk is stronger.
    """
    most = {x: first.lasting[WALKS.index(x), :, RATE_WALK].max() for x in WALKS}
    return {x: _most_likely(problem, solution, x, most[x]) for x in problem.walking}


def walking_so(problem: Problem, found: Mapping[str, Density]) -> Problem:
    """The equations with rates that walk with these densities."""
    lasting = problem.lasting.copy()
    for group, each in found.items():
        own = lasting[WALKS.index(group), :, RATE_WALK]
        own[own > 0] = each.value
    return problem._replace(lasting=lasting)


def _most_likely(
    problem: Problem, solution: Solution, group: str, most: float
) -> Density:
    k = WALKS.index(group)
    name, parts = TRACKERS[k], problem.lasting[k]
    axes = np.flatnonzero(parts[:, RATE_WALK])
    weights = solution.weights[name]
    left = solution.linear.residuals[name] / np.where(weights > 0, weights, 1.0)
    if name == "attitude":
        left = free_running(problem, solution.state, left)
    seen = (weights[:, axes] > 0).all(axis=1)
    errors = np.ascontiguousarray(left[np.ix_(seen, axes)])
    # Alike on all axes; outliers say less.
    variance = weights[seen, axes[0]] ** -2.0
    t = np.ascontiguousarray(problem.t[seen])

    def misfit(logs: Float[np.ndarray, "2"]) -> float:
        rate, level = np.exp(logs)
        coloured = np.append(parts[axes[0], :RATE_WALK] * [level, 1, level], rate)
        v, S = _core.innovations(t, errors, level**2 * variance, coloured)
        return float(axes.size * np.sum(np.log(S)) + np.sum(np.sum(v**2, axis=1) / S))

    # Its integral has the deviation p sqrt(T^3 / 3).
    least = LEAST * np.sqrt(3 / (t[-1] - t[0]) ** 3 / np.sum(1 / variance))
    start = np.log([max(parts[axes[0], RATE_WALK], least), 1.0])
    around = start - LOOK * np.array([[0, 0], [1, 0], [0, -1]])
    limits = [(each - np.log(RANGE), each + np.log(RANGE)) for each in start]
    limits[0] = np.log(least), limits[0][1]
    options = {"initial_simplex": around}
    # A bound that is met would flatten the simplex.
    found = minimize(
        misfit, start, method="Nelder-Mead", bounds=limits, options=options
    )
    logs = np.array([min(found.x[0], np.log(most)), found.x[1]])
    step = np.array([STEP, 0.0])
    bend = misfit(logs + step) - 2 * misfit(logs) + misfit(logs - step)
    value = float(np.exp(logs[0]))
    # Where nothing walks, the likelihood is flat: any smaller density is as likely.
    return Density(value, value * STEP * float(np.sqrt(2 / max(bend, STEP**2))))


def free_running(
    problem: Problem, state: Unknowns, left: Float[np.ndarray, "rows 3"]
) -> Float[np.ndarray, "rows 3"]:
    """What is left of an attitude whose rate walks, from one start on, rad.

    Where intervals begin, they take the walk over; here it goes on from the first row.

    Args:
        problem: of a planar robot.
        state: where it was solved.
        left: what each interval leaves; that of the first row stays.
    """
    shown = problem.samples["attitude"]
    seen = np.flatnonzero(np.isfinite(shown).all(axis=1))
    turned = 2 * np.unwrap(np.arctan2(shown[seen, 2], shown[seen, 3]), period=np.pi)
    predicted = np.interp(problem.t[seen], problem.t, _turned(problem, state))
    off = (turned - turned[0]) - (predicted - predicted[0])
    out = left.copy()
    out[seen, 2] = left[seen[0], 2] + off
    return out


def walked(problem: Problem, start: Unknowns) -> Unknowns:
    """The start with a momentum that has walked to where the base's rate says.

    So what intervals leave is small, whatever thrust was guessed.

    Args:
        problem: a recording's equations.
        start: where a search is to start.
    """
    if not problem.lasting[0, :, RATE_WALK].any():
        return start
    place = TURN_AND_BIASES + parts_of_boundaries(problem.lasting)[0].sum() - 1
    rate, D = _alone(problem, start)
    motion = problem.acting.followed.motion
    off = D * (motion.w[:, 2] - rate)
    local = start.local.copy()
    local[:, place] = np.interp(problem.boundaries, motion.t, off)
    return start._replace(local=local)


def _turned(problem: Problem, state: Unknowns) -> Float[np.ndarray, " rows"]:
    """How far a planar base turns by its momentum alone, at the rows, rad."""
    rate = np.pad(_alone(problem, state)[0][:, None], ((0, 0), (0, 2)))
    return integral(problem.acting.followed.motion.t, by_step(rate))[::2, 0]


def _alone(
    problem: Problem, state: Unknowns
) -> tuple[Float[np.ndarray, " nodes"], Float[np.ndarray, " nodes"]]:
    """The rate of a planar base by its momentum alone, rad/s, and `D`, kg m^2."""
    followed, acting = problem.acting.followed, problem.acting
    motion, sets, history = followed.motion, followed.sets, followed.intervals.history
    pi, w = sets.pi(sets.theta(state.beta)), np.zeros_like(motion.w)
    h = np.full(motion.t.size, state.common[2])
    table = acting.table(state.beta, state.calibration, state.selected)
    h += table[:, 2, 0] if table.size else 0.0
    speeds = history.at(history.qd_rw, history.qdd_rw, motion.t)
    h -= speeds @ wheels_of(motion.robot).A_rw[2]
    moved, turning = (
        (sets.regressors(motion.q, motion.qd, w + rate)[0] @ pi)[:, 0]
        for rate in (np.zeros(3), np.eye(3)[2])
    )
    return (h - moved) / (turning - moved), turning - moved
