from dataclasses import replace

import jax
import numpy as np
import pytest
from random_robots import random_quaternion, random_robot, random_wheels
from scipy.spatial.transform import Rotation

from orbident.dynamics.control_laws import (
    ComputedTorque,
    Hold,
    JointCommand,
    JointPD,
    Now,
    WheelSpeed,
    attitude_hold,
)
from orbident.dynamics.equations_of_motion import Speeds, model_of
from orbident.dynamics.forward_inverse import forward_dynamics
from orbident.robot.description import Wheel

X, Y, Z = np.eye(3)
RANDOM = np.random.default_rng(1)


def now(**values) -> Now:
    """Two joints and three wheels in some state."""
    q, qd, q_d, qd_d, qdd_d = RANDOM.standard_normal((5, 2))
    v_cm, w, qd_rw = RANDOM.standard_normal((3, 3))
    return Now(
        t=np.array(0.0),
        q=q,
        x_WB=random_quaternion(RANDOM),
        speeds=Speeds(v_cm, w, qd, qd_rw),
        command=JointCommand(q_d, qd_d, qdd_d),
    )._replace(**values)


def robot_with(*axes: np.ndarray):
    wheels = [Wheel(f"rw{k}", axis, 0.01) for k, axis in enumerate(axes)]
    return random_robot(1, (0, 1), wheels=wheels)


def test_hold_stays():
    q, qd, qdd = Hold(np.array([1.0, 2.0])).at(np.array([0.0, 5.0, 9.0]))
    np.testing.assert_array_equal(q, [[1, 2]] * 3)
    np.testing.assert_array_equal([qd, qdd], np.zeros((2, 3, 2)))


def test_joint_pd():
    state = now(
        q=np.array([1.0, 2.0]),
        speeds=now().speeds._replace(qd=np.array([0.1, 0.2])),
        command=JointCommand(np.array([1.5, 2.0]), np.zeros(2), np.zeros(2)),
    )
    law = JointPD(Kp=np.array([10.0, 20.0]), Kd=np.array([1.0, 2.0]))
    # Four products of decimal numbers.
    np.testing.assert_allclose(law(state), [5.0 - 0.1, -0.4], rtol=1e-14)


def test_wheel_speed():
    state = now(speeds=now().speeds._replace(qd_rw=np.array([0.0, 10.0, -5.0])))
    law = WheelSpeed(k=np.full(3, 0.1), speed=np.array([5.0, 5.0, 5.0]))
    np.testing.assert_allclose(law(state), [0.5, -0.5, 1.0], rtol=1e-14)


@pytest.mark.parametrize("sign", [1, -1])
def test_attitude_hold_turns_the_base_back(sign):
    """The moment on the base is `-kp e - kd w`, with e from SciPy."""
    x_WD, x_WB = random_quaternion(RANDOM), sign * random_quaternion(RANDOM)
    state = now(x_WB=x_WB)
    law = attitude_hold(robot_with(X, Y, Z), 0.3, 0.7, x_WD)
    R_DB = Rotation.from_quat(x_WD).inv() * Rotation.from_quat(x_WB)
    turn = R_DB.as_rotvec()
    angle = np.linalg.norm(turn)
    e = 2 * np.sin(angle / 2) * turn / angle
    # The rotors take up what the base is given; quaternions to rounding.
    np.testing.assert_allclose(law(state), 0.3 * e + 0.7 * state.speeds.w, atol=1e-14)


def test_attitude_hold_with_more_wheels_than_axes():
    axes = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]) / np.sqrt(3)
    x_WD, state = random_quaternion(RANDOM), now()
    three = attitude_hold(robot_with(X, Y, Z), 0.3, 0.7, x_WD)(state)
    four = attitude_hold(robot_with(*axes), 0.3, 0.7, x_WD)(state)
    np.testing.assert_allclose(axes.T @ four, three, atol=1e-14)


def test_one_wheel_holds_about_its_own_axis():
    x_WD, state = random_quaternion(RANDOM), now()
    three = attitude_hold(robot_with(X, Y, Z), 0.3, 0.7, x_WD)(state)
    one = attitude_hold(robot_with(Y), 0.3, 0.7, x_WD)(state)
    np.testing.assert_allclose(one, three[1:2], atol=1e-14)


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_computed_torque_gives_the_accelerations_it_says(motion):
    """By the forward dynamics, with the wheels' motors off."""
    robot = random_robot(2, (0, 1), (1,), random_wheels(1, ("free",) * 3))
    model = model_of(replace(robot, motion=motion))
    law = ComputedTorque(model, kp=np.full(2, 4.0), kd=np.full(2, 3.0))
    state = now()
    v = np.concatenate(state.speeds)
    if motion == "planar":
        v[2:5] = 0.0
        state = state._replace(speeds=Speeds(v[:3], v[3:6], v[6:8], v[8:]))
    tau = jax.jit(lambda law, now: law(now))(law, state)
    Q = np.concatenate([np.zeros(6), tau, np.zeros(3)])
    vd = np.asarray(jax.jit(forward_dynamics)(model, state.q, v, Q))
    q_d, qd_d, qdd_d = state.command
    expected = qdd_d + 3.0 * (qd_d - v[6:8]) + 4.0 * (q_d - state.q)
    # Two solutions of a 9x9 system in float64.
    np.testing.assert_allclose(vd[6:8], expected, rtol=1e-11)
