"""Bounds that hold for all times, between samples too: how far a motion goes.

Joints: between two nodes a function exceeds them by at most `h^2/8 max|f''|`. The
second derivative is bounded in the same way by the fourth, and that by the coefficients
(rounding apart).

Base: from `D w + g = R_0^T h_cm`, with `g` the momentum of the joints' and wheels'
motion,

    |w'| <= (|w| |h_cm| + |D'| |w| + |g'|) / min eig D.

With `r` from the CM, `u` and `a` velocity and acceleration relative to the base, of the
mass elements of the links (on the base `u = a = 0`), and `|x|^2 = integral |x|^2 dm`,
Cauchy and Schwarz give

    |D'| <= 2 |r| |u|,    |g'| <= |r| |a|,    min eig D >= min eig I_base, about its CM,

and motors' rotors add `N J qd` along the axes of their joints to `g`.

The norms follow from the largest joint rates and accelerations, from the base to the
tips. So `w` between two samples is within `h/2 max|w'|` of one of them.

Table: a point at `D` from the base's CM with velocity `V` and acceleration `A` relative
to the base has, seen from the CM of a robot whose links have the share `s` of the mass,

    |x''| <= (1 + s) (|w'| D + |w|^2 D + 2 |w| V + A),

and is between two samples within `h^2/8 max|x''|` of the straight line.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.motion import heavy_bodies
from orbident.errors import InputError
from orbident.excitation.conditions import BaseExtremes, Conditions, Limits
from orbident.excitation.joint_limits import JointMotions
from orbident.excitation.table_points import TableSize, points_on_table, size_of_table
from orbident.files.json_parts import nulled
from orbident.model.core_robot import rotors_of, wheels_of
from orbident.model.rotations import quaternion_matrix
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA,
    INERTIA_ENTRIES,
    MASS,
    inertia_about_com,
)
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating
from orbident.trajectories.trajectory import Trajectory

NODES = 4001

LEAST_INERTIA = 1e-12
"""kg m^2: a massless base cannot bound the inertia, and nothing is proven then."""


Flown = tuple[Trajectory, FreeFloating]
"""A trajectory for a robot, rows in its order, and the motion along it."""


class Extremes(NamedTuple):
    """Bounds for all times, never too small."""

    position: Float[np.ndarray, "joints 2"]
    """Lowest and highest, rad or m."""
    velocity: Float[np.ndarray, " joints"]
    """Largest magnitude."""
    acceleration: Float[np.ndarray, " joints"]

    def beside(self, limits: Limits, names: Sequence[str]) -> dict[str, Any]:
        """Each joint's beside its limits, which are None where there are none."""
        return {
            name: {
                "position": self.position[k].tolist(),
                "position_limit": [nulled(x) for x in limits.position[k]],
                "velocity": float(self.velocity[k]),
                "velocity_limit": nulled(limits.velocity[k]),
                "acceleration": float(self.acceleration[k]),
                "acceleration_limit": nulled(limits.acceleration[k]),
            }
            for k, name in enumerate(names)
        }


Carried = Float[np.ndarray, "5 bodies"]
"""Bounds of how each body's origin moves relative to the base: distance from the base's
CM, velocity and acceleration; then rate and angular acceleration of the body; SI."""


def extremes_of(trajectory: Trajectory) -> Extremes:
    """The extremes of every joint over the whole duration."""
    t = np.linspace(0.0, trajectory.duration, NODES)
    motion = trajectory.motion
    beyond = t[1] ** 2 / 8
    most = [motion.bound(order) for order in range(8)]
    for order in (5, 4, 3, 2, 1):
        sampled = np.abs(motion.derivative(order, t)).max(axis=0)
        most[order] = sampled + beyond * most[order + 2]
    q = motion.derivative(0, t)
    over = beyond * most[2]
    position = np.stack([q.min(axis=0) - over, q.max(axis=0) + over], axis=1)
    return Extremes(position, most[1], most[2])


