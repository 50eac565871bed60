"""Is `H+` that of a mechanism, all over the joints' ranges?"""

from collections.abc import Callable
from itertools import chain

import numpy as np
from jaxtyping import Float

from orbident.dynamics.batches import BATCH
from orbident.dynamics.equations_of_motion import Model
from orbident.errors import InputError
from orbident.robot.description import Robot

SINGULAR = 1e-12
"""Of the mass matrix with unit diagonal: rounding is 1e-16."""


def check_definite(
    robot: Robot,
    model: Model,
    H_plus: Callable[
        [Float[np.ndarray, "n joints"]], Float[np.ndarray, "n speeds speeds"]
    ],
) -> None:
    """Refuse a mass matrix that gives some motion no energy, or less.

    Args:
        robot: for the names and ranges of its joints.
        model: says what may move.
        H_plus: the matrix to be checked, by joint positions.

    Raises:
        InputError: somewhere it is not positive definite.
    """
    free, q = np.asarray(model.free) > 0, _configurations(robot)
    H = H_plus(q)[:, free][:, :, free]
    turns = (f"the base about {k}" for k in "xyz")
    moving = ["the base"] * 3, turns, robot.joint_names, robot.wheel_names
    names = [name for name, may in zip(chain(*moving), free, strict=True) if may]
    scale = np.diagonal(H, axis1=1, axis2=2)
    if (scale <= 0).any():
        state, speed = np.argwhere(scale <= 0)[0]
        _refuse(robot, names[speed], q[state])
    root = np.sqrt(scale)
    values, vectors = np.linalg.eigh(H / root[:, :, None] / root[:, None, :])
    state = int(values[:, 0].argmin())
    if values[state, 0] <= SINGULAR:
        speed = int(np.abs(vectors[state, :, 0]).argmax())
        _refuse(robot, names[speed], q[state])


def _configurations(robot: Robot) -> Float[np.ndarray, "n joints"]:
    """All over the joints' ranges."""
    ends = [joint.position or (-np.pi, np.pi) for joint in robot.joints]
    low, high = np.clip(np.reshape(ends, (-1, 2)).T, -np.pi, np.pi)
    return np.random.default_rng(0).uniform(low, high, (BATCH, low.size))


def _refuse(robot: Robot, who: str, q: Float[np.ndarray, " joints"]) -> None:
    at = ", ".join(f"{x:.3g}" for x in q)
    raise InputError(
        f"{robot.name}: with the identified parameters H+ is singular or indefinite at "
        f"q = [{at}], mostly in '{who}'; the recording determines them too badly: "
        "excite the robot more, or export the nearest physical model"
    )
