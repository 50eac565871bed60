from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from random_robots import random_robot, random_start, random_swing, random_wheels
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.model.rotations import rotation_angle
from orbident.robot.description import Robot, Wheel
from orbident.robot.robot_file import load_robot
from orbident.simulation.flight import (
    AttitudeHold,
    ComputedTorque,
    FreeFlying,
    Hold,
    JointPD,
    OpenLoop,
    WheelLimits,
    WheelSpeed,
    standing,
)
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse
from orbident.trajectories.environment import Environment

CEPHEUS = load_robot("cepheus-like")
PARENTS = (0, 1)
ROBOT = random_robot(1, PARENTS, (1,), random_wheels(1, ("held", "free")))
START = standing(random_start(3, ROBOT), np.array([0.2, -0.1]))
PD = JointPD(Kp=np.full(2, 20.0), Kd=np.full(2, 10.0))
T = np.linspace(0.0, 1.0, 11)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
REST = BaseState(np.zeros(3), LEVEL, np.zeros(3), np.zeros(1))
LOCKED = np.array([2.4, -2.0])
ARM = JointPD(Kp=np.array([1.0, 0.2]), Kd=np.array([0.1, 0.02]))
MOTOR = WheelLimits(torque=np.array([0.05]), speed=np.array([400.0]))


def fly(robot: Robot = ROBOT, t=T, start=START, **options) -> FreeFlying:
    options = {"command": Hold(np.zeros(2)), "joints": PD} | options
    return free_flying(robot, t, start, **options)


def test_nothing_moves_at_rest():
    run = fly(CEPHEUS, start=standing(REST, LOCKED), command=Hold(LOCKED), joints=ARM)
    for name in ("qd", "qdd", "w", "w_dot", "qd_rw", "r_S", "v_S", "f_S", "tau"):
        # r_S is the difference of the CM's position and itself.
        np.testing.assert_allclose(getattr(run, name), 0.0, atol=1e-15)
    assert run.error < 1e-15


def test_the_start_is_the_first_sample():
    run = fly()
    base = START.base
    for ours, given in (
        (run.q, START.q),
        (run.qd, START.qd),
        (run.attitude, base.attitude),
        (run.w, base.angular_velocity),
        (run.v_S, base.velocity),
        (run.r_S, START.r_S),
        (run.qd_rw, base.wheel_speed),
        (run.q_rw, START.q_rw),
    ):
        # To the CM and back.
        np.testing.assert_allclose(ours[0], given, atol=1e-14)


def test_shapes():
    run = fly()
    for name in ("w", "w_dot", "r_S", "v_S", "f_S", "r_cm", "h_cm", "force", "torque"):
        assert getattr(run, name).shape == (11, 3)
    for name in ("q", "qd", "qdd", "tau", "q_rw", "qd_rw", "qdd_rw", "tau_rw"):
        assert getattr(run, name).shape == (11, 2)
    assert run.attitude.shape == (11, 4)
    np.testing.assert_allclose(np.linalg.norm(run.attitude, axis=1), 1.0, rtol=4e-16)
    np.testing.assert_array_equal(run.t, T)


def test_one_run_is_two_that_follow_each_other():
    whole = fly(tolerance=1e-11)
    first = fly(t=T[:6], tolerance=1e-11)
    second = fly(t=T[5:], start=first.state(-1), tolerance=1e-11)
    for name in ("attitude", "q", "r_S", "q_rw", "w", "v_S"):
        # The tolerance of each, and rates some ten times larger; wheels turn 100 rad.
        np.testing.assert_allclose(
            getattr(second, name)[-1], getattr(whole, name)[-1], rtol=1e-10, atol=1e-10
        )


def test_pulse_edges_need_not_be_samples():
    """The same motion, whether or not the edges are among the samples."""
    pulses = [Pulse("t3", 0.123, 0.377, 1.0), Pulse("t5", 0.2, 0.9, 0.5)]
    options = {
        "start": standing(REST, LOCKED),
        "command": Hold(LOCKED),
        "joints": ARM,
        "pulses": pulses,
        "tolerance": 1e-12,
    }
    sparse = fly(CEPHEUS, t=np.array([0.0, 1.0]), **options)
    edges = np.array([0.0, 0.123, 0.2, 0.377, 0.9, 1.0])
    dense = fly(CEPHEUS, t=edges, **options)
    np.testing.assert_allclose(sparse.r_S[-1], dense.r_S[-1], atol=1e-11)
    np.testing.assert_allclose(sparse.w[-1], dense.w[-1], atol=1e-10)
    # At an edge, what follows is shown.
    firing = np.abs(dense.force).max(axis=1) > 0
    np.testing.assert_array_equal(firing, [False, True, True, True, False, False])


