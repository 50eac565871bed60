"""A robot's constant tables, as the numerical core takes them."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.rotor_momentum import rotors_of, theta_with_rotors
from orbident.robot.description import Robot


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
        wheel_axis=np.ascontiguousarray(wheels.axes.T),
        wheel_inertia=wheels.inertia,
    )
