"""Forward dynamics and flight steps of the core, against Newton and Euler by body."""

import numpy as np
import pytest
from hypothesis import given, settings
from random_trees import SHAPES, tree_of
from reference import flight, newton_euler
from reference.runge_kutta import step

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import movable

pytestmark = pytest.mark.core

# Some tens of terms of order 1 to 1000, and a system of some fifteen equations whose
# condition is some thousands.
ROUNDING = 1e-9


def in_plane(robot, v):
    return np.where(movable(robot), v, 0.0)


@given(SHAPES)
def test_forward_dynamics_takes_the_forces(shape):
    """Any speeds known or free; back by the oracle's inverse dynamics."""
    robot, random = tree_of(**shape)
    free = np.ones(6 + len(robot.joints) + len(robot.wheels))
    free[6:] = random.random(free.size - 6) < 0.6
    free *= movable(robot)
    q = random.standard_normal((2, len(robot.joints)))
    v, Q, known = random.standard_normal((3, 2, free.size))
    v, known = in_plane(robot, v), in_plane(robot, known)
    vd, a_S = _core.forward_dynamics(core_robot(robot), q, v, Q, known, free)
    moved = free == 1
    for k in range(2):
        np.testing.assert_array_equal(vd[k, ~moved], known[k, ~moved])
        taken = newton_euler.inverse_dynamics(robot, q[k], v[k], vd[k])
        scale = 1.0 + np.abs(vd[k]).max()
        np.testing.assert_allclose(taken.Q[moved], Q[k, moved], atol=ROUNDING * scale)
        np.testing.assert_allclose(a_S[k], taken.a_S, atol=ROUNDING * scale)


@settings(max_examples=25)
@given(SHAPES)
def test_flight_steps_are_runge_kuttas(shape):
    """All laws and limits at once, and wrenches on some bodies."""
    robot, random = tree_of(**shape)
    K, W = len(robot.joints), len(robot.wheels)
    laws = flight.Laws(
        Kp=random.uniform(0.0, 1.0, K),
        Kd=random.uniform(0.0, 1.0, K),
        k=random.uniform(0.0, 1.0, W),
        speed=random.uniform(0.0, 1.0, W),
        share=random.standard_normal((W, 3)),
        kp=0.3,
        kd=0.5,
        x_WD=unit(random.standard_normal(4)),
        torque_limit=random.uniform(0.1, 1.0, W),
        speed_limit=random.uniform(0.5, 3.0, W),
    )
    bodies = random.integers(0, len(robot.bodies), 2)
    points = list(zip(bodies, random.standard_normal((2, 3)), strict=True))
    free = movable(robot).astype(float)
    vehicle = _core.Vehicle(
        core_robot(robot),
        free,
        **laws._asdict(),
        body=bodies.astype(float),
        point=np.array([p for _, p in points]),
        computed=None,
    )
    v = in_plane(robot, random.standard_normal(free.size))
    start = np.concatenate([random.standard_normal(7 + K + W), v])
    start[3:7] = unit(start[3:7])
    nodes = [
        flight.Commanded(
            q=random.standard_normal(K),
            qd=random.standard_normal(K),
            tau=random.standard_normal(K),
            tau_rw=random.standard_normal(W),
            wrenches=random.standard_normal((2, 6)),
        )
        for _ in range(3)
    ]
    rows = [
        np.concatenate(
            [x.q, x.qd, np.zeros(K), x.tau, x.tau_rw, np.zeros(10), x.wrenches.ravel()]
        )
        for x in nodes
    ]
    dt, command = np.array([0.01]), np.array([rows])
    end, seen = _core.fly(vehicle, start, dt, command, np.ones(1))

    def rate(commanded, x):
        return flight.rate(robot, laws, free, points, commanded, x)

    expected = step(rate, start, 0.01, tuple(nodes))
    expected[3:7] = unit(expected[3:7])
    slope = rate(nodes[0], start)[-free.size :]
    scale = 1.0 + np.abs(slope).max()
    np.testing.assert_allclose(end, expected, atol=ROUNDING * scale)
    np.testing.assert_allclose(seen[4][0], slope, atol=ROUNDING * scale)


def unit(x):
    return x / np.linalg.norm(x)


def test_threads_change_no_bit():
    robot, random = tree_of(5, joints=4, wheels=2, planar=False, massless=True)
    q = random.standard_normal((1000, 4))
    v, Q, vd = random.standard_normal((3, 1000, 12))
    free = np.ones(12)
    one, two = (
        _core.forward_dynamics(core_robot(robot), q, v, Q, vd, free, threads)
        for threads in (1, 2)
    )
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
