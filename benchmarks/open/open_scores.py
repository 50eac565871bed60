"""How good the answers to a problem are."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from answers import Answer
from problem_folder import Problem

from orbident.identified.prediction import momentum_terms
from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.samples import samples_of

NORMAL = 1.96
"""Deviations that hold 95 % of what is normally distributed."""
NONE = float("nan")


class Score(NamedTuple):
    """One method on one problem, over its recordings; NaN where it does not apply."""

    error: float
    """RMS of the errors over the Cramér-Rao bound: 1 is the best on average."""
    coverage: float
    """Share of the true values within 1.96 deviations; 0.95 is right."""
    refused: int
    of: int
    rate: float
    """RMS error of the predicted base rate of the unused run, over its own RMS."""
    velocity: float
    """RMS error of the predicted velocity of S on that run, over its own RMS."""
    seconds: float
    """Median."""


def score(problem: Problem, answers: Sequence[Answer]) -> Score:
    """Compare with the truth, and predict the run that was not used."""
    given = [answer for answer in answers if not answer.refused]
    ratios, inside = [], []
    for answer in given:
        for name, true in problem.truth.items():
            if name in answer.values and true["bound"]:
                error = answer.values[name] - true["value"]
                ratios.append(error / true["bound"])
                inside.append(abs(error) < NORMAL * answer.std[name])
    predicted = [prediction_errors(problem, answer) for answer in given]
    rate, velocity = np.median(predicted, axis=0) if predicted else (NONE, NONE)
    return Score(
        error=float(np.sqrt(np.mean(np.square(ratios)))) if ratios else NONE,
        coverage=float(np.mean(inside)) if inside else NONE,
        refused=len(answers) - len(given),
        of=len(answers),
        rate=float(rate),
        velocity=float(velocity),
        seconds=float(np.median([answer.seconds for answer in answers])),
    )


def prediction_errors(problem: Problem, answer: Answer) -> tuple[float, float]:
    """Errors of base rate and velocity of S, each over its RMS about the mean.

    `D w = R_0^T h - D_q qd - A_rw qd_rw` gives the rate (Eq. 16), `phi` the velocity
    (Eq. 30). Momentum and velocity of the CM are constants of the run: means over it.
    """
    robot = problem.robot
    regressors = minimal_sets(robot).regressors
    _, run = samples_of(robot, problem.unused()).complete()
    sets = minimal_sets(robot)
    pi = answer.vector("pi", len(sets.pi_of_beta))
    phi = answer.vector("phi", sets.base.sigmas)
    at = momentum_terms(regressors, pi, phi, run.q, run.qd)
    R, turning = quaternion_matrix(run.x_WB), list(regressors.momentum_axes)
    moving = list(regressors.velocity_axes)
    h = at.h_q + run.qd_rw @ wheels_of(robot).A_rw.T
    h_cm = rotate(R, rotate(at.D, run.w) + h).mean(axis=0)
    left = (rotate(np.swapaxes(R, 1, 2), h_cm) - h)[:, turning]
    D = at.D[:, turning][:, :, turning]
    if not np.isfinite(D).all():
        return NONE, NONE
    w = np.zeros_like(run.w)
    w[:, turning] = np.linalg.solve(D, left[:, :, None])[:, :, 0]
    v = rotate(R, rotate(at.V, w) + at.v_q)
    v += (run.v_S - v).mean(axis=0)
    return (
        _relative(w[:, turning], run.w[:, turning]),
        _relative(v[:, moving], run.v_S[:, moving]),
    )


def _relative(predicted: np.ndarray, true: np.ndarray) -> float:
    size = np.sqrt(np.mean((true - true.mean(axis=0)) ** 2))
    return float(np.sqrt(np.mean((predicted - true) ** 2)) / size)
