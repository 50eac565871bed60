"""One step of the filter against the same equations, stacked and solved at once.

Nothing is carried in triangular factors here, and momentum, inertia and regressors are
those of a textbook, body by body.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious_momentum import system_motion
from random_motions import random_motion
from random_robots import (
    random_parents,
    random_planar_robot,
    random_quaternion,
    random_robot,
    random_wheels,
)
from recorded_samples import stream
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.noise import Noise, noise_of
from orbident.estimation.recursive.prior import GaussianPrior, cad_prior
from orbident.estimation.recursive.state import Info, Sample, State, packed
from orbident.estimation.stretches import smoothed_rate
from orbident.model.derivatives import derivatives_of_beta, sets_of_beta
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.settings import Settings
from orbident.robot.description import Robot
from orbident.robot.parameters import cross_matrix
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
    rate, scatter = smoothed_rate(samples, Settings())
    stds = noise_of(robot, samples, scatter)
    if name == "tree":
        stds = Noise(1e-4, 1e-4, joint_rates=1e-4, attitude=1e-4, gyro_walk=1e-5)
    kalman = Extended.of(robot, stds)
    every = [s for s in stream(samples, rate) if np.isfinite([*s.w, *s.w_smooth]).all()]
    state = kalman.start(cad_prior(robot), every[0])
    for sample in every[:before]:
        state, _ = kalman.step(state, sample)
    after, info = kalman.step(state, every[before])
    return Case(robot, kalman, state, every[before], after, info)


class Axes(NamedTuple):
    h: np.ndarray
    v: np.ndarray


def axes_of(sets: MinimalSets) -> Axes:
    own = sets.regressors
    return Axes(np.array(own.momentum_axes), np.array(own.velocity_axes))


def spread(vector: np.ndarray, axes: np.ndarray) -> np.ndarray:
    full = np.zeros(3)
    full[axes] = vector
    return full


def transition(case: Case, axes: Axes) -> tuple[np.ndarray, np.ndarray]:
    """`x_before = back x - kick w`."""
    noise, state = case.kalman.noise, case.state
    h, v = axes
    n_h, n_v = h.size, v.size
    n = len(state.top)
    dt = case.sample.t - state.t
    turned = rotation(case.sample) + state.R_WB
    integral = dt * turned / 2
    h_cm = spread(state.nuisances[:n_h], h)
    turn = noise.integrated * (-cross_matrix(h_cm) @ integral)[np.ix_(h, h)]
    back, bias = np.eye(n), np.arange(n_h + n_v, 2 * n_h + n_v)
    back[np.ix_(np.arange(n_h), bias)] -= turn
    kick = np.zeros((n, 2 * n_h))
    kick[:n_h, :n_h] = noise.gyro * turn
    kick[bias, n_h:] = noise.gyro_walk * np.sqrt(dt) * np.eye(n_h)
    if noise.accelerometer:
        speeds, last = np.arange(n_h, n_h + n_v), np.arange(n - n_v, n)
        back[np.ix_(speeds, last)] -= integral[np.ix_(v, v)]
        more = np.zeros((n, 2 * n_v))
        more[speeds, :n_v] = noise.velocity_walk * np.sqrt(dt) * np.eye(n_v)
        more[last, n_v:] = noise.accelerometer_walk * np.sqrt(dt) * np.eye(n_v)
        kick = np.hstack([kick, more])
    return back, kick


def rotation(sample: Sample) -> np.ndarray:
    return Rotation.from_quat(sample.x_WB).as_matrix()


class Laws(NamedTuple):
    """Both conservation laws of a sample, momentum first."""

    rows: np.ndarray
    """`[h_cm, v_cm, b_g, b_a, pi, phi | rhs]`."""
    of_gyro: np.ndarray
    """What noise of unit variance on each axis of the gyro adds."""
    covariance: np.ndarray
    """The covariance of their noise, each law's as if it were independent."""


def laws(case: Case, axes: Axes) -> Laws:
    """The rows by textbook formulas."""
    robot, state, sample = case.robot, case.state, case.sample
    noise, sets = case.kalman.noise, minimal_sets(robot)
    h, v = axes
    R_BW = rotation(sample).T
    theta = (sets.base.theta_of @ state.beta).reshape(-1, 10)
    at_beta = replace(robot, theta=theta)
    D_full, D_q, r_cm, J_cm = inertia(at_beta, sample.q)
    D = D_full[np.ix_(h, h)]
    U = -cross_matrix(r_cm)[np.ix_(v, h)]
    excess = (sample.w - sample.w_smooth)[h]
    w = np.array(sample.w)
    w[h] -= excess
    Y, W = regressors(robot, sets, sample.q, sample.qd, w)
    b_a = np.zeros((h.size, v.size if noise.accelerometer else 0))
    b_v = np.zeros((v.size, b_a.shape[1]))
    none_h, none_v = np.zeros((h.size, v.size)), np.zeros((v.size, h.size))
    no_phi, no_pi = np.zeros((h.size, W.shape[1])), np.zeros((v.size, Y.shape[1]))
    A_rw = np.array([wheel.inertia * wheel.axis for wheel in robot.wheels])
    h_rw = sample.qd_rw @ A_rw.reshape(-1, 3)
    rhs_h = -h_rw[h] - D @ excess
    rhs_v = (R_BW @ sample.v_S)[v] + U @ excess
    R_h, R_v = R_BW[np.ix_(h, h)], R_BW[np.ix_(v, v)]
    momentum = np.hstack([-R_h, none_h, -D, b_a, Y, no_phi, rhs_h[:, None]])
    velocity = np.hstack([none_v, R_v, U, b_v, no_pi, W, rhs_v[:, None]])
    turn = (R_BW @ cross_matrix(spread(state.nuisances[: h.size], h)))[h]
    D_q, J_cm = D_q[h], J_cm[v]
    G_h, G_v = noise.gyro * D, -noise.gyro * U
    C_h = np.hstack([G_h, noise.joint_rates * D_q, noise.attitude * turn])
    C_v = np.hstack([G_v, noise.joint_rates * J_cm, noise.velocity * np.eye(v.size)])
    return Laws(
        np.vstack([momentum, velocity]),
        np.vstack([G_h, G_v]),
        np.asarray(block_diag(C_h @ C_h.T, C_v @ C_v.T)),
    )


