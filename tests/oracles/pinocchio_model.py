"""An orbident robot as a Pinocchio model, floating without gravity."""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from orbident.robot.description import Robot


class PinocchioRobot(NamedTuple):
    """The model, and where orbident's bodies and joints are in it."""

    model: pin.Model
    bodies: list[int]
    """Joint index of each body; the base is carried by the free flyer."""
    rows: np.ndarray
    """Index into `v` of the rates `[v_S, w, qd]`, in orbident's order of the joints."""

    def q(self, q: np.ndarray) -> np.ndarray:
        """The configuration with the base's frame at the origin, and level."""
        configuration = pin.neutral(self.model)
        configuration[self.rows[6:] + 1] = q
        return configuration

    def v(self, w: np.ndarray, qd: np.ndarray) -> np.ndarray:
        """The velocity with S at rest."""
        velocity = np.zeros(self.model.nv)
        velocity[self.rows] = np.concatenate([np.zeros(3), w, qd])
        return velocity


def pinocchio_model(robot: Robot) -> PinocchioRobot:
    """A free flyer with the robot's joints, added depth first as Pinocchio wants."""
    model = pin.Model()
    model.gravity.linear = np.zeros(3)
    bodies = {0: model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "S")}

    def add_children(parent: int) -> None:
        model.appendBodyToJoint(
            bodies[parent],
            pin.Inertia.FromDynamicParameters(robot.theta[parent]),
            pin.SE3.Identity(),
        )
        for k, joint in enumerate(robot.joints):
            if joint.parent == parent:
                kind = (
                    pin.JointModelRevoluteUnaligned
                    if joint.kind == "revolute"
                    else pin.JointModelPrismaticUnaligned
                )
                placement = pin.SE3(joint.R_PJ, joint.p_PJ)
                bodies[k + 1] = model.addJoint(
                    bodies[parent], kind(joint.axis), placement, joint.name
                )
                add_children(k + 1)

    add_children(0)
    order = [bodies[i] for i in range(len(robot.bodies))]
    rows = [*range(6), *(model.joints[i].idx_v for i in order[1:])]
    return PinocchioRobot(model, order, np.array(rows))