def base_extremes_of(
    robot: Robot, motion: FreeFloating, joints: Extremes
) -> BaseExtremes:
    """The extremes of the base over the whole duration, with nominal inertia.

    The motion is at times that are evenly spaced over the whole duration, and `joints`
    are proven extremes of it.
    """
    t = motion.t
    planar = robot.motion == "planar"
    table = TableSize() if planar else None
    least = _least_inertia(robot)
    if least <= LEAST_INERTIA:
        return BaseExtremes(np.inf, np.inf, np.inf, table)
    carried = _carried(robot, joints)
    r, u, a, h, n = _norms(robot, joints, carried)
    h_cm = float(np.linalg.norm(motion.h_cm))
    wheels = wheels_of(robot)
    spin = motion.qd_rw[0] + wheels.free * (wheels.axes.T @ motion.w[0])
    h_rw = float(np.linalg.norm(wheels.A_rw @ spin))
    sampled = float(np.linalg.norm(motion.w, axis=1).max())
    rate = (h_cm + r * u + h + h_rw) / least
    change = np.inf
    for _ in range(3):
        # In the plane R_0^T h_cm is constant.
        torque = (0.0 if planar else h_cm) * rate + r * a + n
        change = (torque + 2 * r * u * rate) / least
        rate = min(rate, sampled + change * t[1] / 2)
    half = np.abs(motion.attitude @ motion.attitude[0])
    turned = float(2 * np.arccos(np.clip(half, 0.0, 1.0)).max())
    excursion = turned + rate * t[1] / 2 + motion.attitude_error
    free_change = change * t[1] / 2 if wheels.free.any() else 0.0
    fastest = float(np.abs(motion.qd_rw).max(initial=0.0))
    if planar:
        table = _smallest_table(robot, motion, carried, float(rate), float(change))
    return BaseExtremes(
        float(rate), float(min(excursion, np.pi)), float(fastest + free_change), table
    )


def _smallest_table(
    robot: Robot, motion: FreeFloating, carried: Carried, rate: float, change: float
) -> TableSize:
    points = points_on_table(
        robot, motion.q, quaternion_matrix(motion.attitude), motion.r_S
    )
    # No point of a body, nor its CM, is farther from its origin than a tip.
    reaches = np.zeros(len(robot.bodies))
    for body, _, com in heavy_bodies(robot):
        reaches[body] = 2 * np.linalg.norm(com)
    d, v, a, w, alpha = carried
    D, V = d + reaches, v + w * reaches
    A = a + (alpha + w**2) * reaches
    share = 1 + np.abs(robot.theta[1:, MASS]).sum() / robot.mass
    bent = share * float(((change + rate**2) * D + 2 * rate * V + A).max())
    beyond = bent * motion.t[1] ** 2 / 8 + 2 * motion.attitude_error * D.max()
    width, depth, radius = size_of_table(points)
    return TableSize(width + 2 * beyond, depth + 2 * beyond, radius + beyond)


def _least_inertia(robot: Robot) -> float:
    """Below every eigenvalue of `D`, free wheels apart, kg m^2."""
    if robot.theta[0, MASS] <= 0:
        return 0.0
    wheels = wheels_of(robot)
    I = inertia_about_com(robot.theta[0]) - (wheels.A_rw * wheels.free) @ wheels.axes.T
    return float(I[2, 2] if robot.motion == "planar" else np.linalg.eigvalsh(I)[0])


def _carried(robot: Robot, joints: Extremes) -> Carried:
    """Recursively from the base: each body's largest rates and accelerations."""
    carried = np.zeros((5, len(robot.bodies)))
    d, v, a, w, alpha = carried
    com = robot.theta[0, FIRST_MOMENT] / robot.theta[0, MASS]
    for k, joint in enumerate(robot.joints):
        j, rate, acceleration = joint.parent, joints.velocity[k], joints.acceleration[k]
        slides = joint.kind == "prismatic"
        slide = np.abs(joints.position[k]).max() if slides else 0.0
        arm = np.linalg.norm(joint.p_PJ) + slide
        # Distances are from the base's CM; rates are zero there.
        from_parent = arm if j else np.linalg.norm(joint.p_PJ - com) + slide
        d[k + 1] = d[j] + from_parent
        v[k + 1] = v[j] + w[j] * arm + slides * rate
        a[k + 1] = a[j] + (alpha[j] + w[j] ** 2) * arm
        a[k + 1] += slides * (acceleration + 2 * w[j] * rate)
        w[k + 1] = w[j] + (not slides) * rate
        alpha[k + 1] = alpha[j] + (not slides) * (acceleration + w[j] * rate)
    return carried


