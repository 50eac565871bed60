"""Eqs. 9-15: Lagrange's equations as the paper writes them, and what acts by name."""

import numpy as np
import pytest
from random_robots import random_robot, random_wheels
from reference.equations_of_motion import H_plus, lagrange

from orbident.errors import InputError
from orbident.model.equations_of_motion import (
    Wrench,
    equations_of_motion,
    generalised_forces,
    jacobian,
)

ROBOT = random_robot(1, (0, 1, 0), (2,), random_wheels(2, ("held", "free")))
RANDOM = np.random.default_rng(3)
# Sums of some tens of products, of order 1 to 100.
ROUNDING = 1e-11


def some_state(robot):
    n = 6 + len(robot.joints) + len(robot.wheels)
    q = RANDOM.standard_normal(len(robot.joints))
    return q, RANDOM.standard_normal(n), RANDOM.standard_normal(n)


def test_lagranges_equations():
    q, v, vd = some_state(ROBOT)
    H, c, _ = (part[0] for part in equations_of_motion(ROBOT, q[None], v[None]))
    np.testing.assert_allclose(H, H_plus(ROBOT, q), atol=ROUNDING)
    theirs = lagrange(ROBOT, q, v, vd)
    scale = np.abs(theirs).max()
    np.testing.assert_allclose(H @ vd + c, theirs, atol=ROUNDING * scale)
    theirs = lagrange(ROBOT, q, v, 0 * vd)
    np.testing.assert_allclose(c, theirs, atol=ROUNDING * scale)


def test_generalised_forces_by_name():
    q, _, _ = some_state(ROBOT)
    Q = generalised_forces(ROBOT, q, {"joint2": 2.0}, {"rw1": 0.3})
    expected = np.zeros(11)
    expected[[7, 9]] = 2.0, 0.3
    np.testing.assert_array_equal(Q, expected)


def test_power_of_a_wrench_is_that_of_its_body():
    """`Q v = F v_p + M w_i`, on the base and on a link."""
    q, v, _ = some_state(ROBOT)
    force, moment, point = RANDOM.standard_normal((3, 3))
    for name in ("base", "link2"):
        wrench = Wrench(name, point, force, moment)
        Q = generalised_forces(ROBOT, q, {}, {}, [wrench, wrench])
        twist = jacobian(ROBOT, q, name, point) @ v
        power = force @ twist[:3] + moment @ twist[3:]
        np.testing.assert_allclose(Q @ v, 2 * power, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("joints", "wheels", "body", "message"),
    [
        ({"joint9": 1.0}, {}, "base", "no joint 'joint9'; did you mean 'joint"),
        ({}, {"rwx": 1.0}, "base", "no wheel 'rwx'; .*known wheels: 'rw1', 'rw2'"),
        ({}, {}, "hand", "no body 'hand'; .*known bodies: 'base', 'link1'"),
    ],
)
def test_unknown_names(joints, wheels, body, message):
    wrench = Wrench(body, np.zeros(3), np.zeros(3), np.zeros(3))
    with pytest.raises(InputError, match=f"random-1: {message}"):
        generalised_forces(ROBOT, np.zeros(3), joints, wheels, [wrench])
