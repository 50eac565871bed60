"""Robots that are not as their file says, or are not left alone; flown by MuJoCo."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np
from acting_in_mujoco import UNSIZED, Acts, Burst, Stage
from flown import Flown, flies, flown
from mistake import IN_SPACE, ON_TABLE, Groups, Mistake, twice
from parts_on_board import (
    Base,
    Part,
    ball,
    driven,
    fixed,
    moving,
    on_springs,
    plate,
    spring,
    without,
)
from recordings import ROBOTS, Clean
from spoiled import Spoil, Spoiled, spoiled

from orbident.robot.description import GearedRotor, Robot, Wheel
from orbident.robot.parameters import inertia_matrix, transformed
from orbident.trajectories.trajectory import Trajectory

X, Y, Z = np.eye(3)


def panels(hz: float) -> Spoil:
    """Two, of 1.2 % of the base each."""

    def change(clean: Clean) -> Flown:
        base = Base.of(clean.robot)
        left, right = (plate(f"panel {k:g}", base, 0.012, k) for k in (1.0, -1.0))
        axes = [X if clean.space else Z]
        springs = on_springs(hz, (left, axes), (right, axes))
        return flown(clean, without(clean.robot, left, right), hidden=springs)

    return flies(change)


def fuel(share: float) -> Spoil:
    """A pendulum at 0.15 Hz about two axes, so much of the base."""

    def change(clean: Clean) -> Flown:
        base = Base.of(clean.robot)
        tank = ball("fuel", base, share, (0.2, 0.1, -0.1))
        down = -0.3 * base.radius * Z
        hinge = tank._replace(place=tank.place - down, com=down)
        springs = on_springs(0.15, (hinge, [X, Y]))
        return flown(clean, without(clean.robot, hinge), hidden=springs)

    return flies(change)


def flexible(hz: float) -> Spoil:
    """A spring behind the motor of joint2; its encoder is on the motor.

    The motor's hinge and the spring's are on one body. An armature is of no momentum;
    it keeps MuJoCo's matrix regular.
    """

    def change(clean: Clean) -> Flown:
        inertia = _beyond_joint2(clean.robot)

        def add(spec: mujoco.MjSpec) -> None:
            joint = spec.joint("joint2")
            joint.armature = inertia
            joint.parent.add_joint(
                name="flexibility", axis=joint.axis, **spring(hz, inertia)
            )

        return flown(clean, hidden=add, dt=0.005)

    return flies(change)


def _beyond_joint2(robot: Robot) -> float:
    """Moment of inertia about joint2 with all joints at zero, kg m^2."""
    total, place = np.zeros(10), np.zeros(3)
    for k, joint in enumerate(robot.joints[1:]):
        # Axes of both robots are parallel at zero.
        place = place + (joint.p_PJ if k else 0.0)
        total += transformed(robot.theta[k + 2], np.eye(3), place)
    axis = robot.joints[1].axis
    return float(axis @ inertia_matrix(total) @ axis)


def geared(share: float) -> Spoil:
    """Behind a gear of 100; gear times inertia are so much of the base's about z."""

    def change(clean: Clean) -> Flown:
        base, name = Base.of(clean.robot), clean.robot.joint_names[0]
        rotor = GearedRotor(100.0, share * base.mass * base.radius**2 / 100)
        rotors = {**clean.robot.rotors, name: rotor}
        return flown(clean, replace(clean.robot, rotors=rotors))

    return flies(change)


@dataclass(frozen=True, eq=False)
class Venting:
    """A part gets lighter until nothing is left; what leaves is as fast as the part."""

    part: Part
    duration: float
    """s."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        k, model = stage.model.body(self.part.name).id, stage.model
        left = max(1 - stage.data.time / self.duration, 1e-9)
        moments = np.linalg.eigvalsh(self.part.inertia)
        model.body_mass[k] = left * self.part.mass
        model.body_inertia[k] = left * moments

    group = ""
    sizes = UNSIZED


def vented(share: float) -> Spoil:
    """So much of the base is let out evenly, to all sides."""

    def spoil(clean: Clean) -> Spoiled:
        tank = ball("tank", Base.of(clean.robot), share, (0.5, 0.3, 0.0))
        after = without(clean.robot, tank)
        venting = Venting(tank, float(clean.t[-1]))
        shown = flown(clean, after, acts=venting, hidden=fixed(tank))
        middle = replace(after, theta=(clean.robot.theta + after.theta) / 2)
        return replace(
            spoiled(clean, recording=shown.recorded()),
            true=(clean.robot, middle, after),
        )

    return spoil


def turning_array(rate: float) -> Spoil:
    """A solar array of 1.2 % of the base follows the Sun, rad/s, and nobody says so."""

    def change(clean: Clean) -> Flown:
        array = plate("array", Base.of(clean.robot), 0.012, 1.0)
        turning = moving("array", rate, 0.0)
        return flown(clean, driven(clean.robot, array, "revolute", Y), turning)

    return flies(change)


def spinning(share: float) -> Spoil:
    """A wheel that the file does not have, with so much of the first one's momentum."""

    def change(clean: Clean) -> Flown:
        wheel, speed = clean.robot.wheels[0], 500.0
        inertia = share * wheel.inertia * clean.start.wheel_speed[0] / speed
        hidden = Wheel("hidden", np.array([0.6, 0.0, 0.8]), inertia)
        actual = replace(clean.robot, wheels=(*clean.robot.wheels, hidden))

        def spun(motion: Trajectory) -> Trajectory:
            speeds = {**motion.initial.wheel_speed, "hidden": speed}
            return replace(motion, initial=replace(motion.initial, wheel_speed=speeds))

        return flown(clean, actual, spun)

    return flies(change)


