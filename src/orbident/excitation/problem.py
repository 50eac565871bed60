"""What a search minimises: a criterion, over all plausible robots, within limits."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.excitation.floating import (
    Floating,
    Spacecraft,
    float_along,
    shown_along,
)
from orbident.excitation.hats import Basis, Y_hat
from orbident.excitation.information import Sensing, information
from orbident.excitation.spectra import (
    Objective,
    log_eigenvalues,
    log_objective,
    log_squared_singular_values,
)
from orbident.spatial.arrays import AnyArray

SMALL = 64
"""Parameters up to which compiling costs more than running."""


class BaseLimits(NamedTuple):
    """Limits of what the joints do to the base; infinite where there is none."""

    rate: float
    """rad/s."""
    half_turn: float
    """Cosine of half the greatest excursion; -1 where there is none."""
    wheel_speed: float
    """rad/s."""


class Robots(NamedTuple):
    """Every plausible robot; the first is the nominal one."""

    pi: Float[AnyArray, "robots pi"]
    phi: Float[AnyArray, "robots phi"]


class Problem(eqx.Module):
    """All that stays the same while trajectories are tried."""

    craft: Spacecraft
    robots: Robots
    basis: Basis
    sensing: Sensing | None
    """None for the objective cond."""
    offset: tuple[Float[AnyArray, "n joints"], Float[AnyArray, "n joints"]]
    """Joint positions and rates where `y = 0`."""
    per_y: tuple[Float[AnyArray, "n m"], Float[AnyArray, "n m"]]
    scale: Float[AnyArray, " joints"]
    dt: float
    """s."""
    limits: BaseLimits
    objective: Objective = eqx.field(static=True)


class Tried(NamedTuple):
    """What a search is told of one trajectory; logarithms of the worst robot's."""

    smooth: Float[AnyArray, ""]
    """The smoothed criterion, with the barrier of the base's limits."""
    exact: Float[AnyArray, ""]


def try_motion(
    y: Float[AnyArray, "joints m"],
    problem: Problem,
    p: float | Float[AnyArray, ""],
    mu: float | Float[AnyArray, ""],
) -> tuple[Float[AnyArray, ""], Tried]:
    """The smooth objective, and both values.

    Args:
        y: coordinates of the joint motion.
        problem: what stays the same.
        p: power of the means that stand for extremes.
        mu: weight of the logarithmic barrier of the base's limits.
    """
    scaled = (problem.scale[:, None] * y).T
    q, qd = (o + B @ scaled for o, B in zip(problem.offset, problem.per_y, strict=True))
    shown = shown_along(problem.craft.regressors, q, qd)

    def robot(robot: Robots):
        motion = float_along(problem.craft, shown, robot.pi, robot.phi, problem.dt)
        value = log_objective(problem.objective, _spectrum(problem, motion), p)
        return value, _barrier(problem.limits, motion)

    # One after the other: compiled once, and a search has few of them.
    values, barriers = jax.lax.map(robot, problem.robots)
    # The worst robot by the mean of power p, as for eigenvalues.
    worst = jax.nn.logsumexp(p * values.smooth) / p
    smooth = worst + mu * barriers.sum()
    return smooth, Tried(smooth, values.exact.max())


_value_and_gradient = jax.value_and_grad(try_motion, has_aux=True)
# Large problems run faster with XLA's newer fusion, small ones do not.
_large = jax.jit(_value_and_gradient)
_small = compiled(_value_and_gradient)


def value_and_gradient(
    y: Float[np.ndarray, "joints m"], problem: Problem, p: float, mu: float
) -> tuple[float, float, Float[np.ndarray, "joints m"]]:
    """The smooth value, the exact one, and the gradient of the smooth one."""
    small = problem.basis.pi_of.size <= SMALL**2
    function = _small if small else _large
    (_, tried), gradient = function(y, problem, p, mu)
    return float(tried.smooth), float(tried.exact), np.asarray(gradient)


def _spectrum(problem: Problem, motion: Floating) -> Float[AnyArray, " m"]:
    if problem.sensing is None:
        rows = Y_hat(motion, problem.basis.pi_of, problem.craft.at_rest)
        return log_squared_singular_values(rows)
    F = information(problem.sensing, motion, problem.dt, problem.craft.at_rest)
    return log_eigenvalues(F)


def _barrier(limits: BaseLimits, motion: Floating) -> Float[AnyArray, ""]:
    """`-sum log slack`, slack 1 where there is no limit; infinite beyond a limit."""
    slacks = [
        1 - (motion.w**2).sum(axis=1) / limits.rate**2,
        (motion.half_turn - limits.half_turn) / (1 - limits.half_turn),
        1 - (motion.qd_rw / limits.wheel_speed) ** 2,
    ]
    slack = jnp.concatenate([each.ravel() for each in slacks])
    inside = jnp.where(slack > 0, slack, 1.0)
    return jnp.where((slack > 0).all(), -jnp.log(inside).sum(), jnp.inf)
