"""What an exciting trajectory has to keep to: duration, ends, start and limits."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.criterion import Basis
from orbident.excitation.floating import usual_initial
from orbident.excitation.table_points import (
    ANY_TABLE,
    TABLE_SIZES,
    TableSize,
    points_on_table,
)
from orbident.files.bounds import LARGEST, SHORTEST, SMALLEST
from orbident.model.kinematics import inertia
from orbident.robot.description import Robot
from orbident.robot.joint_schema import coupled_joints
from orbident.trajectories.trajectory import InitialState, Trajectory

INFINITE = float("inf")

YEAR = 3.2e7
"""s: the longest motion; no manipulator moves for so long."""

MOST_HARMONICS = 100
"""The paper has three. With 40, one start of a search takes minutes."""

FOLDED = 0.9
"""Share of a table on which an arm turns that has room left to move in."""

POSES = 1000
"""So many are drawn to find how an arm folds: with seven joints within a tenth."""

CROWDED = 0.01
"""Share of its range: a joint that is closer to a stop has no room to move in."""


@dataclass(frozen=True, eq=False)
class Limits:
    """Limits of joints, base and wheels; infinite where there is none."""

    position: Float[np.ndarray, "joints 2"]
    """Lower and upper, rad or m."""
    velocity: Float[np.ndarray, " joints"]
    """It scales the amplitudes: infinite only of one that follows. rad/s or m/s."""
    acceleration: Float[np.ndarray, " joints"]
    """rad/s^2 or m/s^2."""
    base_rate: float = INFINITE
    """Norm of the base's angular velocity, rad/s."""
    excursion: float = INFINITE
    """Angle of the base from its first attitude, rad."""
    wheel_speed: float = INFINITE
    """Speed of every wheel relative to the base, rad/s."""
    table: TableSize = ANY_TABLE
    """On which S, the joints' origins and the tips of the last links stay."""
    impulse: float = INFINITE
    """Impulse of all thrusters together, N s."""

    @property
    def by_name(self) -> dict[str, float]:
        """Those of the base and of the whole, by their names in messages."""
        return {
            "base rate": self.base_rate,
            "excursion": self.excursion,
            "wheel speed": self.wheel_speed,
            "impulse": self.impulse,
            **dict(zip(TABLE_SIZES, self.table, strict=True)),
        }


class BaseExtremes(NamedTuple):
    """How far a motion goes at most; infinite where nothing can be proven."""

    rate: float
    """Norm of the base's angular velocity, rad/s."""
    excursion: float
    """Angle from the first attitude, rad."""
    wheel_speed: float
    """Speed of the fastest wheel, rad/s."""
    table: TableSize | None
    """The smallest table; None in space."""
    impulse: float = 0.0
    """Impulse of all thrusters together, N s."""

    def beside(self, limits: Limits) -> list[tuple[str, float, float]]:
        """Each with the name of its limit before it, and the limit after it."""
        found = self.rate, self.excursion, self.wheel_speed, self.impulse
        # An excursion of pi is as far as there is.
        turn = limits.excursion if limits.excursion < np.pi else INFINITE
        names = limits.by_name | {"excursion": turn}
        return [
            (name, size, limit)
            for size, (name, limit) in zip(
                (*found, *(self.table or ())), names.items(), strict=False
            )
        ]


def limits_of(robot: Robot, acceleration: float = INFINITE, **others: Any) -> Limits:
    """The limits in the robot file and its URDF, and those that neither can state.

    Those of a joint that others follow are as narrow as theirs make them.

    Args:
        robot: with position and velocity limits of its joints.
        acceleration: of every joint, rad/s^2 or m/s^2.
        others: of the base and of the whole, by their names in `Limits`; an impulse
            only where pulses are designed, as of a robot without joints.

    Raises:
        InputError: the robot has neither joints nor thrusters, a joint with a motor
            has no velocity limit, a limit is not above zero, those of joints that
            follow leave no motion, or the robot is on no table.
    """
    if not robot.joints and not robot.thrusters:
        raise InputError(
            f"{robot.name}: joints and thrusters: found none; only what moves or "
            "pushes excites a robot"
        )
    if robot.joints and others.get("impulse", INFINITE) < INFINITE:
        raise InputError(
            "impulse limit: thrusters are fired only where a robot has no joints; "
            "leave the limit out"
        )
    for joint in (robot.joints[k] for k in coupled_joints(robot).free):
        if not (joint.velocity is not None and 0 < joint.velocity < INFINITE):
            raise InputError(
                f"{robot.name}: joint '{joint.name}': velocity limit: found "
                f"{joint.velocity}; give one in the model or under limits: in the "
                "robot file"
            )
    # With one stop, a turn from it is as far as a motion needs.
    stops = (
        joint.within(np.pi) if joint.position else (-INFINITE, INFINITE)
        for joint in robot.joints
    )
    limits = Limits(
        position=np.reshape([*stops], (-1, 2)),
        velocity=np.array([joint.velocity or INFINITE for joint in robot.joints]),
        acceleration=np.full(len(robot.joints), float(acceleration)),
        **others,
    )
    for name, value in {"acceleration": acceleration, **limits.by_name}.items():
        if not (SMALLEST <= value <= LARGEST or value == INFINITE):
            raise InputError(
                f"{name} limit: found {value:g}; give a number above zero, in SI units"
                f", and at most {LARGEST:g}"
            )
    if robot.motion != "planar" and min(limits.table) < INFINITE:
        raise InputError(
            f"{robot.name}: table limit: the robot flies in space; leave the limit out"
        )
    _narrow(robot, limits)
    return limits


