import numpy as np
import pytest
from random_robots import random_quaternion

from orbident import _core
from orbident.errors import InputError
from orbident.model.rotations import rotation_angle
from orbident.simulation.free_floating import (
    MOST_SUBSTEPS,
    RateLaw,
    float_attitude,
    rate_law,
    step_nodes,
)

Z = np.array([0.0, 0.0, 1.0])
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def spinning(t, rate=1.0):
    """The law of a body that turns about z at this rate whatever its attitude."""
    return RateLaw(np.zeros((t.size, 3, 3)), np.tile(-rate * Z, (t.size, 1)))


def turned(angle):
    return np.array([0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)])


def test_step_nodes_are_ends_and_middles():
    t = np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(step_nodes(t, 1), [0, 0.5, 1, 2, 3])
    np.testing.assert_allclose(
        step_nodes(t, 2), [0, 0.25, 0.5, 0.75, 1, 1.5, 2, 2.5, 3]
    )


def test_step_nodes_hit_the_samples():
    """Uneven samples, any number of steps: a sample every `2 substeps` nodes."""
    t = np.cumsum(np.random.default_rng(0).uniform(0.01, 1.0, 30))
    for substeps in (1, 2, 3, 64):
        np.testing.assert_array_equal(step_nodes(t, substeps)[:: 2 * substeps], t)


def test_rate_law_solves_for_the_rate():
    random = np.random.default_rng(0)
    root = random.standard_normal((5, 3, 3))
    D = root @ root.transpose(0, 2, 1) + np.eye(3)
    w, h_moving = random.standard_normal((2, 5, 3))
    law = rate_law(D, h_moving, planar=False)
    h_B = np.einsum("nij,nj->ni", D, w) + h_moving
    found = np.einsum("nij,nj->ni", law.E, h_B) - law.b
    # The conditions of D are some tens.
    np.testing.assert_allclose(found, w, atol=1e-13)


def test_planar_rate_law_is_its_z_row():
    D = np.array([[[2.0, 0.1, 0.3], [0.1, 3.0, 0.2], [0.3, 0.2, 4.0]]])
    law = rate_law(D, np.array([[5.0, 6.0, 8.0]]), planar=True)
    np.testing.assert_array_equal(law.E[0], np.diag([0, 0, 0.25]))
    np.testing.assert_array_equal(law.b, [[0, 0, 2]])


@pytest.mark.parametrize("steps", [1, 2, 1000])
def test_steps_follow_each_other(steps):
    t = np.linspace(0.0, 2.0, steps + 1)
    nodes = step_nodes(t, 2)
    law, no_momentum = spinning(nodes), np.zeros((nodes.size, 3))
    x_WB, _ = _core.attitudes(*law, no_momentum, LEVEL, t, 2)
    assert x_WB.shape == (steps + 1, 4)
    # RK4: step^5 / 120 in each half angle, and a rounding a step.
    tolerance = 2.0 * (0.5 / steps) ** 4 + 2e-16 * steps
    for time, x in zip(t, x_WB, strict=True):
        assert np.linalg.norm(x - turned(time)) < tolerance


def test_quaternions_stay_of_unit_norm():
    t = np.linspace(0.0, 60.0, 300)
    nodes = step_nodes(t, 2)
    law, no_momentum = spinning(nodes, rate=3.0), np.zeros((nodes.size, 3))
    start = random_quaternion(np.random.default_rng(0))
    x_WB, _ = _core.attitudes(*law, no_momentum, start, t, 2)
    # Normalised in every step.
    np.testing.assert_allclose(np.linalg.norm(x_WB, axis=1), 1.0, rtol=1e-15)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_steps_are_halved_until_the_error_is_small(tolerance):
    t = np.linspace(0.0, 10.0, 41)
    x_WB, law, error, _ = float_attitude(spinning, t, np.zeros(3), LEVEL, tolerance)
    expected = np.array([turned(time) for time in t])
    true = float(np.max(rotation_angle(x_WB, expected)))
    assert error <= tolerance
    # Richardson's estimate of a constant rate is right to leading order.
    assert error == pytest.approx(true, rel=0.1)
    assert law.E.shape == (41, 3, 3)
    assert law.b.shape == (41, 3)


def test_fewer_steps_for_a_wider_tolerance():
    t = np.linspace(0.0, 10.0, 41)
    counts = [
        float_attitude(spinning, t, np.zeros(3), LEVEL, tolerance)[-1]
        for tolerance in (1e-2, 1e-6, 1e-10)
    ]
    assert counts == sorted(set(counts))


def test_too_fast_a_base_says_what_to_do():
    t = np.linspace(0.0, 100.0, 3)
    with pytest.raises(InputError, match=r"50 s apart.*sample faster"):
        float_attitude(lambda t: spinning(t, rate=100.0), t, np.zeros(3), LEVEL, 1e-9)


def test_a_motion_that_overflows_is_refused():
    t = np.linspace(0.0, 1.0, 3)
    with pytest.raises(InputError, match="turns too fast"):
        float_attitude(lambda t: spinning(t, rate=1e200), t, np.zeros(3), LEVEL, 1e-9)


def test_the_most_substeps_are_a_power_of_two_times_the_first():
    """Steps are doubled from 2: another limit would never be met."""
    assert MOST_SUBSTEPS & (MOST_SUBSTEPS - 1) == 0
    assert MOST_SUBSTEPS >= 2