def white_equations(
    top: np.ndarray, kick: np.ndarray, own: Laws, momenta: int
) -> np.ndarray:
    """The rows of the nuisances and of a sample, by the covariance of all their noise.

    Args:
        top: rows of the nuisances, with noise of unit variance,
        kick: and what noise of unit variance adds to them, that of the gyro first.
        own: the sample's, over the same unknowns.
        momenta: how many axes of the gyro count.
    """
    C = np.eye(len(top)) + kick @ kick.T
    shared = own.of_gyro @ kick[:, :momenta].T
    # What the laws share beyond this is left out.
    between = shared @ np.linalg.solve(C, shared.T)
    between[:momenta, :momenta] = between[momenta:, momenta:] = 0.0
    joint = np.block([[C, shared.T], [shared, own.covariance + between]])
    return np.linalg.solve(np.linalg.cholesky(joint), np.vstack([top, own.rows]))


def inertia(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, ...]:
    """`D`, `D_q`, `r_cm` and `J_cm` from the momentum of unit rates."""
    joints, still = q.size, np.zeros(3)
    turns = [system_motion(robot, q, np.zeros(joints), e) for e in np.eye(3)]
    swings = [system_motion(robot, q, e, still) for e in np.eye(joints)]
    D, D_q = (np.array([at.h_rs for at in unit]).T for unit in (turns, swings))
    M, r_cm = robot.mass, turns[0].first_moment
    J_cm = np.array([at.linear for at in swings]).T
    return D, D_q, r_cm / M, J_cm / M


def regressors(
    robot: Robot, sets: MinimalSets, q: np.ndarray, qd: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`Y` and `W`: what every unit of `pi` and `phi` adds to momentum and velocity.

    `Y pi` is the angular momentum about the CM and `-W phi` the velocity of the CM
    relative to S, of as many robots as determine all columns.
    """
    random = np.random.default_rng(0)
    may = np.zeros(robot.theta.size, dtype=bool)
    may[list(robot.free_parameters)] = True
    may, sizes = may.reshape(robot.theta.shape), np.abs(robot.theta).max(axis=0)
    axes, pis, phis, momenta, speeds = axes_of(sets), [], [], [], []
    for _ in range(2 * len(sets.pi_of_beta) + 10):
        theta = robot.theta * random.uniform(0.2, 2.0, robot.theta.shape)
        none = may & (theta == 0.0)
        theta += np.where(none, sizes * random.uniform(0.1, 1.0, theta.shape), 0.0)
        at = system_motion(replace(robot, theta=theta), q, qd, w)
        pis.append(sets.pi(theta))
        phis.append(sets.phi(theta))
        momenta.append(at.h_rs[axes.h])
        speeds.append(-at.linear[axes.v] / theta[:, 0].sum())
    Y = np.linalg.lstsq(np.array(pis), np.array(momenta), rcond=None)[0].T
    W = np.linalg.lstsq(np.array(phis), np.array(speeds), rcond=None)[0].T
    return Y, W


def information(rows: np.ndarray, eliminated: int) -> np.ndarray:
    """`A^T A` of `[A | b]` with the first unknowns eliminated."""
    R = np.asarray(np.linalg.qr(rows, mode="r"))[eliminated:, eliminated:]
    return R.T @ R


def check_close(found: np.ndarray, expected: np.ndarray) -> None:
    """Relative to the diagonal: units differ by orders of magnitude."""
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / scale).max() < 1e-9


def test_what_is_known_of_the_parameters(case: Case):
    """All equations since the start in one least-squares problem, one step after."""
    axes = axes_of(minimal_sets(case.robot))
    back, kick = transition(case, axes)
    n, y = len(back), len(case.state.R_z)
    N, rest = case.state.top[:, :n], case.state.top[:, n:]
    own = laws(case, axes)
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
    y = np.concatenate(sets_of_beta(sets, state.beta))
    J = np.vstack(derivatives_of_beta(sets, state.beta))
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
    back, kick = transition(late, axes)
    n, k = len(back), state.beta.size
    y = np.concatenate(sets_of_beta(sets, state.beta))
    J = np.vstack(derivatives_of_beta(sets, state.beta))
    own = laws(late, axes)
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


def random_samples(robot: Robot, count: int) -> list[Sample]:
    """What no robot does, but the equations are the same."""
    random, joints = np.random.default_rng(1), len(robot.joints)
    samples = []
    for k in range(count):
        w, noise, v_S = random.standard_normal((3, 3))
        x_WB = random_quaternion(random)
        if robot.motion == "planar":
            w[:2] = noise[:2] = x_WB[:2] = 0.0
            x_WB /= np.linalg.norm(x_WB)
        q, qd = random.standard_normal((2, joints))
        qd_rw = 10.0 * random.standard_normal(len(robot.wheels))
        smooth = w + 0.1 * noise
        samples.append(Sample(0.1 * k, q, qd, w, x_WB, qd_rw, v_S, smooth))
    return samples


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