def _narrow(robot: Robot, limits: Limits) -> None:
    """Narrow the limits of joints that others follow, in place."""
    at = {name: k for k, name in enumerate(robot.joint_names)}
    for follower, leader, factor, offset in robot.couplings:
        if not factor:
            continue
        f, l = at[follower], at[leader]
        ends = np.sort((limits.position[f] - offset) / factor)
        lower = max(limits.position[l, 0], ends[0])
        upper = min(limits.position[l, 1], ends[1])
        if not lower < upper:
            raise InputError(
                f"{robot.name}: joint '{leader}': the position limits of '{follower}', "
                "which follows it, leave no motion; widen one of them"
            )
        limits.position[l] = lower, upper
        for each in (limits.velocity, limits.acceleration):
            each[l] = min(each[l], each[f] / abs(factor))


@dataclass(frozen=True, eq=False)
class Conditions:
    """What a trajectory has to keep to.

    Raises:
        InputError: the duration is none that a motion can have, or there are no or too
            many harmonics.
    """

    duration: float
    """s."""
    harmonics: int | None
    """N_f; None where the search is to choose it."""
    limits: Limits
    start: Float[np.ndarray, "joints 3"]
    """Position, velocity and acceleration of each joint at t = 0."""
    end: Float[np.ndarray, "joints 3"]
    initial: InitialState
    basis: Basis | None = None
    """Whose condition number is meant; the automatic one by default."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not SHORTEST <= self.duration <= YEAR:
            raise InputError(
                f"duration: found {self.duration:g} s; give at least {SHORTEST:g} s, "
                "and at most a year"
            )
        if self.harmonics not in (None, *range(1, MOST_HARMONICS + 1)):
            raise InputError(
                f"harmonics: found {self.harmonics}; give one or more, and at most "
                f"{MOST_HARMONICS}"
            )


def conditions_for(
    robot: Robot,
    duration: float,
    harmonics: int | None = None,
    limits: Limits | None = None,
    like: Trajectory | None = None,
) -> Conditions:
    """The usual conditions: from rest at q = 0 to rest at q = 0, in the limits.

    A joint that cannot stand at zero, or at the end of its range only, starts and ends
    in the middle of it. On a limited table the arm starts and ends folded. The duration
    is in s. By default the search chooses `harmonics`, N_f, and limits are those of the
    robot file; `like` gives its ends and its initial state.

    Raises:
        InputError: as of `Conditions`, or the limits or the trajectory are not for
            this robot.
    """
    limits = limits_of(robot) if limits is None else limits
    if like is None:
        usual = np.zeros((len(robot.joints), 3))
        lower, upper = limits.position.T
        crowded = np.minimum(-lower, upper) < CROWDED * (upper - lower)
        usual[crowded, 0] = limits.position[crowded].mean(axis=1)
        if robot.joints and min(limits.table) < INFINITE:
            usual[:, 0] = _folded(robot, limits)
        start = end = _following(robot, usual)
        initial = usual_initial(robot, start)
    else:
        like = like.for_robot(robot)
        start, end = _following(robot, like.start), _following(robot, like.end)
        initial = like.initial
    return Conditions(duration, harmonics, limits, start, end, initial)


def _following(
    robot: Robot, state: Float[np.ndarray, "joints 3"]
) -> Float[np.ndarray, "joints 3"]:
    """The state with that of the joints that follow others as these make it."""
    free, lead, offset = coupled_joints(robot)
    state = lead @ state[free]
    state[:, 0] += offset
    return state


def _folded(robot: Robot, limits: Limits) -> Float[np.ndarray, " joints"]:
    """Where all stays on the table as the robot turns, farthest from joints' stops.

    Where nothing does, joints are as the robot turns on the smallest circle.
    """
    lower, upper = np.clip(limits.position, -np.pi, np.pi).T
    share = np.random.default_rng(0).uniform(CROWDED, 1 - CROWDED, (POSES, len(lower)))
    free, lead, offset = coupled_joints(robot)
    q = (lower + share * (upper - lower))[:, free] @ lead.T + offset
    points = points_on_table(
        robot, q, np.tile(np.eye(3), (POSES, 1, 1)), -inertia(robot, q).r_cm
    )
    circle = 2 * np.linalg.norm(points, axis=2).max(axis=1)
    width, depth, radius = limits.table
    fits = circle < FOLDED * min(width, depth, 2 * radius)
    from_stops = (0.5 - np.abs(share - 0.5))[:, free].min(axis=1)
    return q[np.where(fits, from_stops, -circle).argmax()]
