"""Forward and inverse dynamics: Eqs. 9-13 as the paper writes them, and each other."""

import numpy as np
from random_robots import random_planar_robot, random_robot, random_wheels

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import equations_of_motion, movable
from orbident.robot.description import Robot, Wheel

PARENTS = (0, 1, 0)
ROBOT = random_robot(1, PARENTS, (2,), random_wheels(2, ("held", "free")))
Z = np.array([0.0, 0.0, 1.0])
PLANAR = random_planar_robot(1, PARENTS, (2,), (Wheel("rw", Z, 0.05),))
RANDOM = np.random.default_rng(3)
# Sums of some tens of products, and a system of some ten equations; of order 1 to 100.
ROUNDING = 1e-11


def some_state(robot):
    n = 6 + len(robot.joints) + len(robot.wheels)
    q = RANDOM.standard_normal((1, len(robot.joints)))
    return q, RANDOM.standard_normal((1, n)), RANDOM.standard_normal((1, n))


def forward_dynamics(robot, q, v, Q):
    """`v' = H+^-1 (Q - c+)`; in the plane, of what can move."""
    free = movable(robot).astype(float)
    core = core_robot(robot)
    return _core.forward_dynamics(core, q, v, Q, np.zeros_like(v), free)[0]


def inverse_dynamics(robot, q, v, vd):
    """`Q = H+ v' + c+`: what it takes; in the plane, with what the plane bears."""
    at = equations_of_motion(robot, q, v)
    return np.einsum("nij,nj->ni", at.H, vd) + at.c


def energy(robot: Robot, q: np.ndarray, v: np.ndarray) -> float:
    return float(0.5 * v @ momentum(robot, q, v))


def momentum(robot: Robot, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return equations_of_motion(robot, q[None], v[None]).H[0] @ v


def derivative(function, h: float = 1e-3):
    """The derivative at zero by the central formula of sixth order: to h^6, and
    rounding over h."""
    weights = np.array([45, -9, 1]) / (60 * h)
    return sum(
        weight * (function(k * h) - function(-k * h))
        for k, weight in enumerate(weights, start=1)
    )


def paper(robot: Robot, q: np.ndarray, v: np.ndarray, vd: np.ndarray) -> np.ndarray:
    """The left-hand sides of Eqs. 9-12: `d/dt` along `(q' = qd, v' = vd)`."""
    joints = len(robot.joints)
    ends = [3, 6, 6 + joints]
    qd = v[6 : 6 + joints]
    at = np.split(momentum(robot, q, v), ends)
    rate = np.split(derivative(lambda x: momentum(robot, q + x * qd, v + x * vd)), ends)
    slope = [
        derivative(lambda x, unit=unit: energy(robot, q + x * unit, v))
        for unit in np.eye(joints)
    ]
    v_cm, w = v[:3], v[3:6]
    return np.concatenate(
        [
            rate[0] + np.cross(w, at[0]),
            rate[1] + np.cross(w, at[1]) + np.cross(v_cm, at[0]),
            rate[2] - slope,
            rate[3],
        ]
    )


def test_lagranges_equations():
    q, v, vd = some_state(ROBOT)
    ours = inverse_dynamics(ROBOT, q, v, vd)[0]
    theirs = paper(ROBOT, q[0], v[0], vd[0])
    # Rounding over the difference's step of 1e-3.
    np.testing.assert_allclose(ours, theirs, atol=ROUNDING * np.abs(theirs).max())


def test_forward_is_the_inverse_of_inverse():
    q, v, vd = some_state(ROBOT)
    Q = inverse_dynamics(ROBOT, q, v, vd)
    found = forward_dynamics(ROBOT, q, v, Q)
    np.testing.assert_allclose(found, vd, atol=ROUNDING * np.abs(vd).max())


def test_planar_robot_is_borne_by_its_plane():
    """What cannot move does not, whatever acts; the rest obeys its own equations."""
    q, v, Q = some_state(PLANAR)
    v[0, 2:5] = 0.0
    vd = forward_dynamics(PLANAR, q, v, Q)
    np.testing.assert_array_equal(vd[0, 2:5], 0.0)
    back = inverse_dynamics(PLANAR, q, v, vd)
    free = np.delete(np.arange(v.size), [2, 3, 4])
    np.testing.assert_allclose(back[0, free], Q[0, free], atol=ROUNDING * 10)


def test_mixed_dynamics_keeps_what_is_known():
    q, v, vd = some_state(ROBOT)
    _, _, Q = some_state(ROBOT)
    free = np.array([1, 1, 1, 1, 1, 1, 0, 1, 0, 1, 0.0])
    found, _ = _core.forward_dynamics(core_robot(ROBOT), q, v, Q, vd, free)
    np.testing.assert_array_equal(found[0, free == 0], vd[0, free == 0])
    force = inverse_dynamics(ROBOT, q, v, found)
    moved = free == 1
    np.testing.assert_allclose(force[0, moved], Q[0, moved], atol=ROUNDING * 100)