def test_pulse_edges_that_are_samples_but_for_rounding():
    """Beside what depends on the motion, which needs a path between steps."""
    robot = replace(CEPHEUS, disturbances={})
    tilted = Environment(tilt=(1e-3, 0.0))
    options = {"command": Hold(LOCKED), "joints": ARM, "environment": tilted}

    def flown(first: float, last: float) -> FreeFlying:
        pulses = [Pulse("t1", first, last, 0.5), Pulse("t4", first, 0.5, 0.5)]
        start = standing(REST, LOCKED)
        return fly(robot, start=start, pulses=pulses, **options)

    exact, beside = (
        flown(T[2], T[7]),
        flown(np.nextafter(T[2], 1), np.nextafter(T[7], 0)),
    )
    np.testing.assert_allclose(beside.r_S, exact.r_S, rtol=0, atol=1e-12)


def test_tolerance_is_kept():
    """Also where the torque limit cuts in and out, and RK4 is of second order only."""
    speed = START.base.wheel_speed + np.array([20.0, -20.0])
    law = WheelSpeed(k=np.full(2, 0.3), speed=speed)
    limits = WheelLimits(torque=np.full(2, 2.0), speed=np.full(2, np.inf))
    coarse = fly(wheels=law, limits=limits, tolerance=1e-4)
    fine = fly(wheels=law, limits=limits, tolerance=1e-7)
    assert fine.error < 1e-7 < coarse.error < 1e-4
    assert fine.steps > coarse.steps
    for name in ("attitude", "q", "r_cm"):
        difference = np.abs(getattr(coarse, name) - getattr(fine, name)).max()
        assert difference < coarse.error
    limit = np.abs(fine.tau_rw).max(axis=1)
    assert (limit > 2.0 - 1e-9).any()
    assert (limit < 1.9).any()


def test_wheels_without_a_law_are_held_or_free():
    run = fly(tolerance=1e-11)
    wheels = ROBOT.wheels
    np.testing.assert_array_equal(run.qd_rw[:, 0], run.qd_rw[0, 0])
    np.testing.assert_array_equal(run.qdd_rw[:, 0], 0.0)
    absolute = run.qd_rw[:, 1] + run.w @ wheels[1].axis
    # The tolerance, of 200 rad/s.
    np.testing.assert_allclose(absolute, absolute[0], rtol=1e-11)
    # What holds a wheel is Eq. 12's torque; a free one has none.
    holding = wheels[0].inertia * run.w_dot @ wheels[0].axis
    np.testing.assert_allclose(run.tau_rw[:, 0], holding, rtol=1e-12)
    np.testing.assert_allclose(run.tau_rw[:, 1], 0.0, atol=1e-12)


def test_wheel_spins_up_within_its_limits():
    """Eqs. 25 and 45: from rest to -170 rad/s; what the wheel has, the robot lost."""
    law = WheelSpeed(k=np.array([0.005]), speed=np.array([-170.0]))
    run = fly(
        CEPHEUS,
        t=np.linspace(0.0, 12.0, 121),
        start=standing(REST, np.zeros(2)),
        joints=ARM,
        wheels=law,
        limits=MOTOR,
        tolerance=1e-6,
    )
    # Time constant I_rw / k = 0.4 s: settled to e^-12 of 170 rad/s after the limit.
    np.testing.assert_allclose(run.qd_rw[-1], -170.0, atol=0.01)
    # exactly the limit while the motor is short of torque
    assert run.tau_rw.min() == pytest.approx(-0.05, rel=1e-12)
    np.testing.assert_allclose(run.h_cm, 0.0, atol=1e-10)


def test_wheel_never_exceeds_its_speed():
    law = WheelSpeed(k=np.array([0.005]), speed=np.array([-170.0]))
    run = fly(
        CEPHEUS,
        t=np.linspace(0.0, 12.0, 121),
        start=standing(REST, np.zeros(2)),
        joints=ARM,
        wheels=law,
        limits=MOTOR._replace(speed=np.array([100.0])),
        tolerance=1e-6,
    )
    # Without torque the arm, still swinging, turns the base by some 1e-4 rad/s.
    assert run.qd_rw.min() > -100.001
    np.testing.assert_allclose(run.qd_rw[-1], -100.0, rtol=0.02)
    np.testing.assert_allclose(run.tau_rw[-1], 0.0, atol=1e-15)


