"""One step of the filter against the same equations, stacked and solved at once.

They are those of `reference/filter_step.py`.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_motions import random_motion
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_wheels,
)
from recorded_samples import random_samples, stream
from reference.filter_step import (
    axes_of,
    information,
    laws,
    transition,
    white_equations,
)

from orbident.estimation.recursive.filter import (
    Extended,
    GaussianPrior,
    Info,
    Sample,
    State,
    cad_prior,
    packed,
)
from orbident.estimation.recursive.filter_input import Noise, noise_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.smoothing import Settings
from orbident.preprocessing.stretches import rate_scatter, smoothed_rate
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

pytestmark = pytest.mark.core

ROBOTS: dict[str, Robot] = {
    "sensors": load_robot("paper-spatial"),
    "table": load_robot("cepheus-like"),
    "tree": random_robot(
        3, (0, 0, 2), [1], random_wheels(3, ("held", "held", "free")), base=5.0
    ),
}


class Case(NamedTuple):
    robot: Robot
    kalman: Extended
    state: State
    sample: Sample
    after: State
    info: Info


EARLY = 30
"""Samples: fewer than the filter takes to hand over."""


@pytest.fixture(scope="module", params=ROBOTS)
def case(request) -> Case:
    """A step over `[pi, phi]`."""
    early = one_step(request.param, EARLY)
    assert not early.after.held_in_beta
    return early


@pytest.fixture(scope="module", params=["sensors", "tree"])
def late(request) -> Case:
    """A step over `beta`."""
    held = one_step(request.param, 100)
    assert held.state.held_in_beta
    return held


def one_step(name: str, before: int) -> Case:
    """The step after so many others."""
    robot = ROBOTS[name]
    start = "spun up" if robot.motion == "planar" else "turning"
    motion = random_motion(robot, duration=12.0, start=start)
    noise = "none" if name == "tree" else "sensors"
    samples = samples_of(robot, simulate(robot, motion, rate=10.0, noise=noise))
    settings = Settings()
    rate = smoothed_rate(samples, settings)
    stds = noise_of(robot, samples, rate_scatter(samples, settings))
    if name == "tree":
        stds = Noise(1e-4, 1e-4, joint_rates=1e-4, attitude=1e-4, gyro_walk=1e-5)
    kalman = Extended.of(robot, stds)
    every = [s for s in stream(samples, rate) if np.isfinite([*s.w, *s.w_smooth]).all()]
    state = kalman.start(cad_prior(robot), every[0])
    for sample in every[:before]:
        state, _ = kalman.step(state, sample)
    after, info = kalman.step(state, every[before])
    return Case(robot, kalman, state, every[before], after, info)


def check_close(found: np.ndarray, expected: np.ndarray) -> None:
    """Relative to the diagonal: units differ by orders of magnitude."""
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / scale).max() < 1e-9


def test_what_is_known_of_the_parameters(case: Case):
    """All equations since the start in one least-squares problem, one step after."""
    axes = axes_of(minimal_sets(case.robot))
    back, kick = transition(case.kalman.noise, case.state, case.sample, axes)
    n, y = len(back), len(case.state.R_z)
    N, rest = case.state.top[:, :n], case.state.top[:, n:]
    own = laws(case.robot, case.kalman.noise, case.state, case.sample, axes)
    top = np.hstack([N @ back, rest])
    stacked = np.vstack(
        [
            white_equations(top, N @ kick, own, axes.h.size),
            np.hstack([np.zeros((y, n)), case.state.R_z]),
        ]
    )
    after = case.after
    expected = information(stacked, n)
    found = after.R_z.T @ after.R_z
    # The last entry is the residual, which the innovation has the new part of.
    check_close(found[:-1, :-1], expected[:-1, :-1])
    np.testing.assert_allclose(found[:-1, -1], expected[:-1, -1], rtol=1e-6)
    total = found[-1, -1] + case.info.nis
    np.testing.assert_allclose(total, expected[-1, -1], rtol=1e-9)
    assert case.info.dof == len(own.rows)

    both = np.vstack([after.top, np.hstack([np.zeros((y, n)), after.R_z])])
    check_close((both.T @ both)[:-1, :-1], information(stacked, 0)[:-1, :-1])


def test_the_estimate(case: Case):
    """Gauss and Newton from the last one, with the prior; the nuisances after it."""
    state, after = case.state, case.after
    sets = case.kalman.sets
    y = np.concatenate(sets.pi_and_phi(state.beta))
    J = np.vstack(sets.derivatives(state.beta))
    R, z = after.R_z[:, :-1], after.R_z[:, -1]
    A = np.vstack([R @ J, state.prior[:, :-1]])
    b = np.append(z - R @ (y - J @ state.beta), state.prior[:, -1])
    beta = np.linalg.lstsq(A, b, rcond=None)[0]
    np.testing.assert_allclose(after.beta, beta, atol=1e-9 * np.abs(beta).max())
    check_close(after.root.T @ after.root, A.T @ A)
    iota_first = np.roll(after.root, sets.iotas, axis=1)
    assert not np.tril(iota_first, -1).any()
    n = len(after.top)
    told = after.top[:, -1] - after.top[:, n:-1] @ (y + J @ (after.beta - state.beta))
    x = np.linalg.solve(after.top[:, :n], told)
    np.testing.assert_allclose(after.nuisances, x, atol=1e-9 * np.abs(x).max())


def test_a_step_over_beta(late: Case):
    """The same equations, linearised about the estimate before them."""
    state, after, sets = late.state, late.after, late.kalman.sets
    axes = axes_of(sets)
    back, kick = transition(late.kalman.noise, late.state, late.sample, axes)
    n, k = len(back), state.beta.size
    y = np.concatenate(sets.pi_and_phi(state.beta))
    J = np.vstack(sets.derivatives(state.beta))
    own = laws(late.robot, late.kalman.noise, late.state, late.sample, axes)
    X, Y, z = own.rows[:, :n], own.rows[:, n:-1], own.rows[:, -1]
    linear = np.column_stack([X, Y @ J, z - Y @ (y - J @ state.beta)])
    N, rest = state.top[:, :n], state.top[:, n:]
    top, own = np.hstack([N @ back, rest]), own._replace(rows=linear)
    root_z = np.column_stack([state.root, state.root @ state.beta])
    stacked = np.vstack(
        [
            white_equations(top, N @ kick, own, axes.h.size),
            np.hstack([np.zeros((k, n)), root_z]),
        ]
    )
    root_z = np.column_stack([after.root, after.root @ after.beta])
    both = np.vstack([after.top, np.hstack([np.zeros((k, n)), root_z])])
    expected = information(stacked, 0)
    check_close((both.T @ both)[:-1, :-1], expected[:-1, :-1])
    solution = np.linalg.solve(both[:, :-1], both[:, -1])
    x, beta = solution[:n], solution[n:]
    np.testing.assert_allclose(after.beta, beta, atol=1e-9 * np.abs(beta).max())
    np.testing.assert_allclose(after.nuisances, x, atol=1e-9 * np.abs(x).max())
    L = np.linalg.cholesky(expected[:-1, :-1])
    whitened = L.T @ solution - np.linalg.solve(L, expected[:-1, -1])
    # Deviations: squares of entries of 1e6 lose half the digits.
    assert np.linalg.norm(whitened) < 1e-4
    total = np.square(both[:, -1]).sum() + late.info.nis
    np.testing.assert_allclose(total, expected[-1, -1], rtol=1e-9)


def tree(seed: int, slides: list[bool], planar: bool, massless: bool) -> Robot:
    """Any tree: sliding joints, planar ones, a link without mass."""
    random, joints = np.random.default_rng(seed), len(slides)
    build = random_planar_robot if planar else random_robot
    parents = random_parents(random, joints)
    wheels = random_wheels(seed, ("held", "held"))
    robot = build(seed, parents, np.flatnonzero(slides).tolist(), wheels)
    theta = robot.theta.copy()
    if massless:
        theta[1 + seed % joints] = 0.0
    return replace(robot, theta=theta)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**16),
    slides=st.lists(st.booleans(), min_size=1, max_size=3),
    planar=st.booleans(),
    massless=st.booleans(),
    integrated=st.booleans(),
    accelerometer=st.booleans(),
)
def test_any_tree(
    seed: int,
    slides: list[bool],
    planar: bool,
    massless: bool,
    integrated: bool,
    accelerometer: bool,
):
    """Random numbers for all sensors, and every kind of noise."""
    robot = tree(seed, slides, planar, massless)
    stds = Noise(
        gyro=0.1,
        velocity=0.2,
        gyro_bias=0.3,
        gyro_walk=0.1,
        integrated=float(integrated),
        attitude=0.1,
        velocity_walk=0.2,
        accelerometer_bias=0.3,
        accelerometer_walk=0.1,
        joint_rates=0.1,
        momentum_walk=0.2,
        accelerometer=accelerometer,
    )
    kalman, sets = Extended.of(robot, stds), minimal_sets(robot)
    every = random_samples(robot, len(sets.pi_of_beta) + 4)
    beta = sets.beta(robot.theta)
    prior = GaussianPrior(beta, np.diag(1.0 / (0.3 * np.abs(beta) + 0.1)))
    state = kalman.start(prior, every[0])
    # One estimate more would wander off: nothing here is true.
    t, rows = np.array([s.t for s in every]), np.array([packed(s) for s in every])
    state, _, _ = kalman.gathered(state, t[:-1], rows[:-1])
    after, info = kalman.step(state, every[-1])
    case = Case(robot, kalman, state, every[-1], after, info)
    test_what_is_known_of_the_parameters(case)
    test_the_estimate(case)
