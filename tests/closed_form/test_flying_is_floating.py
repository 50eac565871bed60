"""Where no thruster fires, free flying is free floating; and the plane is in space."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from flying_robots import moving_start, waving
from random_robots import DUAL_ARM, random_planar_robot, random_robot, random_wheels
from scipy.interpolate import BPoly

from orbident.robot.description import Robot, Thruster, Wheel
from orbident.simulation.flight import Hold
from orbident.simulation.free_floating import free_floating
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse

END = 2.0
Z = np.array([0.0, 0.0, 1.0])
WHEELS = tuple(Wheel(f"rw-{mode}", Z, 0.05, mode) for mode in ("held", "free"))
SPATIAL = random_robot(4, DUAL_ARM, (4,), random_wheels(4, ("free", "held", "free")))
PLANAR = random_planar_robot(5, DUAL_ARM, (1, 5), WHEELS)
PULSES = (Pulse("t1", 0.6, 1.3, 3.0), Pulse("t2", 0.9, 1.3, 2.0))


class Realised(NamedTuple):
    """The joints of a run as a function of time: quintics between samples."""

    curve: BPoly

    def at(self, t):
        return self.curve(t), self.curve(t, 1), self.curve(t, 2)


@pytest.mark.parametrize("robot", [SPATIAL, PLANAR], ids=["spatial", "planar"])
def test_without_thrusters_the_robot_floats_free(robot):
    """Joint torques move the arms; the base does what momentum conservation says.

    Held wheels and free ones, in space and in the plane.
    """
    t = np.linspace(0.0, END, 401)
    start = moving_start(8, robot)
    command = Hold(np.zeros(6))
    run = free_flying(robot, t, start, command, waving(2, 6), tolerance=1e-11)
    values = np.stack([run.q, run.qd, run.qdd], axis=1)
    joints = Realised(BPoly.from_derivatives(t, values))
    floated = free_floating(robot, joints, t, start.base, tolerance=1e-11)
    assert np.abs(run.qd).max() > 0.3
    for name in ("attitude", "w", "qd_rw", "r_S", "v_S"):
        ours, theirs = getattr(run, name), getattr(floated, name)
        # Both tolerances, of rates of the order of 1 and wheels of 200 rad/s; the
        # quintic is off by (5 ms)^6.
        scale = max(1.0, np.abs(theirs).max())
        np.testing.assert_allclose(ours, theirs, atol=1e-10 * scale, err_msg=name)


def flat(robot: Robot) -> Robot:
    """The robot with every CM, joint and thruster in the plane of S."""
    theta = robot.theta.copy()
    theta[:, [3, 7, 8]] = 0.0
    joints = tuple(
        replace(joint, p_PJ=joint.p_PJ * np.array([1, 1, 0])) for joint in robot.joints
    )
    thrusters = tuple(
        Thruster(f"t{k + 1}", np.array([x, y, 0.0]), np.array([c, s, 0.0]))
        for k, (x, y, c, s) in enumerate([(0.3, 0.4, 0.6, 0.8), (-0.5, 0.2, 0, -1)])
    )
    return replace(robot, theta=theta, joints=joints, thrusters=thrusters)


def test_planar_robot_moves_like_its_spatial_twin():
    """All mass in one plane: nothing pushes the spatial robot out of it."""
    planar = flat(PLANAR)
    one, other = (
        free_flying(
            robot,
            np.linspace(0.0, END, 21),
            moving_start(8, planar),
            Hold(np.zeros(6)),
            waving(2, 6),
            wheels=waving(3, 2),
            pulses=PULSES,
            tolerance=1e-11,
        )
        for robot in (planar, replace(planar, motion="spatial"))
    )
    for name, ours, theirs in zip(one._fields, one, other, strict=True):
        if name not in {"error", "steps"}:
            scale = max(1.0, np.abs(theirs).max())
            # Twice the tolerance, and accelerations of ten times the size.
            np.testing.assert_allclose(ours, theirs, atol=1e-10 * scale, err_msg=name)
    assert np.abs(one.v_cm[-1, :2] - one.v_cm[0, :2]).min() > 0.01
