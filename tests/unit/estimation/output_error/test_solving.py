"""The whole chain, against its equations stacked and solved at once."""

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from small_problems import (
    NOTHING_ACTS,
    Small,
    noisy,
    small_problem,
    small_recording,
    small_robot,
)

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.output_error.problem import NO_ROWS, SENSORS, Problem, linear
from orbident.estimation.output_error.solver import (
    FALLS,
    SAME,
    _damped,
    equations_at,
    solved,
)
from orbident.estimation.solution import SMALL, Unknowns
from orbident.recordings.recording import Recording
from orbident.robot.sensor_schema import declared_sensors


@pytest.fixture(scope="module")
def recording() -> Recording:
    return small_recording(small_robot())


@pytest.fixture(scope="module")
def small(recording) -> Small:
    return small_problem(small_robot(), noisy(recording, 0))


class Dense(NamedTuple):
    """All equations at a state over `[z_0 ... z_S, g]`."""

    A: np.ndarray
    b: np.ndarray
    common: int

    def with_prior(self, prior, state) -> "Dense":
        rows = np.zeros((self.common, self.A.shape[1]))
        rows[:, -self.common :] = np.diag(1 / prior.std)
        rhs = (prior.values - state.common) / prior.std
        return Dense(np.vstack([self.A, rows]), np.append(self.b, rhs), self.common)

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        """Solution of least squares, and its covariance; columns scaled to one size."""
        size = np.linalg.norm(self.A, axis=0)
        Q, R = np.linalg.qr(self.A / size)
        root = np.linalg.inv(R) / size[:, None]
        return root @ (Q.T @ self.b), root @ root.T


def dense(problem: Problem, state: Unknowns) -> Dense:
    """First what is known beforehand of the first boundary, then all intervals."""
    boundaries, local = state.local.shape
    common, chain = state.common.size, state.local.size
    weights = [problem.weights.get(name, NO_ROWS) for name in SENSORS]
    first = problem.loose.first
    tables = []

    def put(rows: np.ndarray, place: np.ndarray) -> None:
        table = np.zeros((len(rows), chain + common + 1))
        table[:, place] = rows
        tables.append(table)

    g = np.arange(chain, chain + common + 1)
    beforehand = np.column_stack([np.eye(local), np.zeros((local, common + 1))])
    beforehand[:, -1] = -state.local[0]
    put(beforehand / first[:, None], np.r_[:local, g])
    for s in range(boundaries - 1):
        rows = _core.interval_equations(
            problem.recorded,
            weights=weights,
            coloured=problem.lasting,
            acting=NOTHING_ACTS,
            **state._asdict(),
            interval=s,
        )
        put(rows, np.r_[s * local : (s + 2) * local, g])
    whole = np.vstack(tables)
    return Dense(whole[:, :-1], whole[:, -1], common)


def test_elimination_gives_the_stacked_solution(small):
    """The step from a state, its cost, and the covariance at the end."""
    problem, prior, state, _ = small
    here = linear(problem, problem.weights, state)
    stacked = dense(problem, state)
    # Squares of some thousand rows.
    np.testing.assert_allclose(here.cost, stacked.b @ stacked.b, rtol=1e-10)
    stacked = stacked.with_prior(prior, state)
    factor = prior.added(here.common, state)
    g = _damped(factor, 0.0)
    x, C = stacked.solution()
    found = np.append(here.step(g).ravel(), g)
    # Weights of continuity are up to 1e13 times those of sensors, and so is rounding:
    # compared with the deviation of each, of which a hundredth never matters.
    assert np.abs((found - x) / np.sqrt(np.diag(C))).max() < 1e-2


def test_covariance_of_boundaries_and_of_the_common_unknowns(small):
    """The boundaries are the meeting one, and the last, where biases are reported."""
    problem, prior, state, _ = small
    solution = solved(problem, problem.weights, prior, state)
    assert solution.converged
    at = solution.state
    boundaries, n = at.local.shape
    _, C = dense(problem, at).with_prior(prior, at).solution()
    meeting = (boundaries - 1) // 2 * n
    here = np.r_[meeting : meeting + n, at.local.size : len(C)]
    last = np.r_[at.local.size - n : at.local.size]
    at_the_end = solution.end.covariance(solution.covariance)
    for found, place in ((solution.covariance, here), (at_the_end, last)):
        expected = C[np.ix_(place, place)]
        std = np.sqrt(np.diag(expected))
        # The information is that of a state a hundredth of a deviation away.
        np.testing.assert_allclose(np.sqrt(np.diag(found)), std, rtol=1e-3)
        correlation = found / np.outer(std, std)
        np.testing.assert_allclose(
            correlation, expected / np.outer(std, std), atol=1e-2
        )


