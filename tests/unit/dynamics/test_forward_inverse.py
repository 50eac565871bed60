"""Eqs. 9-12 as the paper writes them, by automatic differentiation of the energy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from random_robots import random_planar_robot, random_robot, random_wheels

from orbident.dynamics.equations_of_motion import (
    H_plus,
    c_plus,
    equations_of_motion,
    model_of,
    split,
)
from orbident.dynamics.forces import Wrench, generalised_forces, jacobian
from orbident.dynamics.forward_inverse import (
    accelerations,
    forward_dynamics,
    inverse_dynamics,
)
from orbident.errors import InputError
from orbident.robot.description import Wheel
from orbident.spatial.rotations import cross

PARENTS = (0, 1, 0)
ROBOT = random_robot(1, PARENTS, (2,), random_wheels(2, ("held", "free")))
Z = np.array([0.0, 0.0, 1.0])
PLANAR = random_planar_robot(1, PARENTS, (2,), (Wheel("rw", Z, 0.05),))
RANDOM = np.random.default_rng(3)
# Sums of some tens of products, and a system of some ten equations; of order 1 to 100.
ROUNDING = 1e-11


def some_state(robot):
    n = 6 + len(robot.joints) + len(robot.wheels)
    q = RANDOM.standard_normal(len(robot.joints))
    return q, RANDOM.standard_normal(n), RANDOM.standard_normal(n)


@jax.jit
def paper(model, q, v, vd):
    """The left-hand sides of Eqs. 9-12: `d/dt` along `(q' = qd, v' = vd)`."""

    def energy(q, v):
        return 0.5 * v @ H_plus(model, q) @ v

    momentum = jax.grad(energy, argnums=1)
    p, p_dot = jax.jvp(momentum, (q, v), (split(model, v).qd, vd))
    at, rate = split(model, p), split(model, p_dot)
    v_cm, w = v[:3], v[3:6]
    return jnp.concatenate(
        [
            rate.v_cm + cross(w, at.v_cm),
            rate.w + cross(w, at.w) + cross(v_cm, at.v_cm),
            rate.qd - jax.grad(energy)(q, v),
            rate.qd_rw,
        ]
    )


def test_lagranges_equations():
    model = model_of(ROBOT)
    q, v, vd = some_state(ROBOT)
    ours = jax.jit(inverse_dynamics)(model, q, v, vd)
    theirs = paper(model, q, v, vd)
    scale = np.abs(theirs).max()
    np.testing.assert_allclose(ours, theirs, atol=ROUNDING * scale)
    c = jax.jit(c_plus)(model, q, v)
    theirs = paper(model, q, v, 0 * vd)
    np.testing.assert_allclose(c, theirs, atol=ROUNDING * scale)


def test_forward_is_the_inverse_of_inverse():
    model = model_of(ROBOT)
    q, v, vd = some_state(ROBOT)
    Q = jax.jit(inverse_dynamics)(model, q, v, vd)
    found = jax.jit(forward_dynamics)(model, q, v, Q)
    np.testing.assert_allclose(found, vd, atol=ROUNDING * np.abs(vd).max())


def test_planar_robot_is_borne_by_its_plane():
    """What cannot move does not, whatever acts; the rest obeys its own equations."""
    model = model_of(PLANAR)
    q, v, Q = some_state(PLANAR)
    v[2:5] = 0.0
    vd = np.asarray(jax.jit(forward_dynamics)(model, q, v, Q))
    np.testing.assert_array_equal(vd[2:5], 0.0)
    back = np.asarray(jax.jit(inverse_dynamics)(model, q, v, vd))
    free = np.delete(np.arange(v.size), [2, 3, 4])
    np.testing.assert_allclose(back[free], Q[free], atol=ROUNDING * 10)


def test_mixed_dynamics_keeps_what_is_known():
    model = model_of(ROBOT)
    q, v, vd = some_state(ROBOT)
    _, _, Q = some_state(ROBOT)
    free = np.array([1, 1, 1, 1, 1, 1, 0, 1, 0, 1, 0.0])
    at = jax.jit(equations_of_motion)(model, q, v)
    found = np.asarray(accelerations(at, Q, vd, free))
    np.testing.assert_array_equal(found[free == 0], vd[free == 0])
    force = at.H @ found + at.c
    moved = free == 1
    np.testing.assert_allclose(force[moved], Q[moved], atol=ROUNDING * 100)


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
    for body, name in ((0, "base"), (2, "link2")):
        wrench = Wrench(name, point, force, moment)
        Q = generalised_forces(ROBOT, q, {}, {}, [wrench, wrench])
        twist = jax.jit(jacobian, static_argnums=2)(model_of(ROBOT), q, body, point) @ v
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
