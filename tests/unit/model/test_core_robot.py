import numpy as np
from random_robots import random_robot, random_wheels

from orbident.model.core_robot import wheels_of


def test_columns_of_A_rw_are_axes_times_inertias():
    """Eq. 5."""
    robot = random_robot(0, (), wheels=random_wheels(1, ("held", "free", "held")))
    wheels = wheels_of(robot)
    for k, wheel in enumerate(robot.wheels):
        np.testing.assert_array_equal(wheels.axes[:, k], wheel.axis)
        np.testing.assert_array_equal(wheels.A_rw[:, k], wheel.axis * wheel.inertia)
    np.testing.assert_array_equal(wheels.free, [0, 1, 0])


def test_no_wheels_have_no_momentum():
    wheels = wheels_of(random_robot(0, ()))
    assert wheels.A_rw.shape == (3, 0)
    np.testing.assert_array_equal(wheels.A_rw @ np.zeros(0), np.zeros(3))
