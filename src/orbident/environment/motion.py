"""How a robot moves, for what acts on it: at the nodes of a flight or of a recording.

A step's nodes are its start, its middle and its end, which is the next one's start: `n`
steps have `2 n + 1` nodes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.kinematics import Poses, carrying_joints, poses
from orbident.model.rotations import rotate
from orbident.robot.description import Robot
from orbident.robot.may_act import MayAct
from orbident.robot.parameters import FIRST_MOMENT, MASS

Vectors = Float[np.ndarray, "nodes 3"]
Steps = Float[np.ndarray, "steps 3 3"]
"""Vectors at the nodes of each step: what is switched differs on both sides of one."""


class PointMotion(NamedTuple):
    """How a point moves; inertial axes."""

    r: Vectors
    """m; in a recording from the first place of S."""
    v: Vectors
    """m/s."""


class Load(NamedTuple):
    """A force on a point of a body, and a moment; inertial axes."""

    body: int
    """Index of the body."""
    point: Float[np.ndarray, "3"]
    """Point where the force acts, in the body's frame, m."""
    force: Steps
    """N."""
    moment: Steps
    """N m."""


class Effect(NamedTuple):
    """What acts at a row, half-way and, until then, at the next; inertial axes."""

    force: Steps
    """N."""
    torque: Steps
    """About S, N m."""
    pull: Steps
    """Acceleration of all parts that an accelerometer does not feel, m/s^2."""
    push: Steps
    """The same of all parts that it feels, m/s^2."""

    @property
    def accelerates(self) -> bool:
        """Whether the system CM is accelerated by it, or only turned."""
        return any(x.any() for x in (self.force, self.pull, self.push))

    def plus(self, size: float, other: "Effect") -> "Effect":
        """Another one, so many times as large, in addition."""
        return Effect(*(a + size * b for a, b in zip(self, other, strict=True)))


def by_step(x: Float[np.ndarray, "nodes ..."]) -> Float[np.ndarray, "steps 3 ..."]:
    """The values at start, middle and end of each step, side by side."""
    return np.stack([x[:-1:2], x[1::2], x[2::2]], axis=1)


def at_nodes(x: Float[np.ndarray, "steps 3 ..."]) -> Float[np.ndarray, "nodes ..."]:
    """What holds from each node on."""
    out = np.empty((2 * len(x) + 1, *x.shape[2:]))
    out[:-1:2], out[1::2], out[-1] = x[:, 0], x[:, 1], x[-1, 2]
    return out


def integral(
    t: Float[np.ndarray, " nodes"], x: Float[np.ndarray, "steps 3 ..."]
) -> Float[np.ndarray, "nodes ..."]:
    """The integral from the first node on, by parabolas through each step's nodes."""
    h = np.diff(t[::2]).reshape(-1, *(1,) * (x.ndim - 2))
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    out = np.zeros((t.size, *x.shape[2:]))
    out[2::2] = np.cumsum(h * (a + 4 * b + c) / 6, axis=0)
    out[1::2] = out[:-1:2] + h * (5 * a + 8 * b - c) / 24
    return out


