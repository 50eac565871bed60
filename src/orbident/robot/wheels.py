"""URDF joints that a robot file declares to be reaction wheels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.robot.fusing import fused
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    inertia_about_com,
    inertia_matrix,
)
from orbident.robot.tree import LinkTree
from orbident.robot.urdf import UrdfJoint

BALANCE = 1e-6
"""A rotor is balanced where its errors are below this part of its own inertia."""


@dataclass(frozen=True)
class Rotor:
    """A wheel's mechanics, read from the URDF."""

    axis: Float[np.ndarray, "3"]
    """Unit vector, base axes."""
    inertia: float
    """About the spin axis, kg m^2."""
    warnings: tuple[str, ...]


def rotor(
    tree: LinkTree, joint_name: str, where: str, declared: float | None = None
) -> Rotor:
    """The rotor on a URDF joint.

    Args:
        tree: the robot's links and joints.
        joint_name: a revolute or continuous joint on the base, whose subtree is
            rigid.
        where: file and key, for messages.
        declared: inertia about the axis, kg m^2, of a rotor that the URDF gives none.
            It is already part of the base, as that of a wheel without a joint.

    Raises:
        InputError: no such joint, one that cannot be a wheel, or a rotor without
            inertia about its axis, or with two.
    """
    key = f"{where}.joint"
    joints = {j.name: j for below in tree.children.values() for j in below}
    joint = joints.get(joint_name)
    if joint is None:
        raise InputError(
            f"{key}: no joint {joint_name!r}; "
            + suggestion(joint_name, joints, "joints")
        )
    if joint.kind not in {"revolute", "continuous"}:
        raise InputError(
            f"{key}: joint '{joint_name}' is {joint.kind}; a wheel needs a revolute "
            "or continuous joint"
        )
    on_base = fused(tree).placements.get(joint.parent)
    if on_base is None or on_base.body != 0:
        raise InputError(
            f"{key}: joint '{joint_name}' is on link '{joint.parent}', which moves; "
            "a wheel must be on the base"
        )
    turning = fused(tree, root=joint.child)
    if turning.joints:
        raise InputError(
            f"{key}: joint '{turning.joints[0].name}' moves below the wheel's joint "
            f"'{joint_name}'; a rotor must be rigid"
        )
    theta = turning.theta[0]
    inertia = float(joint.axis @ inertia_matrix(theta) @ joint.axis)
    if declared is not None:
        if inertia > 0:
            raise InputError(
                f"{where}.inertia: found {declared:g} kg m^2, but the URDF gives the "
                f"rotor on joint '{joint_name}' {inertia:g} kg m^2 about its axis; "
                "keep one"
            )
        inertia = declared
    if inertia <= 0:
        raise InputError(
            f"{key}: the rotor on joint '{joint_name}' has inertia {inertia:g} "
            "kg m^2 about its axis; give its link an <inertial>, or the wheel an "
            "'inertia' in the robot file"
        )
    axis = on_base.R @ joint.R @ joint.axis
    return Rotor(axis, inertia, _imbalance(joint, theta, inertia))


def _imbalance(
    joint: UrdfJoint, theta: Float[np.ndarray, "10"], inertia: float
) -> tuple[str, ...]:
    m, a = theta[MASS], joint.axis
    I_com = inertia_about_com(theta) if m else inertia_matrix(theta)
    warnings = []
    off_axis = theta[FIRST_MOMENT] - a * (a @ theta[FIRST_MOMENT])
    # Compared with the radius of gyration: m d < 1e-6 sqrt(m I).
    if np.linalg.norm(off_axis) > BALANCE * np.sqrt(m * inertia):
        distance = np.linalg.norm(off_axis) / m
        warnings.append(
            f"wheel on joint '{joint.name}': the rotor's CM is {distance:.4g} m off "
            "its axis; it is counted in the base as at q = 0"
        )
    # Axisymmetric about a: I = I_a a a^T + I_t (1 - a a^T).
    I_a = a @ I_com @ a
    I_t = (np.trace(I_com) - I_a) / 2
    symmetric = I_a * np.outer(a, a) + I_t * (np.eye(3) - np.outer(a, a))
    error = np.abs(I_com - symmetric).max()
    if error > BALANCE * inertia:
        warnings.append(
            f"wheel on joint '{joint.name}': the rotor is not axisymmetric about its "
            f"axis (off by {error:.4g} of {inertia:.4g} kg m^2); it is counted in the "
            "base as at q = 0"
        )
    return tuple(warnings)
