"""Can this robot be flown like this? Refused in one line if not."""

from collections.abc import Sequence

import jax
import numpy as np
from jaxtyping import Float

from orbident.dynamics.control_laws import ControlLaw, JointCommand, Now
from orbident.dynamics.equations_of_motion import split
from orbident.dynamics.flight import FlyingState
from orbident.dynamics.flight_steps import Vehicle
from orbident.dynamics.free_floating import JointMotion, check_plane
from orbident.dynamics.regularity import check_regular
from orbident.dynamics.thrusters import Pulse, check_pulses
from orbident.errors import InputError
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com

ROUNDING = 1e-12


def check_flight(
    robot: Robot,
    vehicle: Vehicle,
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
    _check_sizes(robot, vehicle, start, command.at(t[:1]))
    if robot.motion == "planar":
        check_plane(start.base)
    check_regular(robot)
    _check_wheels(robot)
    check_pulses(robot, pulses, float(t[0]), float(t[-1]))


def _check_sizes(
    robot: Robot,
    vehicle: Vehicle,
    start: FlyingState,
    commanded: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    joints, wheels = len(robot.joints), len(robot.wheels)
    sized = {
        "joint positions at the start": (start.q, joints),
        "joint rates at the start": (start.qd, joints),
        "joint positions commanded": (commanded[0][0], joints),
        "wheel speeds at the start": (start.base.wheel_speed, wheels),
        "wheel angles at the start": (start.q_rw, wheels),
        "torque limits of the wheels": (vehicle.limits.torque, wheels),
        "speed limits of the wheels": (vehicle.limits.speed, wheels),
    }
    for what, (values, count) in sized.items():
        _check_size(robot, what, np.shape(values), count)
    for what, limit in zip(("torque", "speed"), vehicle.limits, strict=True):
        if not (np.asarray(limit) > 0).all():
            raise InputError(
                f"{robot.name}: {what} limits of the wheels: found "
                f"{np.asarray(limit).tolist()}; give positive numbers"
            )
    v = split(vehicle.model, np.zeros(6 + joints + wheels))
    command = JointCommand(*(x[0] for x in commanded))
    now = Now(np.zeros(()), start.q, start.base.attitude, v, command)
    _check_law(robot, "joints", vehicle.joints, now, joints)
    if vehicle.wheels is not None:
        _check_law(robot, "wheels", vehicle.wheels, now, wheels)


def _check_law(robot: Robot, what: str, law: ControlLaw, now: Now, count: int) -> None:
    try:
        shape = jax.eval_shape(lambda law, now: law(now), law, now).shape
    except (TypeError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"{robot.name}: the law of the {what} is not for {count} of them: {reason}"
        ) from error
    _check_size(robot, f"torques of the {what}", shape, count)


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
