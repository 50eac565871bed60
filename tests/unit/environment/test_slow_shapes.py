"""What changes slowly is a Gaussian process, made of shapes that are independent."""

import numpy as np
import pytest
from small_problems import at_rest, small_robot, small_robot_in_space

from orbident.environment.torques_and_forces import SWINGS, TIMES, slow_shapes
from orbident.environment.worlds import SHORTEST
from orbident.robot.may_act import MayAct

GROUP = "slow_torque"


def shapes_of(t: np.ndarray, shortest: float | None) -> np.ndarray:
    allowed = {GROUP: MayAct(1.0, shortest)}
    return slow_shapes(at_rest(small_robot(), t, allowed), GROUP)


def covariance(t: np.ndarray, lasts: float) -> np.ndarray:
    return np.exp(-(((t[:, None] - t) / lasts) ** 2) / 2)


@pytest.mark.parametrize("shortest", [4.0, 6.0, 30.0, 1000.0])
def test_their_covariance_is_that_stated(shortest: float):
    """Between the times at which it was decomposed, too, and wherever time starts."""
    t = 7.0 + np.linspace(0.0, 15.0, 313)
    shapes = shapes_of(t, shortest)
    expected = covariance(t, shortest / np.pi)
    np.testing.assert_allclose(shapes @ shapes.T, expected, atol=1e-4)


def test_they_are_independent():
    """Orthogonal over the recording, the largest first; none is larger than all."""
    t = np.linspace(0.0, 20.0, TIMES)
    shapes = shapes_of(t, 6.0)
    products = shapes.T @ shapes
    sizes = np.diag(products)
    np.testing.assert_allclose(products, np.diag(sizes), atol=1e-9 * sizes[0])
    assert np.all(np.diff(sizes) < 0)
    assert np.sum(sizes) == pytest.approx(t.size, rel=1e-4)


def test_at_its_shortest_time_it_hardly_swings():
    """The power of a swing is `exp(-2 (d / T)^2)` of that of what stays, `d` the
    shortest time and `T` its period."""
    d = 6.0
    t = np.arange(-40.0, 40.0, 0.05)
    process = np.exp(-((t * np.pi / d) ** 2) / 2)

    def power(period: float) -> float:
        return float(np.sum(process * np.cos(2 * np.pi * t / period)))

    assert power(d) / power(np.inf) == pytest.approx(np.exp(-2), rel=1e-6)


def test_a_long_recording_has_no_more_shapes():
    """Ten hours are followed by as many as half a minute: what is faster is a walk."""
    short, long = (shapes_of(np.linspace(0.0, T, 2001), 6.0) for T in (24.0, 36000.0))
    assert short.shape[1] <= long.shape[1] <= 2.5 * SWINGS
    lasts = 36000.0 / SWINGS
    t = np.linspace(0.0, 36000.0, 2001)
    np.testing.assert_allclose(long @ long.T, covariance(t, lasts), atol=1e-4)


@pytest.mark.parametrize("robot", [small_robot(), small_robot_in_space()])
def test_the_world_says_how_slowly(robot):
    t = np.linspace(0.0, 20.0, 101)
    world = "table" if robot.motion == "planar" else "space"
    silent = slow_shapes(at_rest(robot, t), GROUP)
    np.testing.assert_array_equal(silent, shapes_of(t, SHORTEST[world]))
