"""Instruments and joints that are not as the robot file says, within its tolerances.

An error is named as `estimation/output_error/calibration.py` names the unknown that
stands for it, and has the same sign: the truth is what the unknown makes of the shown.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from orbident.robot.description import Robot
from orbident.simulation.truth import Truth

Errors = Mapping[str, float]
"""The errors of instruments by their names, SI; one that is absent is zero."""


def moved_joints(robot: Robot, errors: Errors) -> Robot:
    """The robot whose joints are elsewhere and whose wheels are heavier."""
    joints = tuple(
        replace(
            joint,
            p_PJ=joint.p_PJ + _vector(errors, f"joint.{joint.name}.place"),
            R_PJ=_rotation(errors, f"joint.{joint.name}.direction") @ joint.R_PJ,
        )
        for joint in robot.joints
    )
    wheels = tuple(
        replace(
            wheel,
            inertia=wheel.inertia * (1 + errors.get(f"wheel.{wheel.name}.inertia", 0)),
        )
        for wheel in robot.wheels
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
    names = robot.joint_names
    zero = np.array([errors.get(f"joint.{name}.zero", 0.0) for name in names])
    gain = 1 + np.array([errors.get(f"joint.{name}.scale", 0.0) for name in names])
    point = _vector(errors, "feature_point")
    R_BS = _rotation(errors, "gyro.misalignment")
    turn = Rotation.from_matrix(_rotation(errors, "attitude.misalignment"))
    R_WB = Rotation.from_quat(true.attitude)

    def late(clock: str, x: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "rows n"]:
        by = errors.get(f"{clock}.clock", 0.0)
        # The motion is smooth, and so is the quintic through all its samples.
        return x if by == 0.0 or x.size == 0 else make_interp_spline(t, x, 5)(t - by)

    turned = (R_WB * turn).as_quat()
    lever = R_WB.apply(np.cross(true.gyro, point))
    scale = 1 + errors.get("position.scale", 0.0)
    return true._replace(
        q=(late("joints", true.q) - zero) / gain,
        qd=late("joints", true.qd) / gain,
        q_rw=late("joints", true.q_rw),
        qd_rw=late("joints", true.qd_rw),
        gyro=(1 + _vector(errors, "gyro.scale")) * (true.gyro @ R_BS),
        attitude=_unit(late("attitude", turned)),
        position=scale * late("position", true.position + R_WB.apply(point)),
        velocity=true.velocity + lever,
    )


def _vector(errors: Errors, name: str) -> Float[np.ndarray, "3"]:
    return np.array([errors.get(f"{name}.{axis}", 0.0) for axis in "xyz"])


def _rotation(errors: Errors, name: str) -> Float[np.ndarray, "3 3"]:
    return Rotation.from_rotvec(_vector(errors, name)).as_matrix()


def _unit(x: Float[np.ndarray, "rows 4"]) -> Float[np.ndarray, "rows 4"]:
    return x / np.linalg.norm(x, axis=1, keepdims=True)
