"""Noise that lasts, against the covariance of all samples written out."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_triangular
from small_problems import (
    NOTHING_ACTS,
    Small,
    noisy,
    small_problem,
    small_recording,
    small_robot,
)
from test_solving import Dense, dense

from orbident import _core
from orbident.estimation.output_error.problem import NO_ROWS, SENSORS, linear
from orbident.estimation.output_error.sensors import TRACKERS, at_level, innovated
from orbident.estimation.output_error.solver import _damped
from orbident.robot.sensor_schema import declared_sensors

WHITE = {"position": {"std": 1e-3}, "attitude": {"angle": 1e-3}}
LASTS = {
    "position": {
        "std": 1e-3,
        "markov_std": (2e-3, 0.0, 0.0),
        "correlation_time": 0.6,
        "random_walk": (3e-4, 1e-3, 0.0),
    },
    "attitude": {"angle": 1e-3, "markov_std": 2e-3, "correlation_time": 0.2},
}


@pytest.fixture(scope="module")
def both():
    """The same recording, whose trackers have white noise or noise that lasts."""
    robot = small_robot()
    shown = noisy(small_recording(robot, 5.0), 0)
    return [
        small_problem(replace(robot, sensors=declared_sensors(declared)), shown)
        for declared in (WHITE, LASTS)
    ]


def covariance(t, std, time, walk):
    between = np.abs(t[:, None] - t)
    first = t[0] - np.median(np.diff(t))
    since = np.minimum(t[:, None], t) - first
    return std**2 * np.exp(-between / time) + walk**2 * since


def tracker_rows(small: Small, name: str) -> np.ndarray:
    """Over the white noise, as columns of the whole chain."""
    problem, _, state, _ = small
    local, chain = state.local.shape[1], state.local.size
    weights = [problem.weights.get(each, NO_ROWS) * (each == name) for each in SENSORS]
    tables = []
    for s in range(len(state.local) - 1):
        rows = _core.interval_equations(
            problem.recorded,
            weights=weights,
            coloured=problem.lasting,
            acting=NOTHING_ACTS,
            **state._asdict(),
            interval=s,
        )
        # Below them are those of continuity and of encoders.
        rows = rows[: len(rows) - 9 - 2 * local]
        table = np.zeros((len(rows), chain + state.common.size + 1))
        table[:, np.r_[s * local : (s + 2) * local, chain : table.shape[1]]] = rows
        tables.append(table)
    return np.vstack(tables)


def whole(white: Small, lasting: np.ndarray) -> Dense:
    """All rows, those of trackers over a factor of their whole covariance."""
    problem, _, state, _ = white
    others = {
        name: weight * (name not in TRACKERS)
        for name, weight in problem.weights.items()
    }
    rest = dense(problem._replace(weights=others), state)
    tables = [np.column_stack([rest.A, rest.b])]
    for name, parts in zip(TRACKERS, lasting, strict=True):
        rows, weights = tracker_rows(white, name), problem.weights[name]
        axes = np.flatnonzero(weights.any(axis=0))
        for k, axis in enumerate(axes):
            w = weights[:, axis].max()
            C = np.eye(problem.t.size) + w**2 * covariance(problem.t, *parts[axis][:3])
            L = np.linalg.cholesky(C)
            tables.append(solve_triangular(L, rows[k :: axes.size], lower=True))
    table = np.vstack(tables)
    return Dense(table[:, :-1], table[:, -1], rest.common)


def test_the_step_and_its_deviations_are_those_of_the_whole_covariance(both):
    white, lasts = both
    assert lasts.problem.lasting.any()
    prior, state = lasts.prior, lasts.state
    n = prior.std.size
    stacked = whole(white, lasts.problem.lasting).with_prior(prior, state)
    x, C = stacked.solution()
    std = np.sqrt(np.diag(C))[-n:]
    here = linear(lasts.problem, lasts.problem.weights, state)
    factor = prior.added(here.common, state)
    found = np.linalg.norm(np.linalg.inv(factor[:-1, :-1]), axis=1)
    np.testing.assert_allclose(found, std, rtol=1e-4)
    # As in test_solving.py: a hundredth of a deviation never matters.
    assert np.abs((_damped(factor, 0.0) - x[-n:]) / std).max() < 1e-2


def test_innovations_of_residuals_are_those_of_the_whole_covariance(both):
    problem = both[1].problem
    random = np.random.default_rng(0)
    residuals = {
        name: random.standard_normal(weights.shape) * (weights > 0)
        for name, weights in problem.weights.items()
    }
    level = 1.7
    weights = {name: w / level for name, w in problem.weights.items()}
    lasting = at_level(problem.lasting, problem.weights, weights)
    found = innovated(problem.t, lasting, residuals, weights, weights)
    std, time, walk, _ = problem.lasting[1, 0]
    C = covariance(problem.t, std, time, 0.0)
    C += walk**2 * (np.minimum(problem.t[:, None], problem.t) - problem.t[0])
    # All of the noise is larger, so that residuals over it are the same.
    w = problem.weights["position"][0, 0]
    L = np.linalg.cholesky(np.eye(len(C)) + w**2 * C)
    expected = solve_triangular(L, residuals["position"][:, 0], lower=True)
    np.testing.assert_allclose(found["position"][:, 0], expected, rtol=1e-9)
    np.testing.assert_array_equal(found["gyro"], residuals["gyro"])