def straight(
    t: Float[np.ndarray, " n"], at: Float[np.ndarray, " rows"], x: Vectors
) -> Float[np.ndarray, "n 3"]:
    """Vectors at the times `t`, straight from one row, at these times, to the next."""
    return np.stack([np.interp(t, at, column) for column in x.T], axis=1)


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """A robot at the nodes of some steps."""

    robot: Robot
    t: Float[np.ndarray, " nodes"]
    """s."""
    q: Float[np.ndarray, "nodes joints"]
    """rad or m."""
    qd: Float[np.ndarray, "nodes joints"]
    R_WB: Float[np.ndarray, "nodes 3 3"]
    w: Vectors
    """Base axes, rad/s."""
    S: PointMotion | None
    """None where the velocity of S was not recorded."""
    surroundings: Mapping[str, Vectors] = field(default_factory=dict)
    """What a recording tells of `nadir`, `flow`, `sun` and `field`; inertial axes."""
    pushed: tuple[float, float] | None = None
    """From when to when something pushed a recorded robot, s, where that is known."""
    allowed: Mapping[str, MayAct] = field(default_factory=dict)
    """What may act on it, by group; what is absent does not."""
    speed_noise: tuple[float, ...] = ()
    """Density of the tachometer's noise in the speed of each wheel of a recording,
    rad/s/sqrt(Hz)."""
    speed_waves: int = 0
    """How many waves a fit has of it."""
    predicted_w: Vectors | None = None
    """What a fit predicts of `w`, without a gyro's noise; but for constants, rad/s."""

    @cached_property
    def poses(self) -> Poses:
        """Where all bodies are, from S."""
        return poses(self.robot, self.q)

    @cached_property
    def nothing(self) -> Effect:
        """Nothing acts."""
        zero = np.zeros((self.t.size // 2, 3, 3))
        return Effect(zero, zero, zero, zero)

    def turning(self, torque: Vectors) -> Effect:
        """What only turns: a torque about S, inertial axes, N m."""
        return self.nothing._replace(torque=by_step(torque))

    def in_inertial(self, x: Vectors) -> Vectors:
        """Vectors in base axes, in inertial ones."""
        return rotate(self.R_WB, x)

    def always(self, x: Sequence[float] | Float[np.ndarray, "3"]) -> Vectors:
        """The same vector at all nodes."""
        return np.tile(x, (self.t.size, 1))

    def point(self, body: int, p: Float[np.ndarray, "3"]) -> PointMotion:
        """How a point moves that is fixed in a body, at `p` of its frame, m."""
        assert self.S is not None
        at, arm = self.poses, self.poses.arm(body, p)
        fields = at.field_u + np.cross(at.field_w, arm[:, None])
        by_joints = np.einsum("nk,nki->ni", self._carrying(body), fields)
        v = np.cross(self.w, arm) + by_joints
        return PointMotion(
            self.S.r + self.in_inertial(arm), self.S.v + self.in_inertial(v)
        )

    def rate(self, body: int) -> Vectors:
        """The angular velocity of a body, inertial axes, rad/s."""
        by_joints = np.einsum("nk,nki->ni", self._carrying(body), self.poses.field_w)
        return self.in_inertial(self.w + by_joints)

    def _carrying(self, body: int) -> Float[np.ndarray, "nodes joints"]:
        return self.qd * carrying_joints(self.robot, body)

    def to_cm(self, theta: Float[np.ndarray, "bodies 10"]) -> Vectors:
        """From S to the CM of these bodies; inertial axes, m."""
        m, first_moment = theta[:, MASS], theta[:, FIRST_MOMENT]
        total = np.einsum("nbi,b->ni", self.poses.d, m)
        total += np.einsum("nbij,bj->ni", self.poses.R, first_moment)
        return self.in_inertial(total / m.sum())

    def load(
        self,
        body: int = 0,
        point: Float[np.ndarray, "3"] | None = None,
        force: Vectors | None = None,
        moment: Vectors | None = None,
    ) -> Load:
        """What acts on a body at a point of it, by default at S; inertial axes."""
        return Load(
            body,
            np.zeros(3) if point is None else point,
            self.nothing.force if force is None else by_step(force),
            self.nothing.torque if moment is None else by_step(moment),
        )

    def effect(self, load: Load) -> Effect:
        """What a load does to the robot as a whole."""
        arm = by_step(self.in_inertial(self.poses.arm(load.body, load.point)))
        torque = load.moment + np.cross(arm, load.force)
        return self.nothing._replace(force=load.force, torque=torque)


def at_rest(robot: Robot, t: Float[np.ndarray, " nodes"]) -> RobotMotion:
    """The robot at rest at zero, at these times, s."""
    joints, zero = np.zeros((t.size, len(robot.joints))), np.zeros((t.size, 3))
    level, S = np.tile(np.eye(3), (t.size, 1, 1)), PointMotion(zero, zero)
    return RobotMotion(robot, t, joints, joints, level, zero, S)


def heavy_bodies(robot: Robot) -> list[tuple[int, float, Float[np.ndarray, "3"]]]:
    """Each body that has mass: its index, mass (kg) and CM in its own frame (m)."""
    return [
        (i, float(theta_i[MASS]), theta_i[FIRST_MOMENT] / theta_i[MASS])
        for i, theta_i in enumerate(robot.theta)
        if theta_i[MASS]
    ]
