"""Parameters are as good as their own covariance says, from poor CAD values."""

from dataclasses import replace
from functools import cache, partial
from typing import NamedTuple

import numpy as np
import pytest
from scipy.stats import chi2

from orbident.campaigns.executors import InThisProcess, local
from orbident.campaigns.seeds import SeedRuns, Series
from orbident.estimation.identify import Method, identify
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.simulation.free_floating import FreeFloating
from orbident.simulation.measure import measure_truth, truth_of
from orbident.simulation.simulate import float_along
from orbident.studies import paper_tables
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.threads import at_hand

OFF = 0.2
"""Every entry of `theta` is off by this part of itself, up or down."""

CHANCE = 0.01
"""The chance of a right covariance failing here, had the seeds not been chosen."""

LONG = 100

RUNS = [
    pytest.param(6, marks=pytest.mark.slow),
    pytest.param(LONG, marks=pytest.mark.long),
]

LAZY = 0.7
"""Squared errors of `structured` are at least this part of what it says of them: it
takes some noise that neighbouring samples share for white."""


class Campaign(NamedTuple):
    """What came of runs that differ in their noise and CAD values."""

    errors: np.ndarray
    """Errors of `[pi, phi, M]`, a row each run."""
    std: np.ndarray
    nees: np.ndarray
    """Squared errors of the base parameters, whitened by their covariance."""
    dof: int


def off_by(robot: Robot, seed: int) -> Robot:
    signs = np.random.default_rng(1000 + seed).choice([-1.0, 1.0], robot.theta.shape)
    return replace(robot, theta=robot.theta * (1 + OFF * signs))


@cache
def flight() -> FreeFloating:
    """Section 4's motion."""
    robot = spatial_robot()
    return float_along(robot, spatial_trajectory(robot), paper_tables.SPATIAL_RATE)


def run(method: Method, seed: int) -> np.ndarray:
    """Section 3.5's noise: errors, their deviations, and the whitened square of all."""
    robot = spatial_robot()
    sets, theta = minimal_sets(robot), robot.theta
    true, beta = np.concatenate([sets.pi(theta), sets.phi(theta)]), sets.beta(theta)
    true_motion = truth_of(robot, flight(), spatial_trajectory(robot))
    recording = measure_truth(robot, flight().t, true_motion, seed)
    found = identify(off_by(robot, seed), recording, method)
    assert found.status == "ok"
    assert found.warnings == ()
    values = np.concatenate([found.pi.values, found.phi.values])
    errors = [*(values - true), found.mass.value - robot.mass]
    std = [*found.pi.std, *found.phi.std, found.mass.std]
    miss = found.base.values - beta
    nees = miss @ np.linalg.solve(found.base_covariance, miss)
    return np.array([*errors, *std, nees])


@cache
def campaign(runs: int, method: Method) -> Campaign:
    """All seeds; many of them on all processors."""
    where = local(at_hand()) if runs == LONG else InThisProcess
    (made,) = SeedRuns(executors=where).over(Series(partial(run, method), range(runs)))
    errors, std = np.split(made.runs[:, :-1], 2, axis=1)
    dof = minimal_sets(spatial_robot()).base.T.shape[0]
    return Campaign(errors, std, made.runs[:, -1], dof)


@pytest.mark.parametrize("runs", RUNS)
def test_errors_are_as_large_as_reported(runs: int):
    """RMS error over RMS deviation, for every `pi`, `phi` and `M`."""
    done = campaign(runs, "maximum-likelihood")
    squares = np.mean(np.square(done.errors / done.std), axis=0)
    # Of normal errors `runs` times that is chi-square; shared among the parameters.
    tails = CHANCE / (2 * squares.size)
    low, high = (chi2.isf(tail, runs) / runs for tail in (1 - tails, tails))
    assert (squares > low).all()
    assert (squares < high).all()


@pytest.mark.parametrize("runs", RUNS)
def test_errors_go_together_as_reported(runs: int):
    """Whitened by the covariance of the base parameters: 18 degrees of freedom."""
    done = campaign(runs, "maximum-likelihood")
    assert done.dof == 18
    freedom = runs * done.dof
    low, high = (chi2.isf(tail, freedom) for tail in (1 - CHANCE / 2, CHANCE / 2))
    assert low < done.nees.sum() < high


@pytest.mark.long
def test_structured_promises_no_more_than_it_keeps():
    done = campaign(LONG, "structured")
    squares = np.mean(np.square(done.errors / done.std), axis=0)
    assert (squares < chi2.isf(CHANCE / (2 * squares.size), LONG) / LONG).all()
    freedom = LONG * done.dof
    assert LAZY * freedom < done.nees.sum() < chi2.isf(CHANCE / 2, freedom)


@pytest.mark.long
@pytest.mark.parametrize("method", ["structured", "recursive"])
def test_other_methods_are_hardly_worse(method: Method):
    """The equations hold nearly all that the sensors say."""
    own, best = campaign(LONG, method), campaign(LONG, "maximum-likelihood")
    size, least = (np.square(c.errors).mean(axis=0) for c in (own, best))
    assert np.sqrt(np.mean(size / least)) < 1.05
