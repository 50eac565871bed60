"""Is a mass matrix one that a mechanism can have?"""

from functools import lru_cache
from itertools import chain
from typing import NoReturn

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.files.names import joined
from orbident.model.core_robot import KEPT, core_robot
from orbident.model.equations_of_motion import equations_of_motion, movable
from orbident.model.kinematics import inertia
from orbident.robot.description import Robot

SINGULAR = 1e-12
"""Least eigenvalue of a mass matrix with unit diagonal: real arms reach 1e-6, rounding
leaves 1e-16."""

CONFIGURATIONS = 1024
"""Random configurations in which an identified mass matrix is checked."""


class IndefiniteError(InputError):
    """With the identified parameters some motion has no energy, or less."""


@lru_cache(maxsize=KEPT)
def check_regular(robot: Robot) -> None:
    """Refuse a robot whose nominal mass matrix is singular.

    Measured joints move whatever swings behind them, so that those and passive ones are
    judged apart.

    Raises:
        InputError: some motion of base and joints moves no mass at all.
    """
    q = np.random.default_rng(0).standard_normal(len(robot.joints))
    free = [2] if robot.motion == "planar" else [0, 1, 2]
    H = inertia(robot, q[None]).energy(free)[0]
    names = [f"the base about {'xyz'[k]}" for k in free]
    names += [f"joint '{name}'" for name in robot.joint_names]
    base, carried = _sizes(robot, q)
    sizes = np.concatenate([np.full(len(free), base), carried])
    scale = np.abs(np.diag(H))
    # Without any mass nothing is a number.
    still = ~(scale > SINGULAR * sizes)
    if still.any():
        _refuse_nominal(robot, names[int(still.argmax())])
    unit = H / np.sqrt(np.outer(scale, scale))
    swings = np.isin(robot.joint_names, [*robot.passive])
    for joints in (~swings, swings):
        of = np.flatnonzero([*np.ones_like(free, bool), *joints])
        values, vectors = np.linalg.eigh(unit[np.ix_(of, of)])
        smallest = int(np.abs(values).argmin())
        if abs(values[smallest]) <= SINGULAR:
            who = of[np.abs(vectors[:, smallest]).argmax()]
            _refuse_nominal(robot, names[who])


def _sizes(
    robot: Robot, q: Float[np.ndarray, " joints"]
) -> tuple[float, Float[np.ndarray, " joints"]]:
    """What the diagonal of base and joints is made of, before anything cancels."""
    m, _, J = (part[0] for part in _core.masses(core_robot(robot), q[None], True))
    spread = np.trace(J, axis1=1, axis2=2)
    turns = np.array([joint.kind == "revolute" for joint in robot.joints], dtype=bool)
    return float(spread[0]), np.where(turns, spread[1:], m[1:])


def _refuse_nominal(robot: Robot, who: str) -> NoReturn:
    raise InputError(
        f"{robot.name}: the mass matrix is singular: {who} can turn or slide without "
        "moving any mass; give the links beyond it an inertia, or make the joint fixed"
    )


def check_definite(robot: Robot) -> None:
    """Refuse a mass matrix `H+` that gives some motion no energy, or less.

    With the identified `theta` it is checked all over its joints' ranges.

    Raises:
        IndefiniteError: somewhere it is not positive definite.
        InputError: nor can it be, as a body between two joints has no mass.
    """
    may, q = movable(robot), _configurations(robot)
    H, _, _ = equations_of_motion(robot, q, np.zeros((len(q), may.size)))
    H = H[:, may][:, :, may]
    turns = (f"the base about {k}" for k in "xyz")
    moving = ["the base"] * 3, turns, robot.joint_names, robot.wheel_names
    names = [name for name, is_free in zip(chain(*moving), may, strict=True) if is_free]
    scale = np.diagonal(H, axis1=1, axis2=2)
    if (scale <= 0).any():
        state, speed = np.argwhere(scale <= 0)[0]
        _refuse_identified(robot, names[speed], q[state])
    root = np.sqrt(scale)
    values, vectors = np.linalg.eigh(H / root[:, :, None] / root[:, None, :])
    state = int(values[:, 0].argmin())
    if values[state, 0] <= SINGULAR:
        speed = int(np.abs(vectors[state, :, 0]).argmax())
        _refuse_identified(robot, names[speed], q[state])


def _configurations(robot: Robot) -> Float[np.ndarray, "n joints"]:
    ends = [joint.position or (-np.pi, np.pi) for joint in robot.joints]
    low, high = np.clip(np.reshape(ends, (-1, 2)).T, -np.pi, np.pi)
    return np.random.default_rng(0).uniform(low, high, (CONFIGURATIONS, low.size))


def _refuse_identified(
    robot: Robot, who: str, q: Float[np.ndarray, " joints"]
) -> NoReturn:
    if any(each.massless for each in robot.structure.values()):
        raise InputError(
            f"{robot.name}: {who} can turn or slide without moving any mass, as behind "
            "the motor of a flexible joint: there is no H+ of such a robot"
        )
    at = joined(f"{x:.3g}" for x in q)
    raise IndefiniteError(
        f"{robot.name}: with the identified parameters H+ is singular or indefinite at "
        f"q = [{at}], mostly in '{who}', and no bodies that can exist are near; the "
        "recording determines them too badly: excite the robot more"
    )
