"""What each law asks for, as the first sample of a flight shows it."""

from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_quaternion, random_robot, random_wheels
from scipy.spatial.transform import Rotation

from orbident.robot.description import Robot, Wheel
from orbident.simulation.flight import (
    AttitudeHold,
    ComputedTorque,
    FlyingState,
    FreeFlying,
    Hold,
    JointLaw,
    JointPD,
    OpenLoop,
    WheelLaw,
    WheelSpeed,
)
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.studies.control import Slew

X, Y, Z = np.eye(3)
RANDOM = np.random.default_rng(1)
NOTHING = OpenLoop(lambda t: np.zeros((t.size, 2)))
# A rotor's torque is shown as `I_rw (a.w_dot + qdd_rw)`.
ROUNDING = 1e-13


class Given:
    """A command with any positions, rates and accelerations."""

    def __init__(self, q, qd, qdd):
        self.given = q, qd, qdd

    def at(self, t):
        return tuple(np.tile(x, (t.size, 1)) for x in self.given)


def state(wheels: int = 3, **base) -> FlyingState:
    """Two joints and some wheels that all move."""
    q, qd = RANDOM.standard_normal((2, 2))
    w, v_S, r_S = RANDOM.standard_normal((3, 3))
    moving = BaseState(
        w, random_quaternion(RANDOM), v_S, RANDOM.standard_normal(wheels)
    )
    return FlyingState(moving._replace(**base), q, qd, r_S, np.zeros(wheels))


def robot_with(*axes: np.ndarray) -> Robot:
    wheels = [Wheel(f"rw{k}", axis, 0.01) for k, axis in enumerate(axes)]
    return random_robot(1, (0, 1), wheels=wheels)


def asked(
    robot: Robot,
    start: FlyingState,
    joints: JointLaw,
    wheels: WheelLaw | None = None,
    command=None,
) -> FreeFlying:
    """The one sample."""
    command = command or Hold(np.zeros(2))
    return free_flying(robot, np.zeros(1), start, command, joints, wheels)


def test_hold_stays():
    q, qd, qdd = Hold(np.array([1.0, 2.0])).at(np.array([0.0, 5.0, 9.0]))
    np.testing.assert_array_equal(q, [[1, 2]] * 3)
    np.testing.assert_array_equal([qd, qdd], np.zeros((2, 3, 2)))


def test_joint_pd():
    start = state()._replace(q=np.array([1.0, 2.0]), qd=np.array([0.1, 0.2]))
    command = Given(np.array([1.5, 2.0]), np.zeros(2), np.zeros(2))
    law = JointPD(Kp=np.array([10.0, 20.0]), Kd=np.array([1.0, 2.0]))
    run = asked(robot_with(X, Y, Z), start, law, command=command)
    # Four products of decimal numbers.
    np.testing.assert_allclose(run.tau[0], [5.0 - 0.1, -0.4], rtol=1e-14)


def test_wheel_speed():
    start = state(wheel_speed=np.array([0.0, 10.0, -5.0]))
    law = WheelSpeed(k=np.full(3, 0.1), speed=np.array([5.0, 5.0, 5.0]))
    run = asked(robot_with(X, Y, Z), start, NOTHING, law)
    np.testing.assert_allclose(run.tau_rw[0], [0.5, -0.5, 1.0], atol=ROUNDING)


def test_open_loop_torques_are_those_of_the_time():
    law = OpenLoop(lambda t: np.multiply.outer(t + 1.0, [2.0, -3.0]))
    run = asked(robot_with(), state(0), law)
    np.testing.assert_array_equal(run.tau[0], [2.0, -3.0])


