"""Kinds of mistakes in robot files: places, axes and wheels."""

from dataclasses import replace

import numpy as np
from drawn import Kind, Random, about, between, direction, either
from mistake import Mistake
from recordings import Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil
from wrong_robots import described, one_joint, without_wheel

from orbident.robot.description import Robot, Wheel


def _one(clean: Clean, random: Random, first: int = 0) -> tuple[int, str]:
    """A joint, by number and name."""
    k = int(random.integers(first, len(clean.robot.joints)))
    return k, clean.robot.joint_names[k]


def _on(clean: Clean, k: int) -> str:
    """The body that a joint is on."""
    return clean.robot.bodies[clean.robot.joints[k].parent]


PLACE = "geometry|length|place*|position"


def link_length(clean: Clean, random: Random) -> Mistake:
    k, joint = _one(clean, random, 1)
    part = either(random) * between(random, 0.02, 0.06)
    return Mistake(
        f"{joint} {100 * part:g} % farther from the joint before",
        one_joint(k, lambda j: replace(j, p_PJ=(1 + part) * j.p_PJ)),
        f"{PLACE} {joint}|{_on(clean, k)}",
    )


def joint_beside(clean: Clean, random: Random) -> Mistake:
    k, joint = _one(clean, random)
    off = between(random, 5e-3, 3e-2) * direction(clean, random)
    return Mistake(
        f"{joint} placed {1000 * np.linalg.norm(off):.0f} mm off",
        one_joint(k, lambda j: replace(j, p_PJ=j.p_PJ + off)),
        f"{PLACE} {joint}|{_on(clean, k)}",
    )


def joint_tilted(clean: Clean, random: Random) -> Mistake:
    k, joint = _one(clean, random)
    angle = between(random, 1.0, 4.0)
    R = Rotation.from_rotvec(np.radians(angle) * about(clean, random)).as_matrix()
    return Mistake(
        f"{joint} tilted {angle:g} deg",
        one_joint(k, lambda j: replace(j, R_PJ=j.R_PJ @ R)),
        f"geometry|axes|axis|tilt* {joint}",
    )


def joint_a_quarter_turn_off(clean: Clean, random: Random) -> Mistake:
    """A frame drawn a quarter turn about the joint's axis off."""
    k, joint = _one(clean, random)
    R = Rotation.from_rotvec(
        either(random) * np.pi / 2 * clean.robot.joints[k].axis
    ).as_matrix()
    return Mistake(
        f"{joint} a quarter turn off",
        one_joint(k, lambda j: replace(j, R_PJ=j.R_PJ @ R)),
        f"zero|offset|geometry|place*|axis|turn* {joint}",
    )


def opposite_axis(clean: Clean, random: Random) -> Mistake:
    k, joint = _one(clean, random)
    return Mistake(
        f"{joint} about the opposite axis",
        one_joint(k, lambda j: replace(j, axis=-j.axis)),
        f"sign|axis|axes {joint}",
    )


def wheel_axis(clean: Clean, random: Random) -> Mistake:
    k = int(random.integers(len(clean.robot.wheels)))
    angle = between(random, 2.0, 8.0)
    R = Rotation.from_rotvec(np.radians(angle) * direction(clean, random)).as_matrix()
    return Mistake(
        f"axis of {clean.robot.wheel_names[k]} {angle:g} deg off",
        _one_wheel(k, lambda w: replace(w, axis=R @ w.axis)),
        f"axes|axis wheel|{clean.robot.wheel_names[k]}",
    )


def wheel_inertia(clean: Clean, random: Random) -> Mistake:
    k = int(random.integers(len(clean.robot.wheels)))
    part = either(random) * between(random, 0.05, 0.2)
    return Mistake(
        f"inertia of {clean.robot.wheel_names[k]} {100 * part:g} % off",
        _one_wheel(k, lambda w: replace(w, inertia=(1 + part) * w.inertia)),
        "inertia wheel",
    )


def _one_wheel(k: int, change) -> Spoil:
    def wrong(robot: Robot) -> Robot:
        wheels: list[Wheel] = list(robot.wheels)
        wheels[k] = change(wheels[k])
        return replace(robot, wheels=tuple(wheels))

    return described(wrong)


def missing_wheel(clean: Clean, random: Random) -> Mistake:
    spoil: Spoil = without_wheel
    return Mistake("a wheel is missing", spoil, "wheel missing|declare|undeclared")


KINDS = (
    Kind(link_length),
    Kind(joint_beside),
    Kind(joint_tilted, table=False),
    Kind(joint_a_quarter_turn_off),
    Kind(opposite_axis),
    Kind(wheel_axis, table=False),
    Kind(wheel_inertia, table=False, wheels=2),
    Kind(missing_wheel, table=False, wheels=2),
)
