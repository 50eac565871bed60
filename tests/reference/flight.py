"""A free-flying robot under its control laws, as Eqs. 13 and 15 and the laws read."""

from typing import NamedTuple

import numpy as np
from obvious_momentum import quaternion_rotation
from reference import newton_euler
from reference.runge_kutta import quaternion_rate

from orbident.robot.description import Robot


class Laws(NamedTuple):
    """`tau` and `tau_rw`, with gains and commands."""

    Kp: np.ndarray
    Kd: np.ndarray
    k: np.ndarray
    speed: np.ndarray
    share: np.ndarray
    kp: float
    kd: float
    x_WD: np.ndarray
    torque_limit: np.ndarray
    speed_limit: np.ndarray


class Commanded(NamedTuple):
    """What is commanded at one time."""

    q: np.ndarray
    qd: np.ndarray
    tau: np.ndarray
    tau_rw: np.ndarray
    wrenches: np.ndarray
    """Force and moment of each, base axes."""


def conjugate_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """`conj(a) b`, scalar last."""
    vector = a[3] * b[:3] - b[3] * a[:3] - np.cross(a[:3], b[:3])
    return np.append(vector, a @ b)


def torques(laws: Laws, commanded: Commanded, q, x_WB, w, qd, qd_rw) -> np.ndarray:
    """The torques of the joints, and on the rotors within their motors' limits."""
    tau = laws.Kp * (commanded.q - q) + laws.Kd * (commanded.qd - qd) + commanded.tau
    turned = conjugate_product(laws.x_WD, x_WB)
    e = 2 * turned[:3] * (-1 if turned[3] < 0 else 1)
    tau_rw = laws.k * (laws.speed - qd_rw) + laws.share @ (laws.kp * e + laws.kd * w)
    tau_rw = np.clip(tau_rw + commanded.tau_rw, -laws.torque_limit, laws.torque_limit)
    left = 1 - np.sign(tau_rw) * qd_rw / laws.speed_limit
    return np.append(tau, tau_rw * np.clip(left / 0.02, 0, 1))


def rate(
    robot: Robot, laws: Laws, free: np.ndarray, points, commanded: Commanded, state
) -> np.ndarray:
    """The derivative of `[r_cm, x_WB, q, q_rw, v]`."""
    joints, wheels = len(robot.joints), len(robot.wheels)
    ends = np.cumsum([3, 4, joints, wheels])
    _, x_WB, q, _, v = np.split(state, ends)
    v_cm, w, qd, qd_rw = np.split(v, [3, 6, 6 + joints])
    Q = np.append(np.zeros(6), torques(laws, commanded, q, x_WB, w, qd, qd_rw))
    for (body, point), wrench in zip(points, commanded.wrenches, strict=True):
        Q += newton_euler.wrench_force(robot, q, body, point, wrench[:3], wrench[3:])
    vd, _ = newton_euler.forward_dynamics(robot, q, v, Q, np.zeros(v.size), free)
    R_WB = quaternion_rotation(x_WB / np.linalg.norm(x_WB))
    return np.concatenate([R_WB @ v_cm, quaternion_rate(x_WB, w), qd, qd_rw, vd])
