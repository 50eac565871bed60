"""Can this robot be flown like this? Refused in one line if not."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.model.regularity import check_regular
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com
from orbident.simulation.control_laws import (
    ComputedTorque,
    JointLaw,
    OpenLoop,
    WheelLaw,
    WheelLimits,
)
from orbident.simulation.flight import FlyingState
from orbident.simulation.free_floating import JointMotion, check_plane
from orbident.simulation.thrusters import Pulse, check_pulses

ROUNDING = 1e-12


def check_flight(
    robot: Robot,
    t: Float[np.ndarray, " n"],
    start: FlyingState,
    command: JointMotion,
    pulses: Sequence[Pulse],
) -> None:
    """Refuse what cannot be integrated.

    Raises:
        InputError: the times do not increase, something has not the size of the robot,
            a planar robot starts out of its plane, the mass matrix is singular, the
            wheels are heavier than the base, or a pulse cannot be flown.
    """
    if not t.size:
        raise InputError(f"{robot.name}: no sample times; give at least one")
    if not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
        raise InputError(f"{robot.name}: the sample times do not increase; sort them")
    joints, wheels = len(robot.joints), len(robot.wheels)
    sized = {
        "joint positions at the start": (start.q, joints),
        "joint rates at the start": (start.qd, joints),
        "joint positions commanded": (command.at(t[:1])[0][0], joints),
        "wheel speeds at the start": (start.base.wheel_speed, wheels),
        "wheel angles at the start": (start.q_rw, wheels),
    }
    for what, (values, count) in sized.items():
        _check_size(robot, what, np.shape(values), count)
    if robot.motion == "planar":
        check_plane(start.base)
    check_regular(robot)
    _check_wheels(robot)
    check_pulses(robot, pulses, float(t[0]), float(t[-1]))


def check_laws(
    robot: Robot,
    joints: JointLaw,
    wheels: WheelLaw | None,
    limits: WheelLimits | None,
    t: Float[np.ndarray, " n"],
) -> None:
    """Refuse laws and motors that are not for this robot's joints and wheels.

    Raises:
        InputError: so.
    """
    _check_law(robot, "joints", joints, len(robot.joints), t)
    if wheels is not None:
        _check_law(robot, "wheels", wheels, len(robot.wheels), t)
    computed = {id(law) for law in (joints, wheels) if isinstance(law, ComputedTorque)}
    if computed and computed != {id(joints), id(wheels)}:
        raise InputError(
            f"{robot.name}: computed torque moves joints and wheels together; give the "
            "same law for both"
        )
    for what, limit in (limits._asdict() if limits else {}).items():
        _check_size(
            robot, f"{what} limits of the wheels", limit.shape, len(robot.wheels)
        )
        if not (limit > 0).all():
            raise InputError(
                f"{robot.name}: {what} limits of the wheels: found {limit.tolist()}; "
                "give positive numbers"
            )


def _check_law(
    robot: Robot,
    what: str,
    law: JointLaw | WheelLaw,
    count: int,
    t: Float[np.ndarray, " n"],
) -> None:
    if isinstance(law, OpenLoop):
        found = np.shape(law.torque(t[:1]))[1:]
        _check_size(robot, f"torques of the {what}", found, count)
        return
    for name in ("Kp", "Kd", "k", "speed", "share"):
        shape = np.shape(getattr(law, name, np.zeros(count)))
        if shape[:1] != (count,):
            raise InputError(
                f"{robot.name}: the law of the {what} is not for {count} of them: "
                f"its {name} has the shape {shape}"
            )


def _check_wheels(robot: Robot) -> None:
    """What the base is without its wheels must still be a body."""
    I = inertia_about_com(robot.theta[0])
    largest = np.linalg.eigvalsh(I).max()
    for wheel in robot.wheels:
        I = I - wheel.inertia * np.outer(wheel.axis, wheel.axis)
    turning = I[2:, 2:] if robot.motion == "planar" else I
    smallest = np.linalg.eigvalsh(turning).min()
    if smallest < -ROUNDING * largest:
        raise InputError(
            f"{robot.name}: without its wheels the base has inertia {smallest:g} "
            "kg m^2 about some axis; a wheel's inertia is counted in the base: give "
            "the base more, or the wheels less"
        )


def _check_size(robot: Robot, what: str, found: tuple[int, ...], count: int) -> None:
    if found != (count,):
        raise InputError(
            f"{robot.name}: {what}: found shape {found}, expected ({count},), in the "
            "robot's order"
        )