def test_burn_with_attitude_held():
    """Section 5.5: half a second of thrust, locked joints, the wheel holds the yaw."""
    hold = AttitudeHold(0.3, 0.3, LEVEL)
    run = fly(
        CEPHEUS,
        t=np.linspace(0.0, 20.0, 201),
        start=standing(REST, LOCKED),
        command=Hold(LOCKED),
        joints=JointPD(Kp=np.full(2, 5.0), Kd=np.full(2, 0.3)),
        wheels=hold,
        pulses=[Pulse("t3", 1.0, 1.5, 0.6)],
        tolerance=1e-7,
    )
    yaw = 2 * run.attitude[:, 2]
    # The moment of 0.11 N m for half a second turns it, and the wheel brings it back.
    assert 0.05 < np.abs(yaw).max() < 0.2
    assert np.abs(yaw[-1]) < 1e-3
    assert np.abs(run.q - LOCKED).max() < 0.01
    impulse = CEPHEUS.mass * np.linalg.norm(run.v_cm[-1])
    # The thruster turns with the base, by 0.1 rad.
    np.testing.assert_allclose(impulse, 0.6 * 0.5, rtol=0.01)


class Spin(NamedTuple):
    """A base that turns at a constant rate."""

    start: np.ndarray
    w: np.ndarray

    def at(self, t):
        turned = Rotation.from_rotvec(np.multiply.outer(t, self.w))
        x_WD = (Rotation.from_quat(self.start) * turned).as_quat()
        return x_WD, np.tile(self.w, (t.size, 1)), np.zeros((t.size, 3))


def test_computed_torque_tracks():
    """Its feedforward leaves no error, of the joints and of the base."""
    swing = random_swing(2, 2)
    robot = replace(ROBOT, wheels=random_wheels(1, ("free",) * 3))
    q, qd, _ = swing.at(np.zeros(1))
    base = random_start(3, robot)
    start = standing(base, q[0])._replace(qd=qd[0])
    spin = Spin(base.attitude, base.angular_velocity)
    law = ComputedTorque(robot, spin, kp=4.0, kd=4.0)
    run = fly(
        robot, start=start, command=swing, joints=law, wheels=law, tolerance=1e-11
    )
    # The tolerance.
    np.testing.assert_allclose(run.q, swing.at(T)[0], atol=1e-11)
    assert rotation_angle(run.attitude, spin.at(T)[0]).max() < 1e-11


def test_robot_without_joints_and_wheels():
    robot = random_robot(1, ())
    start = standing(random_start(3, robot), np.zeros(0))
    law = JointPD(Kp=np.zeros(0), Kd=np.zeros(0))
    run = free_flying(robot, T, start, Hold(np.zeros(0)), law, tolerance=1e-11)
    assert run.q.shape == run.qd_rw.shape == (11, 0)
    # The tolerance, of rates of the order of 1.
    np.testing.assert_allclose(run.h_cm, run.h_cm[[0] * 11], atol=1e-10)


def bouncing(t: np.ndarray) -> np.ndarray:
    """A relay: no step is small enough for its jumps."""
    return np.multiply.outer(np.sign(np.sin(900.0 * t)), np.full(2, 5.0))


HEAVY = replace(ROBOT, wheels=(Wheel("rw", np.array([0.0, 0.0, 1.0]), 50.0),))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pulses": [Pulse("t1", 0.0, 1.0, 1.0)]}, "no thruster 't1'"),
        (
            {"robot": replace(ROBOT, theta=np.diag([1.0, 1, 0]) @ ROBOT.theta)},
            "the mass matrix is singular",
        ),
        (
            {"robot": HEAVY, "start": standing(REST, np.zeros(2))},
            "without its wheels the base has inertia -",
        ),
    ],
)
def test_what_cannot_be_flown(options, message):
    with pytest.raises(InputError, match=f"random-1: {message}") as caught:
        fly(**options)
    assert "\n" not in str(caught.value)


def test_planar_robot_must_start_in_its_plane():
    start = standing(REST._replace(angular_velocity=np.array([0.1, 0.0, 0.0])), LOCKED)
    with pytest.raises(InputError, match="leaves the plane"):
        fly(CEPHEUS, start=start, joints=ARM)


def test_motion_that_does_not_settle(monkeypatch):
    monkeypatch.setattr("orbident.simulation.free_flying.MOST_STEPS", 2000)
    with pytest.raises(InputError, match="random-1: the motion does not settle: with"):
        fly(joints=OpenLoop(bouncing))
