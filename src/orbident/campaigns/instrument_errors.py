"""Instruments and joints that are not as the robot file says, within its tolerances.

An error is named as the unknown that stands for it, and has the same sign: the truth is
what the unknown makes of the shown.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from orbident.robot.description import Robot
from orbident.robot.tolerances import CALIBRATION_KINDS
from orbident.simulation.truth import Truth

Errors = Mapping[str, float]
"""The errors of instruments by their names, SI; one that is absent is zero."""


def moved_joints(robot: Robot, errors: Errors) -> Robot:
    """The robot whose joints are elsewhere and whose wheels are heavier."""
    joints = tuple(
        replace(
            joint,
            p_PJ=joint.p_PJ + _drawn(errors, "joint_place", joint.name),
            R_PJ=_rotation(errors, "joint_direction", joint.name) @ joint.R_PJ,
        )
        for joint in robot.joints
    )
    wheels = tuple(
        replace(wheel, inertia=wheel.inertia * (1 + float(share)))
        for wheel in robot.wheels
        for share in _drawn(errors, "wheel_inertia", wheel.name)
    )
    return replace(robot, joints=joints, wheels=wheels)


def with_instrument_errors(
    robot: Robot, t: Float[np.ndarray, " rows"], true: Truth, errors: Errors
) -> Truth:
    """What instruments with these errors would show without noise.

    Args:
        robot: whose joints are named.
        t: of the rows, s.
        true: at these times.
        errors: of instruments; those of geometry are `moved_joints`.
    """
    zero, scale = (
        np.ravel([_drawn(errors, kind, name) for name in robot.joint_names])
        for kind in ("joint_zero", "joint_scale")
    )
    gain = 1 + scale
    point = _drawn(errors, "feature_point")
    R_BS = _rotation(errors, "gyro_misalignment")
    turn = Rotation.from_matrix(_rotation(errors, "attitude_misalignment"))
    R_WB = Rotation.from_quat(true.attitude)

    def late(clock: str, x: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "rows n"]:
        (by,) = _drawn(errors, f"{clock}_clock")
        # The motion is smooth, and so is the quintic through all its samples.
        return x if by == 0.0 or x.size == 0 else make_interp_spline(t, x, 5)(t - by)

    turned = (R_WB * turn).as_quat()
    lever = R_WB.apply(np.cross(true.gyro, point))
    size = 1 + _drawn(errors, "position_scale")
    return true._replace(
        q=(late("joint", true.q) - zero) / gain,
        qd=late("joint", true.qd) / gain,
        q_rw=late("joint", true.q_rw),
        qd_rw=late("joint", true.qd_rw),
        gyro=(1 + _drawn(errors, "gyro_scale")) * (true.gyro @ R_BS),
        attitude=_unit(late("attitude", turned)),
        position=size * late("position", true.position + R_WB.apply(point)),
        velocity=true.velocity + lever,
    )


def _drawn(errors: Errors, kind: str, of: str = "") -> Float[np.ndarray, " axes"]:
    """The errors of one kind, of one joint or wheel where each has its own."""
    names = CALIBRATION_KINDS[kind].names(of)
    return np.array([errors.get(name, 0.0) for name in names])


def _rotation(errors: Errors, kind: str, of: str = "") -> Float[np.ndarray, "3 3"]:
    return Rotation.from_rotvec(_drawn(errors, kind, of)).as_matrix()


def _unit(x: Float[np.ndarray, "rows 4"]) -> Float[np.ndarray, "rows 4"]:
    return x / np.linalg.norm(x, axis=1, keepdims=True)
