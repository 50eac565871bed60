"""The filter from CAD values to the truth, and what it does with bad samples."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flight_builds import one_joint
from random_motions import random_motion
from random_robots import random_robot, random_wheels
from recorded_samples import stream

from orbident.errors import InputError
from orbident.estimation.recursive.filter import (
    Extended,
    Sample,
    State,
    cad_prior,
    prior_from,
)
from orbident.estimation.recursive.filter_input import Noise, filter_input_of, noise_of
from orbident.estimation.recursive.history import (
    Detector,
    filter_history,
    recursive_history,
)
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

FINE = Noise(gyro=1e-6, velocity=1e-6)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("paper-spatial")


@pytest.fixture(scope="module")
def sets(robot: Robot) -> MinimalSets:
    return minimal_sets(robot)


@pytest.fixture(scope="module")
def every(robot: Robot) -> list[Sample]:
    motion = random_motion(robot, duration=20.0)
    return list(stream(samples_of(robot, simulate(robot, motion, rate=10.0))))


def off(robot: Robot, seed: int = 0) -> Robot:
    random = np.random.default_rng(seed)
    return replace(
        robot, theta=robot.theta * (1 + random.uniform(-0.2, 0.2, robot.theta.shape))
    )


def run(robot: Robot, every: list[Sample]) -> State:
    kalman = Extended.of(robot, FINE)
    state = kalman.start(cad_prior(off(robot)), every[0])
    for sample in every:
        state, _ = kalman.step(state, sample)
    return state


def check_same(found: State, expected: State) -> None:
    np.testing.assert_array_equal(found.beta, expected.beta)
    np.testing.assert_array_equal(found.root, expected.root)


def test_without_noise_it_finds_the_truth(
    robot: Robot, sets: MinimalSets, every: list[Sample]
):
    state = run(robot, every)
    error = state.beta - sets.beta(robot.theta)
    # Exact samples, and a prior of 30 % that 600 rows of 1e-6 outweigh.
    assert np.abs(error / state.beta).max() < 1e-3
    assert np.linalg.norm(state.root @ error) < 3.0


def test_handing_over_costs_a_tenth_of_a_deviation(robot: Robot, sets: MinimalSets):
    """Against Gauss and Newton on all that the samples say of `[pi, phi]`."""
    recording = simulate(robot, random_motion(robot, duration=60.0), noise="sensors")
    t, every, noise = filter_input_of(robot, samples_of(robot, recording))
    kalman = Extended.of(off(robot), noise)
    state = before = kalman.begun(cad_prior(off(robot)), every[0], None)
    for k in range(t.size):
        before = state if not state.held_in_beta else before
        state = State(kalman.core.step(state.core, t[k], every[k])[0])
    assert state.held_in_beta
    assert before.t < t[-1] / 2
    exact, _, _ = kalman.gathered(before, t, every)
    R, z = exact.R_z[:, :-1], exact.R_z[:, -1]
    beta, A = state.beta, state.prior
    for _ in range(5):
        y, J = sets.pi_and_phi(beta), sets.derivatives(beta)
        A = np.vstack([R @ np.vstack(J), state.prior[:, :-1]])
        b = z - R @ (np.concatenate(y) - np.vstack(J) @ beta)
        beta = np.linalg.lstsq(A, np.append(b, state.prior[:, -1]), rcond=None)[0]
    assert np.linalg.norm(state.root @ (state.beta - beta)) < 0.1
    # Deviations in all directions, beside those of the exact factor.
    ratios = np.linalg.svd(A @ np.linalg.inv(state.root), compute_uv=False)
    np.testing.assert_allclose(ratios, 1.0, atol=0.02)


@pytest.mark.slow
def test_many_samples_at_once_say_what_they_say_one_by_one(robot: Robot):
    """In blocks, and on any number of threads."""
    recording = simulate(robot, random_motion(robot, duration=60.0), noise="sensors")
    t, every, noise = filter_input_of(robot, samples_of(robot, recording))
    # Not complete, without a velocity, and of a gyro that is dead.
    every[7], every[8, 16:19] = np.nan, np.nan
    every[20, 6:9] = every[19, 6:9]
    t, every = (
        np.tile(t, 2) + np.repeat(60.0 * np.arange(2), t.size),
        np.tile(every, (2, 1)),
    )
    core = Extended.of(robot, noise).core
    start = core.start(cad_prior(robot).beta, cad_prior(robot).root, every[0], None)
    blocks, squares, rows = core.gathered(start, t, every, 2)
    again, *_ = core.gathered(start, t, every, 1)
    np.testing.assert_array_equal(blocks.numbers, again.numbers)
    state, left, count = start, 0.0, 0
    for k in range(t.size):
        state, more, own = core.gathered(state, t[k : k + 1], every[k : k + 1])
        left, count = left + more, count + own
    assert rows == count
    assert 0 < 6 * t.size - rows < 6 * 15
    assert squares == pytest.approx(left, rel=1e-10)
    for part in ("R_z", "top"):
        one, other = (getattr(State(each), part) for each in (blocks, state))
        np.testing.assert_allclose(np.abs(one), np.abs(other), rtol=1e-6, atol=1e-6)


def test_a_robot_at_rest_is_not_handed_over(robot: Robot, every: list[Sample]):
    """It shows its inertia in one configuration, and hardly anything of its CM."""
    kalman = Extended.of(robot, FINE)
    state = kalman.start(cad_prior(robot), every[0])
    for k in range(100):
        still = every[k]._replace(q=every[0].q, qd=np.zeros(3), v_S=every[0].v_S)
        state, _ = kalman.step(state, still)
    assert not state.held_in_beta


def test_a_tree_with_a_slide():
    robot = random_robot(
        3, (0, 0, 2), [1], random_wheels(3, ("held", "held", "free")), base=5.0
    )
    motion = random_motion(robot, duration=20.0)
    every = list(stream(samples_of(robot, simulate(robot, motion, rate=10.0))))
    sets = minimal_sets(robot)
    state = run(robot, every)
    error = state.root @ (state.beta - sets.beta(robot.theta))
    assert error @ error / error.size < 1.0
    assert state.beta[0] == pytest.approx(robot.mass, rel=1e-3)


@pytest.mark.parametrize("sensor", ["q", "w", "x_WB", "qd_rw"])
def test_incomplete_samples_do_not_count(
    robot: Robot, sets: MinimalSets, every: list[Sample], sensor: str
):
    holes = [
        s._replace(**{sensor: np.full_like(getattr(s, sensor), np.nan)})
        for s in every[20:40]
    ]
    check_same(
        run(robot, every[:20] + holes + every[40:60]),
        run(robot, every[:20] + every[40:60]),
    )


@pytest.mark.parametrize(
    "spoiled",
    [{"t": np.nan}, {"t": np.inf}, {"t": 2e9}, {"x_WB": np.zeros(4)}]
    + [{name: np.full(3, 1e300)} for name in ("q", "w", "v_S")],
    ids=str,
)
def test_impossible_samples_do_not_count(
    robot: Robot, every: list[Sample], spoiled: dict
):
    whole = run(robot, every)
    absurd = every[50]._replace(**spoiled)
    check_same(run(robot, [*every[:50], absurd, *every[50:]]), whole)


def test_what_is_believed_after_a_change(robot: Robot, every: list[Sample]):
    """Its covariance is that of before and that of the change."""
    kalman, state = Extended.of(robot, FINE), run(robot, every)
    random = np.random.default_rng(0)
    S = random.standard_normal((len(state.beta), len(state.beta)))
    std = np.sqrt(np.diag(state.covariance))
    change = std[:, None] * (S @ S.T + np.eye(len(std))) * std
    opened = kalman.opened(state, change)
    np.testing.assert_array_equal(opened.beta, state.beta)
    assert not opened.held_in_beta
    # Rounding: covariances here have digits for 1e-6 of what they are.
    expected = (state.covariance + change) / np.outer(std, std)
    found = opened.covariance / np.outer(std, std)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * expected.max())


def test_rows_written_twice_count_once(
    robot: Robot, sets: MinimalSets, every: list[Sample]
):
    twice = [sample for sample in every[:30] for _ in range(2)]
    check_same(run(robot, twice), run(robot, every[:30]))
    late = [*every[:30], *every[:30]]
    check_same(run(robot, late), run(robot, every[:30]))


def test_a_gyro_that_dies_is_not_believed(
    robot: Robot, sets: MinimalSets, every: list[Sample]
):
    dead = [s._replace(w=every[29].w) for s in every[30:60]]
    check_same(run(robot, every[:30] + dead), run(robot, every[:30]))


def test_without_velocity_the_momentum_is_told(
    robot: Robot, sets: MinimalSets, every: list[Sample]
):
    kalman = Extended.of(robot, FINE)
    state = kalman.start(cad_prior(robot), every[0])
    blind = every[0]._replace(v_S=np.full(3, np.nan))
    after, info = kalman.step(state, blind)
    assert info.dof == 3
    assert not info.white[3:].any()
    assert np.isfinite(after.beta).all()


def test_float32_samples_are_taken(
    robot: Robot, sets: MinimalSets, every: list[Sample]
):
    rounded = [
        Sample(s.t, *(np.asarray(x, dtype=np.float32) for x in s[1:]))
        for s in every[:40]
    ]
    state = run(robot, rounded)
    assert state.beta.dtype == np.float64
    assert np.isfinite(state.root).all()


def test_a_robot_of_many_parameters():
    """What rounding leaves of few rows and many columns underflows on the way."""
    robot = load_robot("dual-arm")
    every = list(
        stream(samples_of(robot, simulate(robot, random_motion(robot, 0, 4.0))))
    )
    state = run(robot, every[:5])
    assert np.isfinite(state.R_z).all()
    assert np.isfinite(state.root).all()


def test_inputs_are_left_alone(robot: Robot, sets: MinimalSets, every: list[Sample]):
    kalman = Extended.of(robot, FINE)
    state = kalman.start(cad_prior(robot), every[0])
    kept = state.beta, state.root, state.top, state.R_z
    kalman.step(state, every[0])
    for found, before in zip(
        (state.beta, state.root, state.top, state.R_z), kept, strict=True
    ):
        np.testing.assert_array_equal(found, before)


def test_a_prior_is_what_it_was_made_from():
    random = np.random.default_rng(0)
    A = random.standard_normal((4, 4))
    prior = prior_from(np.arange(4.0), A @ A.T)
    np.testing.assert_allclose(
        np.linalg.inv(prior.root.T @ prior.root), A @ A.T, rtol=1e-9
    )
    with pytest.raises(InputError, match="positive definite"):
        prior_from(np.zeros(2), np.ones((2, 2)))


def test_without_a_wheel_there_is_no_scale():
    robot = random_robot(5, (0, 1), base=5.0)
    motion = random_motion(robot, duration=5.0)
    samples = samples_of(robot, simulate(robot, motion, rate=10.0))
    history = recursive_history(robot, samples)
    assert not history.scale
    assert not history.determined.any()
    assert np.isnan(history.M).all()
    assert history.changes == ()


@pytest.mark.parametrize("name", ["revolute", "prismatic"])
def test_without_a_scale_all_else_is_estimated(name: str, tmp_path: Path):
    """As of a robot with the nominal mass: nothing of it shrinks or overflows."""
    robot = load_robot(one_joint(tmp_path, name, wheel=False))
    motion = random_motion(robot, duration=20.0)
    samples = samples_of(robot, simulate(robot, motion, rate=20.0, noise="sensors"))
    wrong = off(robot)
    given = filter_input_of(wrong, samples)
    kalman = Extended.of(wrong, given.noise)
    detector = Detector(kalman.rows, samples=given.t.size)
    seen = filter_history(wrong, kalman, detector, given, None)
    assert not seen.scale
    assert seen.changes == ()
    assert seen.beta[-1, 0] == pytest.approx(wrong.mass, rel=1e-3)
    true = minimal_sets(robot).beta(robot.theta) * wrong.mass / robot.mass
    assert np.abs((seen.beta[-1] - true) / seen.std[-1]).max() < 4


def test_noise_is_what_the_robot_file_says(robot: Robot, sets: MinimalSets):
    motion = random_motion(robot, duration=10.0)
    samples = samples_of(robot, simulate(robot, motion, noise="sensors"))
    noise = noise_of(robot, samples)
    N = robot.sensors.of("gyro").white_std()
    assert noise.gyro == pytest.approx(N * np.sqrt(20.0))
    assert noise.integrated == 1.0
    assert noise.accelerometer


def test_a_table_with_a_constant_wheel_speed_has_no_scale():
    """Its momentum tells nothing unless it is known to be zero."""
    robot = load_robot("cepheus-like")
    motion = random_motion(robot, 3, 10.0, -170.0, "spun up")
    samples = samples_of(robot, simulate(robot, motion, noise="sensors"))
    assert not recursive_history(off(robot), samples).scale
    history = recursive_history(off(robot), samples, h_cm=np.zeros(3))
    assert history.scale
    assert history.changes == ()
    assert abs(history.M[-1] - robot.mass) < 3 * history.std[-1, 0]
