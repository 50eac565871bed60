"""Columns of what simulators log: MuJoCo's states, and Basilisk's recorders."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.recordings.topics.targets import of_mrp
from orbident.robot.description import Robot

FREE = 0
"""`mjJNT_FREE`: a joint of MuJoCo with seven numbers in qpos and six in qvel."""


def columns_of_mujoco(
    robot: Robot,
    model: Any,
    qpos: Float[np.ndarray, "samples nq"],
    qvel: Float[np.ndarray, "samples nv"],
) -> dict[str, np.ndarray]:
    """Columns as perfect sensors would show them, SI; S is the robot's.

    Raises:
        InputError: the arrays are not the model's, or it lacks a joint of the robot.
    """
    for name, x, width in (("qpos", qpos, model.nq), ("qvel", qvel, model.nv)):
        if x.ndim != 2 or x.shape[1] != width:
            raise InputError(
                f"MuJoCo: {name} has shape {x.shape}; give samples by {width}, what "
                "the model has"
            )
    free = np.flatnonzero(model.jnt_type == FREE)
    if free.size != 1:
        raise InputError(
            f"MuJoCo: the model has {free.size} free joints; give one whose base "
            "floats on a free joint, and nothing else"
        )
    x, v = (int(at[free[0]]) for at in (model.jnt_qposadr, model.jnt_dofadr))
    moved = qpos[:, x : x + 3], qvel[:, v : v + 3], qvel[:, v + 3 : v + 6]
    # MuJoCo's quaternions have the scalar first.
    columns = _of_base(robot, np.roll(qpos[:, x + 3 : x + 7], -1, axis=1), *moved)
    joints = (model.joint(k) for k in range(model.njnt))
    places = {joint.name: joint.id for joint in joints if joint.name}
    measured = [name for name in robot.joint_names if name not in robot.passive]
    for name in [*measured, *robot.wheel_names]:
        if name not in places:
            raise InputError(
                f"MuJoCo: the model has no joint '{name}', only {listed(places)}; name "
                "joints and wheels as the robot does"
            )
        angle = qpos[:, model.jnt_qposadr[places[name]]]
        rate = qvel[:, model.jnt_dofadr[places[name]]]
        if name in robot.wheel_names:
            columns[f"wheel.{name}.speed"] = rate
        else:
            columns |= {f"joint.{name}.position": angle, f"joint.{name}.velocity": rate}
    return columns


def _of_base(
    robot: Robot,
    attitude: Float[np.ndarray, "samples 4"],
    p_WB_W: Float[np.ndarray, "samples 3"],
    v_WB_W: Float[np.ndarray, "samples 3"],
    w_WB_B: Float[np.ndarray, "samples 3"],
) -> dict[str, np.ndarray]:
    """`p_WS = p_WB + R_WB p_BS` and `v_WS = v_WB + R_WB (w x p_BS)`."""
    R_WB = quaternion_matrix(attitude)
    p_BS_B = np.broadcast_to(robot.feature_point, w_WB_B.shape)
    return {
        "gyro": w_WB_B,
        "attitude": attitude,
        "position": p_WB_W + rotate(R_WB, p_BS_B),
        "velocity": v_WB_W + rotate(R_WB, np.cross(w_WB_B, p_BS_B)),
    }


OF_JOINTS = {"revolute": ("theta", "thetaDot"), "prismatic": ("rho", "rhoDot")}
"""Basilisk's names of how far and how fast a spinning or translating body is."""


def columns_of_basilisk(
    robot: Robot, states: Any, wheels: Any, joints: Sequence[Any]
) -> dict[str, np.ndarray]:
    """Columns with `t`, SI; the hub's origin B is the base link's, and S the robot's.

    Raises:
        InputError: There are more or fewer wheels or joints than the robot has, or a
            recorder has other times.
    """
    ns = np.asarray(states.times())
    for recorder in [*joints, *([] if wheels is None else [wheels])]:
        if not np.array_equal(recorder.times(), ns):
            raise InputError(
                "Basilisk: a recorder of wheels or joints has other times than that of "
                "the states; record all in one task"
            )
    speeds = np.empty((ns.size, 0)) if wheels is None else np.array(wheels.wheelSpeeds)
    # Basilisk's message has room for more wheels than there are.
    of_wheels, more = np.split(speeds, [len(robot.wheels)], axis=1)
    for kind, parts, given in (
        ("wheels", robot.wheels, of_wheels.shape[1] + int(more.any(axis=0).sum())),
        ("joints", robot.joints, len(joints)),
    ):
        if given != len(parts):
            raise InputError(
                f"Basilisk: there are recorders of {given} {kind}, and the robot has "
                f"{len(parts)}; give all of them in the robot's order"
            )
    moved = map(np.asarray, (states.r_BN_N, states.v_BN_N, states.omega_BN_B))
    columns = _of_base(robot, of_mrp(np.asarray(states.sigma_BN)), *moved)
    columns["t"] = ns * 1e-9
    names = robot.wheel_names
    columns |= {f"wheel.{n}.speed": x for n, x in zip(names, of_wheels.T, strict=True)}
    for joint, recorder in zip(robot.joints, joints, strict=True):
        for word, field in zip(
            ("position", "velocity"), OF_JOINTS[joint.kind], strict=True
        ):
            values = np.asarray(getattr(recorder, field)).reshape(ns.size)
            columns[f"joint.{joint.name}.{word}"] = values
    return columns
