"""A robot's constant tables, as the numerical core takes them: tree, wheels, rotors.

The rotor of a joint's motor, of inertia `J`, turns `N qd` about the axis `a` of its
joint, beside the body that carries it, which has its mass and its inertia at rest. It
adds `N J qd a` to the momentum and, at a rate `w` of that body,

    1/2 J (N qd)^2 + N J qd a . w

to the kinetic energy. Bodies without rotors, of which the driven one has `N J a a^T`
more inertia and the carrying one as much less, have the same momentum. Their energy
lacks `1/2 N (N - 1) J qd^2`: a constant in the joint's own entry of `H+`. Of the two
bodies momentum shows `I_p + I_c` and `I_c + N J` about the axis, and no more.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.files.names import listed
from orbident.robot.description import NO_FRICTION, NO_ROTOR, GearedRotor, Robot
from orbident.robot.parameters import (
    INERTIA,
    INERTIA_ENTRIES,
    PER_BODY,
    SYMBOLS,
    Structure,
)


class Wheels(NamedTuple):
    """The reaction wheels of a base."""

    axes: Float[np.ndarray, "3 wheels"]
    """Unit vectors, base axes."""
    A_rw: Float[np.ndarray, "3 wheels"]
    """Columns `a_i I_rw,i`: `h_rw = A_rw qd_rw`, base axes."""
    inertia: Float[np.ndarray, " wheels"]
    """Polar moments of inertia `I_rw,i`, kg m^2."""
    free: Float[np.ndarray, " wheels"]
    """1 for a wheel whose motor is off, 0 for one held at its relative speed."""


def wheels_of(robot: Robot) -> Wheels:
    """The robot's reaction wheels."""
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    inertia = np.array([wheel.inertia for wheel in robot.wheels], dtype=float)
    free = np.array([float(wheel.mode == "free") for wheel in robot.wheels])
    return Wheels(axes, axes * inertia, inertia, free)


KEPT = 64
"""Robots of a process whose tables are kept."""


@lru_cache(maxsize=KEPT)
def core_tree(robot: Robot) -> _core.Tree:
    """The robot's kinematic tree; joint `k` moves body `k + 1`."""
    joints = robot.joints
    return _core.Tree(
        parent=np.array([joint.parent for joint in joints], dtype=float),
        revolute=np.array([float(joint.kind == "revolute") for joint in joints]),
        axis=np.reshape([joint.axis for joint in joints], (-1, 3)).astype(float),
        R_PJ=np.reshape([joint.R_PJ for joint in joints], (-1, 3, 3)).astype(float),
        p_PJ=np.reshape([joint.p_PJ for joint in joints], (-1, 3)).astype(float),
    )


@lru_cache(maxsize=KEPT)
def core_robot(robot: Robot) -> _core.Robot:
    """The robot's tree with its nominal inertia, its motors' rotors and its wheels."""
    wheels = wheels_of(robot)
    return _core.Robot(
        tree=core_tree(robot),
        theta=np.ascontiguousarray(theta_with_rotors(robot), dtype=float),
        armature=rotors_of(robot).armature,
        wheel_axis=wheels.axes.T,
        wheel_inertia=wheels.inertia,
    )


IN_FORMULAS = (
    "rotor(joint): its gear's ratio times the inertia of its motor's rotor, about the "
    "joint's axis; zero without a gear"
)
"""What formulas mean by it."""


class RotorArrays(NamedTuple):
    """The rotors of all joints that the robot file declares; zero where it does not."""

    momentum: Float[np.ndarray, " joints"]
    """`N J`, kg m^2."""
    armature: Float[np.ndarray, " joints"]
    """`N (N - 1) J`, kg m^2."""
    tolerance: Float[np.ndarray, " joints"]
    """Relative standard deviation of both."""


def rotors_of(robot: Robot) -> RotorArrays:
    """The declared rotors, in the order of the joints."""
    rotors = [robot.rotors.get(name, NO_ROTOR) for name in robot.joint_names]
    N, J, tolerance = np.reshape(rotors, (-1, 3)).T.astype(float)
    return RotorArrays(N * J, N * (N - 1) * J, tolerance)


def friction_of(robot: Robot) -> Float[np.ndarray, "joints 3"]:
    """The declared friction of each joint: viscous, Coulomb, offset; or zero."""
    friction = [robot.friction.get(name, NO_FRICTION) for name in robot.joint_names]
    return np.reshape([each[:3] for each in friction], (-1, 3)).astype(float)


def friction_torques(
    robot: Robot, qd: Float[np.ndarray, "*n joints"]
) -> Float[np.ndarray, "*n joints"]:
    """What declared friction takes at these rates (see `Friction`), N m or N."""
    viscous, coulomb, offset = friction_of(robot).T
    return viscous * qd + coulomb * np.sign(qd) + offset


