"""From conditions to the problem that is searched."""

from math import ceil

import numpy as np

from orbident.excitation.conditions import Conditions
from orbident.excitation.floating import spacecraft_of
from orbident.excitation.information import sensing_of
from orbident.excitation.joint_motions import JointMotions, joint_motions
from orbident.excitation.plausible import plausible_thetas
from orbident.excitation.problem import BaseLimits, Problem, Robots
from orbident.excitation.scores import basis_of
from orbident.excitation.spectra import Objective
from orbident.excitation.start import was_at_rest
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.description import Robot

STEPS = 128
"""Of the search's grid, up to eight harmonics; sixteen a period."""

FINER = 4
"""Limits are kept on a grid so much finer: between its nodes, to a few in 10000."""

STEP_ANGLE = 0.2
"""In space the base turns no farther in a step, rad."""


def motions_for(robot: Robot, given: Conditions, objective: Objective) -> JointMotions:
    """The joint motions to search, on the grid on which limits are kept."""
    sets = minimal_sets(robot)
    turned = float(np.linalg.norm(given.initial.angular_velocity)) * given.duration
    turns = 0 if robot.motion == "planar" else ceil(turned / STEP_ANGLE)
    # Twice as many rows as unknowns: fewer would let rounding excite them.
    pis, betas = sets.pi_of_beta.shape
    unknowns = pis if objective == "cond" else betas
    axes = len(sets.regressors.momentum_axes)
    steps = max(STEPS, 16 * given.harmonics, turns, ceil(2 * unknowns / axes))
    return joint_motions(
        given.start,
        given.end,
        given.duration,
        given.harmonics,
        given.limits,
        FINER * steps + 1,
    )


def problem_for(
    robot: Robot,
    given: Conditions,
    motions: JointMotions,
    objective: Objective,
    uncertainty: float,
) -> Problem:
    """What is minimised, for the nominal robot and those that could be the true one.

    Raises:
        InputError: the objective needs sensors that the robot file does not have.
    """
    sets, coarse = minimal_sets(robot), motions.every(FINER)
    at_rest = was_at_rest(robot, given.initial, given.start)
    thetas = plausible_thetas(robot.theta, uncertainty)
    limits = given.limits
    half = np.cos(min(limits.excursion, 2 * np.pi) / 2)
    return Problem(
        craft=spacecraft_of(robot, sets.regressors, given.initial, at_rest),
        robots=Robots(
            np.array([sets.pi(theta) for theta in thetas]),
            np.array([sets.phi(theta) for theta in thetas]),
        ),
        basis=given.basis or basis_of(sets),
        sensing=None if objective == "cond" else sensing_of(robot, sets),
        offset=coarse.offset[:2],
        per_y=coarse.basis[:2],
        scale=coarse.scale,
        dt=float(coarse.t[1]),
        limits=BaseLimits(limits.base_rate, half, limits.wheel_speed),
        objective=objective,
    )
