"""What acts on a random robot from outside, drawn as its world says that it may."""

from dataclasses import replace
from typing import Any

import numpy as np
from disturbed import Now, Push, Wrench
from recordings import Clean
from scipy.spatial.transform import Rotation

from orbident.campaigns.case import with_instrument_errors
from orbident.environment.worlds import radius_of_gyration, scale_of, what_may_act
from orbident.robot.description import Robot
from orbident.robot.tolerances import CALIBRATION_KINDS, Tolerances
from orbident.simulation.measure import Truth

WAVES = 12
"""Of what changes slowly: their sum is nearly normal, and their rates are normal as the
spectrum is."""


def drawn_world(clean: Clean, seed: int) -> Push:
    """A torque about the system CM, a pull that may change from place to place, drag.

    What changes slowly swings about its mean, no faster than it may.
    """
    random = np.random.default_rng([seed, 7])
    robot, true = clean.robot, clean.true
    scale = scale_of(robot, clean.t, true.qd_rw, true.gyro, true.velocity)
    sizes = {name: each.size for name, each in what_may_act(robot, scale).items()}
    lasts = (what_may_act(robot, scale)["slow_torque"].shortest or np.inf) / np.pi
    rates = random.normal(size=(WAVES, 3)) / lasts
    phases = random.uniform(0.0, 2 * np.pi, (WAVES, 3))
    mean = random.normal(size=3)

    def torque(t: float) -> np.ndarray:
        waves = np.sqrt(2 / WAVES) * np.cos(rates * t + phases).sum(axis=0)
        return sizes["slow_torque"] * (mean + waves)

    pull = sizes["pull"] * random.normal(size=3)
    a, b, c = sizes.get("uneven", 0.0) * random.normal(size=3)
    A = np.array([[a, b, 0.0], [b, c, 0.0], [0.0, 0.0, 0.0]])
    c_v, c_w = abs(sizes.get("drag", 0.0) * random.normal(size=2))
    c_w *= radius_of_gyration(robot) ** 2

    def push(now: Now) -> Wrench:
        pulled = now.mass * (pull + A @ now.r_cm)
        dragged = -c_v * now.v_S
        force = now.R_WB.T @ (pulled + dragged)
        about_cm = np.cross(-now.to_cm, now.R_WB.T @ dragged) - c_w * now.w
        return Wrench(force, now.R_WB.T @ torque(now.t) + about_cm)

    return push


def with_spin(clean: Clean, seed: int) -> Clean:
    """That of a robot that was not quite at rest, where it is said to have been."""
    if clean.initial_momentum != "at-rest":
        return clean
    spin = clean.robot.at_rest.spin * np.random.default_rng([seed, 8]).normal()
    w = clean.start.angular_velocity + np.array([0.0, 0.0, spin])
    return replace(clean, start=clean.start._replace(angular_velocity=w))


def with_errors(clean: Clean, true: Truth, seed: int) -> tuple[Robot, Truth]:
    """The robot as its file has it, and what its instruments show without noise.

    Each error is drawn from its usual tolerance.
    """
    random = np.random.default_rng([seed, 9])
    robot = clean.robot
    joints = robot.joint_names
    errors, found = dict[str, float](), dict[str, Any]()
    for tolerance, kind in CALIBRATION_KINDS.items():
        per = joints if "joint." in kind.name else robot.wheel_names
        names = per if "{}" in kind.name else ("",)
        for name in (x for n in names for x in kind.names(n)):
            errors[name] = kind.usual * random.normal()
        each = dict.fromkeys(joints, kind.usual)
        found[tolerance] = each if "joint." in kind.name else kind.usual
    shown = with_instrument_errors(robot, clean.t, true, errors)
    wheels = []
    for x in robot.wheels:
        turn = [errors[f"wheel.{x.name}.axis.{axis}"] for axis in "xyz"]
        inertia = x.inertia / (1 + errors[f"wheel.{x.name}.inertia"])
        axis = Rotation.from_rotvec(turn).inv().apply(x.axis)
        wheels.append(replace(x, inertia=inertia, axis=axis))
    return replace(robot, wheels=tuple(wheels), tolerances=Tolerances(**found)), shown
