"""A trajectory whose limits are proven to hold for all times."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.conditions import Conditions, Limits
from orbident.excitation.extremes import (
    NODES,
    BaseExtremes,
    Extremes,
    base_extremes_of,
    extremes_of,
)
from orbident.excitation.joint_motions import JointMotions
from orbident.robot.description import Robot
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating
from orbident.trajectories.trajectory import Trajectory

ACCURATE = 1e-6
"""Accuracy of the attitude, rad: bounds and scores need no better one."""

SHARES = (1.0, 0.999, 0.998, 0.995, 0.99, 0.98, 0.95, 0.9, 0.8, 0.6, 0.3, 0.0)
"""Shares of the amplitude, tried until the limits are proven to hold."""


class Proven(NamedTuple):
    """A trajectory and its extremes, never too small."""

    trajectory: Trajectory
    motion: FreeFloating
    joints: Extremes
    base: BaseExtremes
    share: float
    """Share of the amplitude that was asked for."""


def proven_within(
    robot: Robot,
    given: Conditions,
    motions: JointMotions,
    middle: Float[np.ndarray, "free m"],
    y: Float[np.ndarray, "free m"],
) -> Proven:
    """The motion, made smaller where its limits cannot be proven otherwise.

    Args:
        robot: with its nominal inertia.
        given: the conditions, limits among them.
        motions: the space of the motions.
        middle: a motion well inside the limits.
        y: the motion that is wanted.

    Raises:
        InputError: the limits of the base cannot be proven for any amplitude.
    """
    broken = ""
    for share in SHARES:
        a, b = motions.coefficients(middle + share * (y - middle))
        trajectory = Trajectory(
            given.duration,
            robot.joint_names,
            a,
            b,
            given.start,
            given.end,
            given.initial,
            source="design",
        )
        joints = extremes_of(trajectory)
        broken = _broken_by_joints(joints, given.limits)
        if broken:
            continue
        motion = floated(robot, trajectory)
        base = base_extremes_of(robot, motion, joints)
        broken = _broken_by_base(base, given.limits)
        if not broken:
            return Proven(trajectory, motion, joints, base, share)
    raise InputError(f"limits: {broken}; raise the limit, or give more time")


def floated(robot: Robot, trajectory: Trajectory) -> FreeFloating:
    """The motion that the trajectory makes, at times close to each other.

    Args:
        robot: with its nominal inertia.
        trajectory: for this robot, rows in its order.

    Raises:
        InputError: the base turns too fast for an accurate attitude.
    """
    initial = trajectory.initial
    start = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        initial.wheel_speeds(robot.wheel_names),
    )
    t = np.linspace(0.0, trajectory.duration, NODES)
    return free_floating(robot, trajectory.motion, t, start, ACCURATE)


def _broken_by_joints(joints: Extremes, limits: Limits) -> str:
    lower, upper = limits.position.T
    beyond = {
        "position": np.maximum(
            lower - joints.position[:, 0], joints.position[:, 1] - upper
        ),
        "velocity": joints.velocity - limits.velocity,
        "acceleration": joints.acceleration - limits.acceleration,
    }
    for name, excess in beyond.items():
        if (excess > 0).any():
            return f"joint {name} may exceed its limit by {excess.max():.2g}"
    return ""


def _broken_by_base(base: BaseExtremes, limits: Limits) -> str:
    for name, found, limit in (
        ("base rate", base.rate, limits.base_rate),
        ("excursion", base.excursion, limits.excursion),
        ("wheel speed", base.wheel_speed, limits.wheel_speed),
    ):
        # An excursion of pi is as far as there is.
        if found > limit and not (name == "excursion" and limit >= np.pi):
            return f"{name}: up to {found:.6g} is possible, the limit is {limit:g}"
    return ""