@pytest.mark.parametrize("damping", [1e-3, 1.0, 1e3])
def test_damping_is_relative_to_the_information(damping):
    """`(R'R + damping diag(R'R)) g = R'z`."""
    factor = np.triu(np.random.default_rng(0).standard_normal((6, 6)))
    R, z = factor[:-1, :-1], factor[:-1, -1]
    N = R.T @ R
    expected = np.linalg.solve(N + damping * np.diag(np.diag(N)), R.T @ z)
    np.testing.assert_allclose(_damped(factor, damping), expected, rtol=1e-10)
    undamped = np.linalg.norm(_damped(factor, 0.0) * np.sqrt(np.diag(N)))
    assert np.linalg.norm(expected * np.sqrt(np.diag(N))) < undamped


def test_from_a_bad_start_to_the_same_solution(recording):
    """Every entry of `beta` half off: the inertia of another robot."""
    robot, shown = small_robot(), noisy(recording, 1)
    near = small_problem(robot, shown)
    far = small_problem(robot, shown, off=0.5)
    expected = solved(near.problem, near.problem.weights, near.prior, near.state)
    found = solved(far.problem, far.problem.weights, far.prior, far.state)
    assert expected.converged
    assert found.converged
    n = near.beta.size
    std = np.sqrt(np.diag(expected.covariance))[-n:]
    # Both stop within a hundredth of a deviation.
    assert np.abs((found.state.beta - expected.state.beta) / std).max() < 0.02
    assert np.abs((expected.state.beta - near.beta) / std).max() < 5


@pytest.mark.parametrize("joints", [None, {"position": 1e-3}])
@pytest.mark.parametrize("steps", [1, 20])
def test_the_cost_is_that_of_the_last_state(recording, joints, steps):
    """Less than before; encoders with noise are sensors too."""
    robot = small_robot()
    if joints:
        robot = replace(robot, sensors=declared_sensors({"joints": joints}))
    small = small_problem(robot, noisy(recording, 1), off=0.5)
    problem, prior, state, _ = small

    def cost(state: Unknowns) -> float:
        return linear(problem, problem.weights, state).cost + prior.cost(state)

    solution = solved(problem, problem.weights, prior, state, steps=steps)
    assert solution.cost < cost(state)
    # What is left of second order in a last step of a hundredth of a deviation.
    assert solution.cost == pytest.approx(cost(solution.state), rel=1e-5)
    # Every step is kept, after where the search starts.
    start, *taken = solution.convergence
    assert start.cost == pytest.approx(cost(state), rel=1e-12)
    assert np.isnan(start.size)
    assert taken[-1].cost == solution.cost
    assert solution.converged == (taken[-1].size < SMALL or solution.left < SAME)
    # Those that lower the cost to less than half do not count.
    costs = [step.cost for step in solution.convergence]
    slow = [after for before, after in pairwise(costs) if after > FALLS * before]
    assert len(slow) <= steps


def test_without_noise_the_parameters_are_exact(recording):
    small = small_problem(small_robot(), recording, off=0.2)
    problem, prior, state, beta = small
    found = solved(problem, problem.weights, prior, state).state.beta
    # Splines and RK4 at 20 Hz.
    np.testing.assert_allclose(found, beta, rtol=0, atol=1e-7 * np.abs(beta).max())


def test_equations_that_overflow_are_refused(small):
    """As those of a recording in wrong units, by the fuzzer."""
    common = small.state.common.copy()
    common[-small.beta.size :] = 1e300
    state = small.state._replace(common=common)
    with (
        np.errstate(all="ignore"),
        pytest.raises(InputError, match="overflows, so nothing can be fitted"),
    ):
        solved(small.problem, small.problem.weights, small.prior, state)


def test_equations_whose_squares_overflow_are_refused(small):
    """As those of a recording whose time jumps by decades."""
    problem, prior, state, _ = small
    here = linear(problem, problem.weights, state)
    large = here._replace(factor=1e150 * here.factor)
    with pytest.raises(InputError, match="overflows, so nothing can be fitted"):
        solved(problem, problem.weights, prior, state, here=large)


def test_a_step_that_overflows_costs_more_than_any(small):
    """Its equations may, though its cost does not: there is no way on from there."""
    problem, prior, state, _ = small
    far = state._replace(common=state.common * 1e160)
    there, cost = equations_at(problem, problem.weights, prior, far)
    assert not np.isfinite(there.factor).all()
    assert cost == np.inf