def carriage(share: float) -> Spoil:
    """So much of the base slides to and fro by a fifth of the base's radius."""

    def change(clean: Clean) -> Flown:
        base = Base.of(clean.robot)
        slide = ball("carriage", base, share, (0.3, -0.5, 0.0))
        fro = moving("carriage", 0.0, 0.2 * base.radius)
        axis = np.array([0.6, 0.8, 0.0])
        return flown(clean, driven(clean.robot, slide, "prismatic", axis), fro)

    return flies(change)


def locked(motion: Trajectory) -> Trajectory:
    """The brake of joint2 stays shut."""
    a, b = motion.a.copy(), motion.b.copy()
    a[1] = b[1] = 0.0
    return replace(motion, a=a, b=b)


class Umbilical(NamedTuple):
    """Pulls the base back to where it was, as a spring, N/m."""

    stiffness: float

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        away = np.array([*stage.data.qpos[:2], 0.0])
        stage.push(outside, -self.stiffness * away, np.zeros(3), "base")

    group = ""
    sizes = UNSIZED


class Rocking(NamedTuple):
    """A table on soft feet: its pull swings once in 7 s, m/s^2."""

    size: float

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        swing = np.sin(2 * np.pi * stage.data.time / 7.0)
        stage.model.opt.gravity = [self.size * swing, 0.0, 0.0]

    group = ""
    sizes = UNSIZED


def acted(acts: Callable[[float], Acts]) -> Callable[[float], Spoil]:
    return lambda size: flies(lambda clean: flown(clean, acts=acts(size)))


def leak(force: float) -> Burst:
    """Of a valve at a corner of the base all the time, N."""
    corner = np.array([0.19, 0.1, 0.0])
    return Burst(-1.0, 1e9, force * Y, corner)


SWINGS = "flexib*|spring*|swing*|ring*|panel|boom|slosh*|loose"
"""A panel, a boom or fuel: to a recording all of these are one."""

GIVES_WAY = "flexib*|elastic|stiff*|gives|spring*|swing*|ring*"

ON_ROBOTS: Groups = {
    "part that moves": (
        *twice("two panels on springs at {:g} Hz", panels, 1.0, cause=SWINGS,
               unobservable=ON_TABLE),
        *twice("two panels on springs at {:g} Hz", panels, 0.3, cause=SWINGS),
        *twice("fuel of {:g} of the base as a pendulum", fuel, 0.02, 0.05,
               cause=SWINGS, robots=IN_SPACE),
        *twice("joint2 gives way at {:g} Hz behind its encoder", flexible, 5.0,
               cause=GIVES_WAY, unobservable=ON_TABLE),
        *twice("joint2 gives way at {:g} Hz behind its encoder", flexible, 1.0,
               cause=GIVES_WAY),
        *twice("solar array turns by {:g} rad/s", turning_array, 1e-3, 2e-2,
               cause="turns|rotat*|array|moves|moving|loose|momentum",
               robots=IN_SPACE),
        *twice("hidden wheel with {:g} of a wheel's momentum", spinning, 1e-3, 0.1,
               cause="momentum|spin*|hidden|missing|undeclared", robots=IN_SPACE),
        *twice("{:g} of the base slides to and fro", carriage, 1e-3, 2e-2,
               cause="loose|moves|moving|slid*|slosh*"),
    ),
    "robot": (
        *twice("rotor of {:g} of the base's inertia not declared", geared, 1e-4, 1e-2,
               # A link that has more, and the body that carries it less.
               cause="rotor|gear", unobservable=ROBOTS),
        *twice("{:g} of the base is vented", vented, 1e-3, 2e-2,
               cause="chang*|releas*|lighter|vent*|propellant|mass"),
        Mistake("brake of joint2 stays shut", flies(lambda c: flown(c, motion=locked)),
                "still|locked|rest|moves|excit* joint2"),
    ),
    "outside": (
        *twice("umbilical that pulls with {:g} N/m", acted(Umbilical), 1e-3, 5e-2,
               cause="force|pull*|cable|umbilical|disturb*|external", robots=ON_TABLE),
        *twice("table rocks by {:g} m/s^2", acted(Rocking), 3e-5, 1e-3,
               cause="force|pull*|level|tilt*|disturb*|external", robots=ON_TABLE),
        *twice("valve that leaks with {:g} N", acted(leak), 1e-4, 1e-2,
               cause="force|pull*|push*|thrust*|leak*|torque"),
    ),
}  # fmt: skip
