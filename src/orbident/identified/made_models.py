"""The identified robot as an object of another library; nothing else imports these."""

from typing import Any

import numpy as np

from orbident.estimation.result import Result
from orbident.extras import extra
from orbident.identified.exported_robot import FEATURE_POINT, exported_robot
from orbident.identified.simulator_models import mjcf


def mujoco_spec(result: Result) -> Any:
    """The robot as a `mujoco.MjSpec`, as its MJCF file says it.

    Raises:
        InputError: as `exported_robot`, or mujoco is not installed.
    """
    with extra("mujoco", "to_mujoco()"):
        import mujoco

    text = mjcf(exported_robot(result).mechanism)
    return mujoco.MjSpec.from_string(text)  # pyright: ignore[reportAttributeAccessIssue]: compiled


def pinocchio_model(result: Result) -> Any:
    """The robot as a `pinocchio.Model` without gravity.

    Its joint `root_joint` is a free flyer, or in the plane a planar joint; bodies and
    S are frames.

    Raises:
        InputError: as `exported_robot`, or pinocchio is not installed.
    """
    with extra("pinocchio", "to_pinocchio()"):
        import pinocchio
    robot = exported_robot(result).mechanism
    # Compiled, without stubs.
    pin: Any = pinocchio
    model = pin.Model()
    model.name = robot.name
    model.gravity.linear = np.zeros(3)
    free = pin.JointModelFreeFlyer()
    root = pin.JointModelPlanar() if robot.motion == "planar" else free
    moving = [model.addJoint(0, root, pin.SE3.Identity(), "root_joint")]
    for joint in robot.joints:
        turns = joint.kind == "revolute"
        kind = (
            pin.JointModelRevoluteUnaligned
            if turns
            else pin.JointModelPrismaticUnaligned
        )
        at = pin.SE3(joint.R_PJ, joint.p_PJ)
        low, high = joint.position or (-np.inf, np.inf)
        speed = np.inf if joint.velocity is None else joint.velocity
        ends = (np.array([x]) for x in (np.inf, speed, low, high))
        parent = moving[joint.parent]
        moving.append(model.addJoint(parent, kind(joint.axis), at, joint.name, *ends))
    for index, name, theta in zip(moving, robot.bodies, robot.theta, strict=True):
        inertia = pin.Inertia.FromDynamicParameters(theta)
        model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        carrier = model.addJointFrame(index)
        model.addBodyFrame(name, index, pin.SE3.Identity(), carrier)
    S = pin.SE3(np.eye(3), robot.feature_point)
    base = model.getFrameId(robot.bodies[0])
    model.addFrame(pin.Frame(FEATURE_POINT, moving[0], base, S, pin.FrameType.OP_FRAME))
    return model
