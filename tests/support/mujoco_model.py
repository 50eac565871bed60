"""An orbident robot as a MuJoCo model, floating without gravity.

Wheels and motors' rotors are bodies of their own, and what they weigh is taken out of
the body that carries them: the robot counts it there.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Iterable

import mujoco
import numpy as np

from orbident.robot.description import Robot
from orbident.robot.parameters import from_mass_com_inertia, inertia_about_com

WHEEL_MASS = 0.5
ROTOR_MASS = 0.05

PLANE = ("x", "y", "turn")
"""The joints of a base on a table."""


def mujoco_model(robot: Robot, wheel_positions: Iterable[np.ndarray]) -> mujoco.MjModel:
    """What `mujoco_spec` describes, compiled."""
    return mujoco_spec(robot, wheel_positions).compile()


def mujoco_spec(robot: Robot, wheel_positions: Iterable[np.ndarray]) -> mujoco.MjSpec:
    """Hinges and slides on a free joint or, in the plane, on three.

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
    theta, bodies = robot.theta.copy(), [base]
    for wheel, p in zip(robot.wheels, wheel_positions, strict=True):
        I = about_axis(wheel.inertia, wheel.axis)
        theta[0] -= add_spinning(base, wheel.name, p, wheel.axis, WHEEL_MASS, I)
    for joint in robot.joints:
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
        bodies.append(body)
        rotor = robot.rotors.get(joint.name)
        if rotor is not None and rotor.inertia:
            a, name = joint.R_PJ @ joint.axis, rotor_name(joint.name)
            I, place = about_axis(rotor.inertia, a), (joint.p_PJ, a, ROTOR_MASS)
            carrier = bodies[joint.parent]
            theta[joint.parent] -= add_spinning(carrier, name, *place, I)
    for body, theta_i in zip(bodies, theta, strict=True):
        give_inertia(body, theta_i)
    return spec


def rotor_name(joint: str) -> str:
    """The name of the rotor of a joint's motor, and of its hinge."""
    return f"{joint}_rotor"


def add_spinning(
    carrier: mujoco.MjsBody,
    name: str,
    p: np.ndarray,
    axis: np.ndarray,
    mass: float,
    I: np.ndarray,
) -> np.ndarray:
    """Put a wheel or a rotor on a body; its ten parameters in that body's frame."""
    body = carrier.add_body(name=name, pos=p)
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
    give_inertia(body, from_mass_com_inertia(mass, np.zeros(3), I))
    return from_mass_com_inertia(mass, p, I)


def about_axis(inertia: float, a: np.ndarray) -> np.ndarray:
    """Symmetric about the axis; across it a little more than a thin disc, 0.5."""
    across = np.eye(3) - np.outer(a, a)
    return inertia * (np.outer(a, a) + 0.6 * across)


def give_inertia(body: mujoco.MjsBody, theta_i: np.ndarray) -> None:
    """Principal moments and axes are found here, not to MuJoCo's 1e-12."""
    moments, axes = np.linalg.eigh(inertia_about_com(theta_i))
    axes = axes * np.linalg.det(axes)
    body.explicitinertial = True
    body.mass = theta_i[0]
    body.ipos = theta_i[1:4] / theta_i[0]
    body.inertia = moments
    mujoco.mju_mat2Quat(body.iquat, axes.ravel())