def rotor_directions(robot: Robot) -> Float[np.ndarray, "joints theta"]:
    """How the flat `theta` changes by the `N J` of each joint that turns."""
    directions = np.zeros((len(robot.joints), *robot.theta.shape))
    for k, joint in enumerate(robot.joints):
        if joint.kind == "revolute":
            directions[k, k + 1, INERTIA] = _square(joint.axis)
            directions[k, joint.parent, INERTIA] = -_square(joint.R_PJ @ joint.axis)
    return directions.reshape(len(robot.joints), robot.theta.size)


def _square(a: Float[np.ndarray, "3"]) -> Float[np.ndarray, "6"]:
    """`a a^T` as `theta` holds an inertia."""
    return np.array([a[i] * a[j] for i, j in INERTIA_ENTRIES])


def rotor_parts(robot: Robot) -> Float[np.ndarray, "theta joints"]:
    """What each declared rotor adds to the flat `theta` in all that is momentum."""
    return rotor_directions(robot).T * rotors_of(robot).momentum


def rotor_deviations(robot: Robot) -> Float[np.ndarray, "theta joints"]:
    """The standard deviations of what each declared rotor adds."""
    return rotor_parts(robot) * rotors_of(robot).tolerance


def spinning_rotors(robot: Robot) -> dict[int, int]:
    """The places in the flat `theta` of rotors that are bodies of their own, by joint.

    Behind the motor of a flexible joint momentum shows `N J` apart from the link.
    """
    axes = [robot.structure.get(body, Structure()).spins_about for body in robot.bodies]
    return {
        k: PER_BODY * (k + 1) + SYMBOLS.index("I" + 2 * axis)
        for k, axis in enumerate(axes[1:])
        if axis is not None
    }


def spinning_parts(
    robot: Robot, theta: Float[np.ndarray, "bodies 10"]
) -> Float[np.ndarray, "bodies 10"]:
    """What such rotors have of a `theta`, as momentum sees it."""
    found, directions = np.zeros(theta.size), rotor_directions(robot)
    for k, place in spinning_rotors(robot).items():
        found += theta.ravel()[place] * directions[k]
    return found.reshape(theta.shape)


def theta_with_rotors(robot: Robot) -> Float[np.ndarray, "bodies 10"]:
    """The `theta` of bodies without rotors that have the robot's momentum."""
    return robot.theta + rotor_parts(robot).sum(axis=1).reshape(robot.theta.shape)


UNKNOWN = GearedRotor(2.0, 0.0, 0.0)
"""Stands for a rotor whose gear nobody has declared. Base parameters hold its momentum,
whatever the gear is, and a joint's own entry of `H+` needs `N (N - 1) J` alone."""

LEAST = 1e-9
"""kg m^2: of a rotor that is as good as none, but keeps its deviation."""


def with_armatures(robot: Robot, found: Mapping[str, tuple[float, float]]) -> Robot:
    """The robot whose rotors have these `N (N - 1) J`, if not less than nothing.

    Each was found with its standard deviation, kg m^2 or kg; what is zero was not.
    """
    shown = {name: each for name, each in found.items() if all(each)}
    if not shown:
        # What was worked out for a robot is kept with it.
        return robot
    rotors = dict(robot.rotors)
    for name, (armature, std) in shown.items():
        gear = rotors.get(name, UNKNOWN).gear
        inertia = max(armature / (gear * (gear - 1)), LEAST)
        part = std / abs(gear * (gear - 1) * inertia)
        rotors[name] = GearedRotor(gear, inertia, part)
    return replace(robot, rotors=rotors)


def undeclared_rotors(robot: Robot) -> tuple[str, ...]:
    """Joints whose motor may be geared: they turn by it, and nothing is said."""
    # What nobody drives has no motor.
    without = {*(each.follower for each in robot.couplings), *robot.passive}
    return tuple(
        joint.name
        for joint in robot.joints
        if joint.kind == "revolute" and joint.name not in {*without, *robot.rotors}
    )


def geared_joints(robot: Robot) -> list[str]:
    """Joints whose motor is geared, or may be."""
    unknown = undeclared_rotors(robot)
    return [
        name
        for name in robot.joint_names
        if name in unknown or robot.rotors.get(name, NO_ROTOR).inertia
    ]


def lacking_rotors(robot: Robot, without: str = "") -> str:
    """What is said of a model that lacks rotors, and of one `without` declared ones."""
    words, names = [], undeclared_rotors(robot)
    if names:
        words.append(
            f"motors' rotors are not in the inertia of {listed(names)}, which lacks "
            "gear^2 times theirs if they are geared: see 'rotors' in the robot file"
        )
    if rotors_of(robot).momentum.any():
        words.append(without)
    return "; ".join(filter(None, words))
