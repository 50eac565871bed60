"""Robot files that describe another robot than the one that moved."""

from collections.abc import Callable
from dataclasses import replace

from edited_recordings import changed
from recordings import Clean, motion_of
from spoiled import Spoil, Spoiled, spoiled

from orbident.robot.description import Joint, Robot, Wheel


def described(change: Callable[[Robot], Robot]) -> Spoil:
    """The robot file is wrong."""
    return lambda clean: spoiled(clean, robot=change(clean.robot))


def each_wheel(change: Callable[[Wheel], Wheel], count: int | None = None) -> Spoil:
    """The first wheels as the robot file has them; all by default."""

    def wrong(robot: Robot) -> Robot:
        wheels = robot.wheels[:count]
        rest = robot.wheels[len(wheels) :]
        return replace(robot, wheels=(*map(change, wheels), *rest))

    return described(wrong)


def one_joint(index: int, change: Callable[[Joint], Joint]) -> Spoil:
    """A joint as the robot file has it."""

    def wrong(robot: Robot) -> Robot:
        joints = list(robot.joints)
        joints[index] = change(joints[index])
        return replace(robot, joints=tuple(joints))

    return described(wrong)


def without_wheel(clean: Clean) -> Spoiled:
    """The first wheel is neither in the robot file nor in the recording."""
    gone = clean.robot.wheels[0].name
    kept = changed(
        clean.recorded(), keep=lambda name: not name.startswith(f"wheel.{gone}.")
    )
    return spoiled(clean, replace(clean.robot, wheels=clean.robot.wheels[1:]), kept)


def really(change: Callable[[Robot], Robot]) -> Spoil:
    """The robot is not as described, and moves so."""

    def spoil(clean: Clean) -> Spoiled:
        actual = change(clean.robot)
        true = motion_of(actual, clean.joints, clean.start, clean.t)
        return replace(spoiled(clean, recording=clean.recorded(true)), true=(actual,))

    return spoil
