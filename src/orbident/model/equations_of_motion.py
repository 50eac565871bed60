"""The free-flying equations of motion, `H+ v' + c+ = Q` (Eqs. 8-15).

Generalised speeds `v = [v_cm, w, qd, qd_rw]`: the velocity of the system CM, the base
rate, the joint rates, and the wheels' speeds relative to the base; `v_cm` and `w` are
inertial motions in base axes, and `v'` is the derivative of these components. `Q` are
the generalised forces: what acts on the robot, over these speeds.

Not every mass matrix is one that a mechanism can have.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import chain
from typing import NamedTuple, NoReturn

import numpy as np
from jaxtyping import Bool, Float

from orbident import _core
from orbident.errors import InputError
from orbident.files.names import joined, suggestion
from orbident.model.core_robot import KEPT, core_robot, rotors_of, spinning_rotors
from orbident.model.kinematics import carrying_joints, inertia, inertia_at, poses
from orbident.robot.description import Robot
from orbident.robot.parameters import cross_matrix
from orbident.threads import processors

OUT_OF_PLANE = [2, 3, 4]
"""Speeds along z, about x and about y: a planar robot has none of them."""


class Equations(NamedTuple):
    """The equations of motion in some states; base axes."""

    H: Float[np.ndarray, "n speeds speeds"]
    """`H+` of Eq. 14."""
    c: Float[np.ndarray, "n speeds"]
    """`c+` of Eq. 13: the forces where `v' = 0`."""
    f_S: Float[np.ndarray, "n 3"]
    """Acceleration of S where `v' = 0`, m/s^2."""


def equations_of_motion(
    robot: Robot, q: Float[np.ndarray, "n joints"], v: Float[np.ndarray, "n speeds"]
) -> Equations:
    """`H+`, `c+` and how S accelerates.

    Joint positions `q` are in rad or m, the speeds `v` in base axes.
    """
    return Equations(*_core.equations_of_motion(core_robot(robot), q, v, processors()))


class Motion(NamedTuple):
    """Accelerations, and the forces that they take; base axes."""

    v_dot: Float[np.ndarray, "n speeds"]
    f_S: Float[np.ndarray, "n 3"]
    """Specific force at S, m/s^2."""
    Q: Float[np.ndarray, "n speeds"]


def motion_with(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    v: Float[np.ndarray, "n speeds"],
    v_dot: Float[np.ndarray, "n speeds"],
    free: Bool[np.ndarray, " speeds"],
) -> Motion:
    """What `H+ v' + c+ = Q` gives where some of `v'` are known, and all other of `Q`.

    Joint positions `q` are in rad or m, the speeds `v` in base axes. No force acts on
    free speeds, whose known `v_dot` is zero.
    """
    core, n = core_robot(robot), processors()
    known, Q = v_dot, np.zeros_like(v)
    v_dot, f_S = _core.forward_dynamics(core, q, v, Q, known, free.astype(float), n)
    at = equations_of_motion(robot, q, v)
    return Motion(v_dot, f_S, np.einsum("nij,nj->ni", at.H, v_dot) + at.c)


def deviations(
    robot: Robot,
    directions: Float[np.ndarray, "directions bodies 10"],
    q: Float[np.ndarray, "n joints"],
    v: Float[np.ndarray, "n speeds"],
) -> tuple[Float[np.ndarray, "n speeds speeds"], Float[np.ndarray, "n speeds"]]:
    """Standard deviations of `H+` and `c+`, of first order.

    The true `theta` is the robot's and a sum of `directions`, each times an independent
    number of unit variance. Joint positions `q` are in rad or m, speeds in base axes.
    """
    return _core.deviations(core_robot(robot), directions, q, v, threads=processors())


def movable(robot: Robot) -> Bool[np.ndarray, " speeds"]:
    """Which speeds may change: not those out of the plane of a planar robot."""
    may = np.ones(speeds(robot), dtype=bool)
    if robot.motion == "planar":
        may[OUT_OF_PLANE] = False
    return may


def speeds(robot: Robot) -> int:
    """The number of generalised speeds."""
    return 6 + len(robot.joints) + len(robot.wheels)


def velocity_of_S(
    robot: Robot, q: Float[np.ndarray, " joints"]
) -> Float[np.ndarray, "6 speeds"]:
    """`J_0,S` (Eqs. 27, 28): `v_S = v_cm - w x r_cm - J_cm qd`, and the base rate."""
    at, J = inertia_at(robot, q), np.zeros((6, speeds(robot)))
    J[:, :6] = np.eye(6)
    J[:3, 3:6] = cross_matrix(at.r_cm)
    J[:3, 6 : 6 + q.size] = -at.J_cm
    return J


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
    robot: Robot, q: Float[np.ndarray, " joints"], body: str, p: Float[np.ndarray, "3"]
) -> Float[np.ndarray, "6 speeds"]:
    """`J_0,p` and `J_i,p` (A.1, A.2): how a point of a body moves, over `v`.

    Joint positions `q` are in rad or m; the point `p` is in the body's frame, m. Rows:
    velocity of the point, then the body's rate; inertial motions, base axes.

    Raises:
        InputError: the body is not the robot's.
    """
    _check_known(robot, body, robot.bodies, "body", "bodies")
    at, index = poses(robot, q[None]), robot.bodies.index(body)
    r, carries = at.arm(index, p)[0], carrying_joints(robot, index)[:, None]
    J, w, of_joints = velocity_of_S(robot, q), slice(3, 6), slice(6, 6 + q.size)
    J[:3, w] -= cross_matrix(r)
    J[:3, of_joints] += (carries * (at.field_u[0] + np.cross(at.field_w[0], r))).T
    J[3:, of_joints] = (carries * at.field_w[0]).T
    return J


def generalised_forces(
    robot: Robot,
    q: Float[np.ndarray, " joints"],
    joint_torques: Mapping[str, float],
    wheel_torques: Mapping[str, float],
    wrenches: Sequence[Wrench] = (),
) -> Float[np.ndarray, " speeds"]:
    """`Q = [0, 0, tau, tau_rw] + sum J^T F` (Eq. 15).

    Joint positions `q` are in rad or m. Torques are by name, N m or N, and zero where
    absent; those of wheels are on the rotor.

    Raises:
        InputError: a joint, a wheel or a body is not the robot's.
    """
    tau = _in_order(robot, joint_torques, robot.joint_names, "joint")
    tau_rw = _in_order(robot, wheel_torques, robot.wheel_names, "wheel")
    Q = np.concatenate([np.zeros(6), tau, tau_rw])
    for body, p, force, moment in wrenches:
        Q += jacobian(robot, q, body, p).T @ np.concatenate([force, moment])
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
    free = list(robot.conserved_axes[0])
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
    for k in spinning_rotors(robot):
        if not rotors_of(robot).armature[k]:
            _refuse_without_mass(robot, robot.joint_names[k])
    may, ends = movable(robot), [j.position or (-np.pi, np.pi) for j in robot.joints]
    low, high = np.clip(np.reshape(ends, (-1, 2)).T, -np.pi, np.pi)
    q = np.random.default_rng(0).uniform(low, high, (CONFIGURATIONS, low.size))
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


def _refuse_without_mass(robot: Robot, who: str) -> NoReturn:
    raise InputError(
        f"{robot.name}: {who} can turn or slide without moving any mass, as the motor "
        "of a flexible joint without a rotor that is known: there is no H+ of such a "
        "robot unless 'rotors' in its file gives the motor one"
    )


def _refuse_identified(
    robot: Robot, who: str, q: Float[np.ndarray, " joints"]
) -> NoReturn:
    if not all(each.has_mass for each in robot.structure.values()):
        _refuse_without_mass(robot, who)
    at = joined(f"{x:.3g}" for x in q)
    raise IndefiniteError(
        f"{robot.name}: with the identified parameters H+ is singular or indefinite at "
        f"q = [{at}], mostly in '{who}', and no bodies that can exist are near; the "
        "recording determines them too badly: excite the robot more"
    )
