from dataclasses import replace

import numpy as np
import pytest
from random_robots import (
    random_planar_robot,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)

from orbident.errors import InputError
from orbident.simulation.free_floating import BaseState, free_floating

PARENTS = (0, 1, 0)
ROBOT = random_robot(1, PARENTS, wheels=random_wheels(1, ("held", "free")))
PLANAR = random_planar_robot(1, PARENTS)
SWING = random_swing(2, len(PARENTS))
START = random_start(3, ROBOT)
T = np.linspace(0.0, 3.0, 31)


def at_rest(wheels: int) -> BaseState:
    zero = np.zeros(3)
    return BaseState(zero, np.array([0.0, 0.0, 0.0, 1.0]), zero, np.zeros(wheels))


class Still:
    """Joints that keep their angles."""

    def at(self, t):
        q = np.full((t.size, len(PARENTS)), 0.3)
        return q, 0 * q, 0 * q


class Slowed:
    """The same path at another speed."""

    def __init__(self, motion, factor):
        self.motion, self.factor = motion, factor

    def at(self, t):
        q, qd, qdd = self.motion.at(t * self.factor)
        return q, qd * self.factor, qdd * self.factor**2


def test_nothing_moves_at_rest():
    ours = free_floating(ROBOT, Still(), T, at_rest(2))
    for history in (ours.w, ours.r_S, ours.v_S, ours.qd_rw, ours.h_cm):
        np.testing.assert_array_equal(history, 0.0)
    np.testing.assert_array_equal(ours.attitude, np.tile([0, 0, 0, 1.0], (T.size, 1)))


def test_shapes_and_what_the_joints_did():
    ours = free_floating(ROBOT, SWING, T, START)
    q, qd, _ = SWING.at(T)
    np.testing.assert_array_equal(ours.t, T)
    np.testing.assert_array_equal(ours.q, q)
    np.testing.assert_array_equal(ours.qd, qd)
    assert ours.attitude.shape == (31, 4)
    assert ours.w.shape == ours.r_S.shape == ours.v_S.shape == (31, 3)
    assert ours.qd_rw.shape == (31, 2)


def test_samples_may_be_uneven():
    """The same motion at other times."""
    even = free_floating(ROBOT, SWING, T, START, 1e-11)
    chosen = [0, 1, 3, 7, 8, 15, 20, 24, 30]
    uneven = free_floating(ROBOT, SWING, T[chosen], START, 1e-11)
    # Twice the tolerance of the attitude; rates and positions of the order of 1.
    np.testing.assert_allclose(uneven.attitude, even.attitude[chosen], atol=2e-11)
    np.testing.assert_allclose(uneven.w, even.w[chosen], atol=2e-10)
    np.testing.assert_allclose(uneven.r_S, even.r_S[chosen], atol=2e-10)


def test_one_sample_is_the_start():
    ours = free_floating(ROBOT, SWING, T[:1], START)
    np.testing.assert_allclose(ours.w[0], START.angular_velocity, atol=1e-14)
    # Normalised or not.
    assert ours.attitude_error < 1e-15


def test_more_samples_show_the_same_motion():
    """Every 100th of 3001 samples, which several threads share."""
    fine = free_floating(ROBOT, SWING, np.linspace(0.0, 3.0, 3001), START, 1e-11)
    coarse = free_floating(ROBOT, SWING, T, START, 1e-11)
    np.testing.assert_allclose(fine.attitude[::100], coarse.attitude, atol=2e-11)
    np.testing.assert_allclose(fine.r_S[::100], coarse.r_S, atol=2e-10)


def test_a_later_start_of_the_clock_changes_nothing():
    class Later:
        def at(self, t):
            return SWING.at(t - 1000.0)

    now = free_floating(ROBOT, SWING, T, START)
    later = free_floating(ROBOT, Later(), T + 1000.0, START)
    # Times near 1000 s are rounded to 1e-13 s.
    np.testing.assert_allclose(later.attitude, now.attitude, atol=1e-11)
    np.testing.assert_allclose(later.r_S, now.r_S, atol=1e-11)


def test_without_momentum_the_attitude_depends_on_the_path_alone():
    """A nonholonomic constraint: the same joint path at half speed."""
    # Joints start at the end of a swing, where they stand still.
    motion = SWING._replace(phase=np.full(len(PARENTS), np.pi / 2))
    start = at_rest(0)
    robot = replace(ROBOT, wheels=())
    full = free_floating(robot, motion, T, start, 1e-11)
    half = free_floating(robot, Slowed(motion, 0.5), 2 * T, start, 1e-11)
    # The start's rates are zero to rounding: 1e-16 of momentum.
    np.testing.assert_allclose(half.attitude, full.attitude, atol=2e-11)
    np.testing.assert_allclose(half.w, full.w / 2, atol=2e-10)
    assert np.abs(full.attitude[-1, :3]).max() > 0.01


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("angular_velocity", [0.1, 0.0, 0.2]),
        ("attitude", [0.6, 0.0, 0.0, 0.8]),
        ("velocity", [0.0, 0.0, 0.1]),
    ],
)
def test_planar_robot_must_start_in_its_plane(name, value):
    start = at_rest(0)._replace(**{name: np.array(value)})
    with pytest.raises(InputError, match=f"initial {name} .* leaves the plane"):
        free_floating(PLANAR, SWING, T, start)


def test_too_few_samples_for_a_fast_base():
    start = at_rest(2)._replace(angular_velocity=np.array([300.0, 200.0, 100.0]))
    with pytest.raises(InputError, match="the base turns too fast"):
        free_floating(ROBOT, SWING, np.array([0.0, 10.0, 20.0]), start)
