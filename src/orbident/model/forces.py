"""Generalised forces (Eq. 15): what acts on the robot, over its generalised speeds."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.model.equations_of_motion import velocity_of_S
from orbident.model.kinematics import point_jacobian
from orbident.robot.description import Robot


class Wrench(NamedTuple):
    """A force and a moment on a body of the robot."""

    body: str
    point: Float[np.ndarray, "3"]
    """Where the force acts, in the body's frame, m."""
    force: Float[np.ndarray, "3"]
    """Base axes, N."""
    moment: Float[np.ndarray, "3"]
    """Base axes, N m."""


def jacobian(
    robot: Robot,
    q: Float[np.ndarray, " joints"],
    body: int,
    p: Float[np.ndarray, "3"],
) -> Float[np.ndarray, "6 speeds"]:
    """`J_0,p` and `J_i,p` (A.1, A.2): how a point of a body moves, over `v`.

    Args:
        robot: its `theta` decides where the CM is.
        q: joint positions, rad or m.
        body: index of the body.
        p: the point in the body's frame, m.

    Returns:
        Rows: velocity of the point, then the body's rate; inertial motions, base axes.
    """
    J = velocity_of_S(robot, q)
    # The rows relative to S contain the base rate already.
    J[3:] = 0.0
    J[:, 3 : 6 + q.size] += point_jacobian(robot, q, body, p)
    return J


def generalised_forces(
    robot: Robot,
    q: Float[np.ndarray, " joints"],
    joint_torques: Mapping[str, float],
    wheel_torques: Mapping[str, float],
    wrenches: Sequence[Wrench] = (),
) -> Float[np.ndarray, " speeds"]:
    """`Q = [0, 0, tau, tau_rw] + sum J^T F` (Eq. 15).

    Args:
        robot: with its nominal inertia.
        q: joint positions, rad or m.
        joint_torques: by joint name, N m or N; zero where absent.
        wheel_torques: on the rotor, by wheel name, N m; zero where absent.
        wrenches: what acts from outside.

    Raises:
        InputError: a joint, a wheel or a body is not the robot's.
    """
    tau = _in_order(robot, joint_torques, robot.joint_names, "joint")
    tau_rw = _in_order(robot, wheel_torques, robot.wheel_names, "wheel")
    Q = np.concatenate([np.zeros(6), tau, tau_rw])
    for body, p, force, moment in wrenches:
        _check_known(robot, body, robot.bodies, "body", "bodies")
        J = jacobian(robot, q, robot.bodies.index(body), p)
        Q += J.T @ np.concatenate([force, moment])
    return Q


def _in_order(
    robot: Robot, torques: Mapping[str, float], names: Sequence[str], what: str
) -> Float[np.ndarray, " actuators"]:
    for name in torques:
        _check_known(robot, name, names, what, f"{what}s")
    return np.array([torques.get(name, 0.0) for name in names])


def _check_known(
    robot: Robot, name: str, names: Sequence[str], what: str, plural: str
) -> None:
    if name not in names:
        raise InputError(
            f"{robot.name}: no {what} '{name}'; " + suggestion(name, names, plural)
        )
