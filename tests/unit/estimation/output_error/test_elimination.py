"""Elimination along the chain from both ends, against one dense problem."""

from functools import partial

import numpy as np
import pytest
from random_robots import random_robot, random_wheels
from segments import Segment, segment_of

from orbident.estimation.output_error.problem import SENSORS
from orbident.estimation.solution import Linear

pytestmark = pytest.mark.core

ROBOT = random_robot(1, (0, 1), prismatic=(1,), wheels=random_wheels(1, ["held"]))

# Rounding of some hundred rotations, times the condition of the problem.
close = partial(np.testing.assert_allclose, rtol=1e-7, atol=1e-8)


def chain_of(intervals: int) -> Segment:
    """A chain at a state that is off by random numbers, so that nothing vanishes."""
    exact = segment_of(ROBOT, 3, rows=8 * intervals, intervals=intervals)
    random = np.random.default_rng(intervals)
    local = exact.state.local + 0.01 * random.standard_normal(exact.state.local.shape)
    local[:, :3] = 0.0
    return exact._replace(state=exact.state._replace(local=local))


def dense(chain: Segment) -> tuple[np.ndarray, np.ndarray]:
    """All equations over `[z_0 ... z_S, g]`, with a unit prior of `g`."""
    boundaries, L = chain.state.local.shape
    G, size = chain.state.common.size, chain.state.local.size
    first = np.zeros((L, size + G + 1))
    first[:, :L], first[:, -1] = np.eye(L), -chain.state.local[0]
    prior = np.zeros((G, size + G + 1))
    prior[:, size:-1] = np.eye(G)
    tables = [first, prior]
    for s in range(boundaries - 1):
        rows = chain.equations(*SENSORS, interval=s)
        table = np.zeros((len(rows), size + G + 1))
        table[:, np.r_[s * L : (s + 2) * L, size : size + G + 1]] = rows
        tables.append(table)
    whole = np.vstack(tables)
    return whole[:, :-1], whole[:, -1]


def common_of(found: Linear) -> np.ndarray:
    """`g` with the unit prior."""
    R = found.common
    n = len(R) - 1
    return np.linalg.solve(R[:n, :n].T @ R[:n, :n] + np.eye(n), R[:n, :n].T @ R[:n, -1])


@pytest.mark.parametrize("intervals", [1, 2, 3, 7])
def test_the_chain_gives_what_the_dense_problem_gives(intervals):
    chain = chain_of(intervals)
    A, b = dense(chain)
    x, *_ = np.linalg.lstsq(A, b)
    size = chain.state.local.size
    found = chain.eliminated()
    assert len(found.links) == intervals
    g = common_of(found)
    close(g, x[size:])
    close(found.step(g).ravel(), x[:size])


def test_what_is_left_is_the_residual():
    """The last number of the factor, where no prior of `g` stands in the way."""
    chain = chain_of(5)
    A, b = dense(chain)
    size, G = chain.state.local.size, chain.state.common.size
    L = chain.state.local.shape[1]
    free = np.r_[0:L, L + G : len(A)]
    x, *_ = np.linalg.lstsq(A[free], b[free])
    left = np.linalg.norm(b[free] - A[free] @ x)
    np.testing.assert_allclose(abs(chain.eliminated().factor[-1, -1]), left, rtol=1e-9)
    assert size + G == A.shape[1]


def test_boundaries_for_any_common_unknowns():
    """The least-squares `z` where `g` is given."""
    chain = chain_of(4)
    A, b = dense(chain)
    size = chain.state.local.size
    g = np.random.default_rng(0).standard_normal(chain.state.common.size)
    expected, *_ = np.linalg.lstsq(A[:, :size], b - A[:, size:] @ g)
    close(chain.eliminated().step(g).ravel(), expected)


def test_covariance_of_the_last_boundary():
    chain = chain_of(5)
    A, _ = dense(chain)
    C = np.linalg.inv(A.T @ A)
    boundaries, L = chain.state.local.shape
    meeting, size = (boundaries - 1) // 2 * L, chain.state.local.size
    place = np.r_[meeting : meeting + L, size : len(C)]
    found = chain.eliminated().at_the_end().covariance(C[np.ix_(place, place)])
    close(found, C[size - L : size, size - L : size])


def test_two_threads_give_the_same_bits_as_one():
    chain = chain_of(6)
    one, two = chain.eliminated(1), chain.eliminated(2)
    assert one.cost == two.cost
    np.testing.assert_array_equal(one.factor, two.factor)
    np.testing.assert_array_equal(one.links, two.links)
    for name in SENSORS:
        np.testing.assert_array_equal(one.residuals[name], two.residuals[name])
