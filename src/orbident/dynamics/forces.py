"""Generalised forces (Eq. 15): what acts on the robot, over its generalised speeds."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.equations_of_motion import (
    Model,
    model_of,
    velocity_of_S,
)
from orbident.dynamics.inertia import inertia
from orbident.dynamics.kinematics import point_jacobian
from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray


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
    model: Model,
    q: Float[AnyArray, " joints"],
    body: int,
    p: Float[AnyArray, "3"],
) -> Float[AnyArray, "6 speeds"]:
    """`J_0,p` and `J_i,p` (A.1, A.2): how a point of a body moves, over `v`.

    Args:
        model: the robot's.
        q: joint positions, rad or m.
        body: index of the body.
        p: the point in the body's frame, m.

    Returns:
        Rows: velocity of the point, then the body's rate; inertial motions, base axes.

    Raises:
        InputError: `q` is not float64.
    """
    J_S = velocity_of_S(model, inertia(model.tree, model.theta, q))
    relative = point_jacobian(model.tree, q, body, p)
    # What is relative to S has w counted already.
    absolute = jnp.concatenate([J_S[:3], jnp.zeros_like(J_S[3:])])
    return absolute.at[:, 3 : 6 + q.size].add(relative)


@in_float64
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
    model = model_of(robot)
    for body, p, force, moment in wrenches:
        _check_known(robot, body, robot.bodies, "body", "bodies")
        J = compiled_jacobian(model, q, robot.bodies.index(body), p)
        Q += np.asarray(J).T @ np.concatenate([force, moment])
    return Q


compiled_jacobian = compiled(jacobian, static_argnums=2)


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
