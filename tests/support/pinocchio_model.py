"""An orbident robot as a Pinocchio model, floating without gravity."""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Sequence
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


def paper_equations(
    model: pin.Model, joints: Sequence[str], q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`H+` and `c+` over the paper's speeds, as in `test_equations_of_motion`.

    Args:
        model: with a free flyer, whose frame may be anywhere, or in the plane a planar
            joint: then the speeds out of the plane have no rows.
        joints: names, in the order of `q` and of the end of `v`.
        q: positions of all joints.
        v: `[v_cm, w, qd]`.
    """
    named = [model.joints[model.getJointId(name)] for name in joints]
    root = [0, 1, 5] if model.joints[1].nv == 3 else list(range(6))
    v = np.concatenate([v[root], v[6:]])
    rows = np.array([*range(len(root)), *(joint.idx_v for joint in named)])
    at = pin.neutral(model)
    for joint, angle in zip(named, q, strict=True):
        if joint.nq == 2:
            at[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        else:
            at[joint.idx_q] = angle
    data = model.createData()
    pin.jacobianCenterOfMass(model, data, at)
    # The speeds are those of the system CM.
    T, moving = np.eye(v.size), 2 if len(root) == 3 else 3
    T[:moving, moving:] = -data.Jcom[:moving, rows[moving:]]
    rates = np.zeros(model.nv)
    rates[rows] = T @ v
    upper = np.triu(pin.crba(model, data, at))
    H = (upper + np.triu(upper, 1).T)[np.ix_(rows, rows)]
    pin.centerOfMass(model, data, at, rates, np.zeros(model.nv))
    w, v_cm = np.zeros(3), np.zeros(3)
    w[-(len(root) - moving) :] = v[moving : len(root)]
    v_cm[:moving] = v[:moving]
    drift = np.zeros(v.size)
    drift[:moving] = (np.cross(w, v_cm) - data.acom[0])[:moving]
    c = H @ drift + pin.nonLinearEffects(model, data, at, rates)[rows]
    return T.T @ H @ T, T.T @ c
