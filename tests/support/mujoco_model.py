"""An orbident robot as a MuJoCo model, floating without gravity."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Iterable

import mujoco
import numpy as np

from orbident.robot.description import Robot, Wheel
from orbident.robot.parameters import from_mass_com_inertia, inertia_about_com

WHEEL_MASS = 0.5

PLANE = ("x", "y", "turn")
"""The joints of a base on a table."""


def mujoco_model(robot: Robot, wheel_positions: Iterable[np.ndarray]) -> mujoco.MjModel:
    """Hinges and slides on a free joint or, in the plane, on three; wheels are bodies.

    What the wheels weigh is taken out of the base: the robot counts it there.

    Args:
        robot: its wheels become hinges on the base.
        wheel_positions: of the wheels' CMs from S, base axes, m: any.
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = np.zeros(3)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    base = spec.worldbody.add_body(name=robot.bodies[0])
    if robot.motion == "planar":
        for name, axis in zip(PLANE, np.eye(3), strict=True):
            kind = "HINGE" if name == "turn" else "SLIDE"
            kind = getattr(mujoco.mjtJoint, f"mjJNT_{kind}")
            base.add_joint(name=name, type=kind, axis=axis)
    else:
        base.add_freejoint()
    theta_0 = robot.theta[0]
    for wheel, p in zip(robot.wheels, wheel_positions, strict=True):
        I = wheel_inertia(wheel)
        theta_0 = theta_0 - from_mass_com_inertia(WHEEL_MASS, p, I)
        body = base.add_body(name=wheel.name, pos=p)
        hinge = mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(name=wheel.name, type=hinge, axis=wheel.axis)
        give_inertia(body, from_mass_com_inertia(WHEEL_MASS, np.zeros(3), I))
    give_inertia(base, theta_0)
    bodies = [base]
    for joint, theta_i in zip(robot.joints, robot.theta[1:], strict=True):
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, joint.R_PJ.ravel())
        name = robot.bodies[len(bodies)]
        body = bodies[joint.parent].add_body(name=name, pos=joint.p_PJ, quat=quat)
        kind = "HINGE" if joint.kind == "revolute" else "SLIDE"
        body.add_joint(
            name=joint.name,
            type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"),
            axis=joint.axis,
        )
        give_inertia(body, theta_i)
        bodies.append(body)
    return spec.compile()


def wheel_inertia(wheel: Wheel) -> np.ndarray:
    """Symmetric about the axis; across it a little more than a thin disc, 0.5."""
    across = np.eye(3) - np.outer(wheel.axis, wheel.axis)
    return wheel.inertia * (np.outer(wheel.axis, wheel.axis) + 0.6 * across)


def give_inertia(body: mujoco.MjsBody, theta_i: np.ndarray) -> None:
    """Principal moments and axes are found here, not to MuJoCo's 1e-12."""
    moments, axes = np.linalg.eigh(inertia_about_com(theta_i))
    axes = axes * np.linalg.det(axes)
    body.explicitinertial = True
    body.mass = theta_i[0]
    body.ipos = theta_i[1:4] / theta_i[0]
    body.inertia = moments
    mujoco.mju_mat2Quat(body.iquat, axes.ravel())