@pytest.mark.parametrize("sign", [1, -1])
def test_attitude_hold_turns_the_base_back(sign):
    """The moment on the base is `-kp e - kd w`, with e from SciPy."""
    x_WD, x_WB = random_quaternion(RANDOM), sign * random_quaternion(RANDOM)
    robot, start = robot_with(X, Y, Z), state(attitude=x_WB)
    run = asked(robot, start, NOTHING, AttitudeHold(0.3, 0.7, x_WD))
    R_DB = Rotation.from_quat(x_WD).inv() * Rotation.from_quat(x_WB)
    turn = R_DB.as_rotvec()
    angle = np.linalg.norm(turn)
    e = 2 * np.sin(angle / 2) * turn / angle
    # The rotors take up what the base is given.
    expected = 0.3 * e + 0.7 * start.base.angular_velocity
    np.testing.assert_allclose(run.tau_rw[0], expected, atol=ROUNDING)


def test_attitude_hold_with_more_wheels_than_axes():
    axes = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]) / np.sqrt(3)
    x_WD, start = random_quaternion(RANDOM), state()
    with_four = start._replace(
        base=start.base._replace(wheel_speed=np.zeros(4)), q_rw=np.zeros(4)
    )
    three, four = (
        asked(robot, start, NOTHING, AttitudeHold(0.3, 0.7, x_WD)).tau_rw[0]
        for robot, start in (
            (robot_with(X, Y, Z), start),
            (robot_with(*axes), with_four),
        )
    )
    np.testing.assert_allclose(axes.T @ four, three, atol=ROUNDING)


def test_one_wheel_holds_about_its_own_axis():
    x_WD, start = random_quaternion(RANDOM), state()
    with_one = start._replace(
        base=start.base._replace(wheel_speed=np.zeros(1)), q_rw=np.zeros(1)
    )
    three, one = (
        asked(robot, start, NOTHING, AttitudeHold(0.3, 0.7, x_WD)).tau_rw[0]
        for robot, start in ((robot_with(X, Y, Z), start), (robot_with(Y), with_one))
    )
    np.testing.assert_allclose(one, three[1:2], atol=ROUNDING)


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_computed_torque_gives_the_accelerations_it_says(motion):
    """`y'' = y_d'' + kd e' + kp e` of joints and base, at an attitude without error."""
    wheels = random_wheels(1, ("free",) * 3)
    start = state()
    if motion == "planar":
        wheels = (Wheel("rw", Z, 0.05),)
        level = np.array([0.0, 0.0, 0.6, 0.8])
        in_plane = start.base._replace(
            angular_velocity=0.4 * Z, attitude=level, wheel_speed=np.ones(1)
        )
        in_plane = in_plane._replace(velocity=np.array([0.1, -0.2, 0.0]))
        start = start._replace(base=in_plane, q_rw=np.zeros(1))
    joints = replace(random_robot(2, (0, 1), (1,), wheels), motion=motion)
    q_d, qd_d, qdd_d = RANDOM.standard_normal((3, 2))
    slew = Slew(start.base.attitude, Z, 0.0, 1.0)
    law = ComputedTorque(joints, slew, kp=4.0, kd=3.0)
    run = asked(joints, start, law, law, Given(q_d, qd_d, qdd_d))
    expected = qdd_d + 3.0 * (qd_d - start.qd) + 4.0 * (q_d - start.q)
    # Two solutions of a 9x9 system in float64.
    np.testing.assert_allclose(run.qdd[0], expected, rtol=1e-11)
    slowed = -3.0 * start.base.angular_velocity
    np.testing.assert_allclose(run.w_dot[0], slowed, atol=1e-11)


def test_computed_torque_turns_the_base_to_its_attitude():
    """`w' = w_d' - kd (w - w_d) - kp e`, a small rotation e from the wanted one."""
    robot = random_robot(2, (0, 1), (1,), random_wheels(1, ("free",) * 3))
    start = state(angular_velocity=np.zeros(3))
    e = 1e-4 * np.array([1.0, -2.0, 3.0])
    wanted = Rotation.from_quat(start.base.attitude) * Rotation.from_rotvec(-e)
    law = ComputedTorque(robot, Slew(wanted.as_quat(), Z, 0.0, 1.0), kp=4.0, kd=3.0)
    run = asked(robot, start, law, law)
    # Of third order in e.
    np.testing.assert_allclose(run.w_dot[0], -4.0 * e, atol=1e-10)