def _norms(robot: Robot, joints: Extremes, carried: Carried) -> tuple[float, ...]:
    """Root integrals over the mass of the links, and what the motors' rotors have.

    Returns:
        `|r|`, `|u|` and `|a|`; the rotors' momentum, N m s, and its rate, N m.
    """
    m, I = np.abs(robot.theta[1:, MASS]), robot.theta[1:, INERTIA]
    # Root of `integral |rho|^2 dm = tr I / 2`, about the body's origin.
    diagonal = [row == column for row, column in INERTIA_ENTRIES]
    spread = np.sqrt(np.abs(I[:, diagonal].sum(axis=1)) / 2)
    root, (d, v, a, w, alpha) = np.sqrt(m), carried[:, 1:]
    # |c| <= sqrt(m_links) |r| / M takes r from the base's CM to that of the system.
    to_cm = 1 + m.sum() / robot.mass
    # The axes of a rotor turn with the body that carries it.
    NJ = np.abs(rotors_of(robot).momentum)
    carrier = np.append(0.0, w)[[joint.parent for joint in robot.joints]]
    return (
        float(np.linalg.norm(root * d + spread) * to_cm),
        float(np.linalg.norm(root * v + spread * w)),
        float(np.linalg.norm(root * a + spread * (alpha + w**2))),
        float(NJ @ joints.velocity),
        float(NJ @ (joints.acceleration + carrier * joints.velocity)),
    )


ACCURATE = 1e-6
"""Accuracy of the attitude, rad: bounds and scores need no better one."""

SHARES = (1.0, 0.999, 0.998, 0.995, 0.99, 0.98, 0.95, 0.9, 0.8, 0.6, 0.3, 0.0)
"""Shares of the amplitude, tried until the limits are proven to hold."""


class Proven(NamedTuple):
    """A trajectory and its extremes, never too small."""

    trajectory: Trajectory
    motion: FreeFloating
    joints: Extremes
    base: BaseExtremes
    share: float
    """Share of the amplitude that was asked for."""

    def broken(self, limits: Limits) -> str:
        """Which limit the motion may exceed at some time; empty where it keeps all."""
        return broken_by_joints(self.joints, limits) or broken_by_base(
            self.base, limits
        )


def proven_within(
    robot: Robot,
    given: Conditions,
    motions: JointMotions,
    middle: Float[np.ndarray, "free m"],
    y: Float[np.ndarray, "free m"],
) -> Proven:
    """The motion, made smaller where its limits cannot be proven otherwise.

    The motion `middle` is well inside the limits, and `y` is what is wanted.

    Raises:
        InputError: the limits of the base cannot be proven for any amplitude.
    """
    broken = ""
    for share in SHARES:
        a, b = motions.coefficients(middle + share * (y - middle))
        trajectory = Trajectory(
            given.duration,
            robot.joint_names,
            a,
            b,
            given.start,
            given.end,
            given.initial,
            source="design",
        )
        joints = extremes_of(trajectory)
        broken = broken_by_joints(joints, given.limits)
        if broken:
            continue
        motion = floated(robot, trajectory)
        base = base_extremes_of(robot, motion, joints)
        broken = broken_by_base(base, given.limits)
        if not broken:
            return Proven(trajectory, motion, joints, base, share)
    raise InputError(f"limits: {broken}; raise the limit, or give more time")


def proven(robot: Robot, trajectory: Trajectory) -> Proven:
    """What is proven of a motion, whatever its limits.

    The trajectory is for this robot, rows in its order, and the inertia nominal.

    Raises:
        InputError: as of `floated`.
    """
    motion, joints = floated(robot, trajectory), extremes_of(trajectory)
    base = base_extremes_of(robot, motion, joints)
    return Proven(trajectory, motion, joints, base, 1.0)


def floated(robot: Robot, trajectory: Trajectory) -> FreeFloating:
    """The motion that the trajectory makes, at times close to each other.

    The trajectory is for this robot, rows in its order, and the inertia nominal.

    Raises:
        InputError: the base turns too fast for an accurate attitude.
    """
    start = BaseState.of(trajectory.initial, robot)
    t = np.linspace(0.0, trajectory.duration, NODES)
    return free_floating(robot, trajectory.motion, t, start, ACCURATE)


def broken_by_joints(joints: Extremes, limits: Limits) -> str:
    """Which limit a joint may exceed; empty where none is."""
    lower, upper = limits.position.T
    beyond = {
        "position": np.maximum(
            lower - joints.position[:, 0], joints.position[:, 1] - upper
        ),
        "velocity": joints.velocity - limits.velocity,
        "acceleration": joints.acceleration - limits.acceleration,
    }
    for name, excess in beyond.items():
        if (excess > 0).any():
            return f"joint {name} may exceed its limit by {excess.max():.2g}"
    return ""


def broken_by_base(base: BaseExtremes, limits: Limits) -> str:
    """Which limit the base exceeds; empty where it keeps all."""
    for name, found, limit in base.beside(limits):
        if found > limit:
            return f"{name}: up to {found:.6g} is possible, the limit is {limit:g}"
    return ""
