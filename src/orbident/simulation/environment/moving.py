"""A flight at any of its times, as what acts on the robot needs it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicHermiteSpline

from orbident.model.kinematics import Poses, carrying_joints, poses
from orbident.model.rotations import (
    quaternion_matrix,
    quaternion_rate,
    rotate,
    rotation_angle,
)
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS
from orbident.simulation.flight_steps import FlightStates

Vectors = Float[np.ndarray, "n 3"]


class Load(NamedTuple):
    """A force on a point of a body, and a moment; inertial axes."""

    body: int
    """Index of the body."""
    point: Float[np.ndarray, "3"]
    """Point where the force acts, in the body's frame, m."""
    force: Vectors
    """N."""
    moment: Vectors
    """N m."""


class Point(NamedTuple):
    """How a point of a body moves; inertial axes."""

    r: Vectors
    """m."""
    v: Vectors
    """m/s."""


@dataclass(frozen=True)
class Moving:
    """A robot at some times."""

    robot: Robot
    t: Float[np.ndarray, " n"]
    """s."""
    inside: Float[np.ndarray, " n"]
    """A time within the same step: what is switched is on or off all through a step."""
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    x_WB: Float[np.ndarray, "n 4"]
    w: Vectors
    """Base axes, rad/s."""
    r_S: Vectors
    """Inertial axes, m."""
    v_S: Vectors
    """Inertial axes, m/s."""

    @cached_property
    def R_WB(self) -> Float[np.ndarray, "n 3 3"]:
        """Rotates vectors from base axes into inertial ones."""
        return quaternion_matrix(self.x_WB)

    @cached_property
    def poses(self) -> Poses:
        """Where all bodies are, from S."""
        return poses(self.robot, self.q)

    def point(self, body: int, p: Float[np.ndarray, "3"]) -> Point:
        """How a point moves that is fixed in a body, at `p` of its frame, m."""
        at = self.poses
        arm = at.d[:, body] + at.R[:, body] @ p
        fields = at.field_u + np.cross(at.field_w, arm[:, None])
        by_joints = np.einsum("nk,nki->ni", self._carrying(body), fields)
        v = np.cross(self.w, arm) + by_joints
        return Point(self.r_S + rotate(self.R_WB, arm), self.v_S + rotate(self.R_WB, v))

    def rate(self, body: int) -> Vectors:
        """The angular velocity of a body, inertial axes, rad/s."""
        by_joints = np.einsum("nk,nki->ni", self._carrying(body), self.poses.field_w)
        return rotate(self.R_WB, self.w + by_joints)

    def _carrying(self, body: int) -> Float[np.ndarray, "n joints"]:
        return self.qd * carrying_joints(self.robot, body)

    def acting(
        self,
        body: int,
        point: Float[np.ndarray, "3"],
        force: Vectors | None = None,
        moment: Vectors | None = None,
    ) -> Load:
        """What acts on a body at a point of it; inertial axes, nothing by default."""
        nothing = np.zeros((self.t.size, 3))
        return Load(
            body,
            point,
            nothing if force is None else force,
            nothing if moment is None else moment,
        )


def at_rest(robot: Robot) -> Moving:
    """The robot at rest at zero, at one time."""
    joints, nothing = np.zeros((1, len(robot.joints))), np.zeros((1, 3))
    level = np.array([[0.0, 0.0, 0.0, 1.0]])
    t = np.zeros(1)
    return Moving(robot, t, t, joints, joints, level, nothing, nothing, nothing)


Force = Callable[[Moving], Sequence[Load]]
"""What acts as the robot moves: always on the same points of the same bodies."""


def heavy_bodies(robot: Robot) -> list[tuple[int, float, Float[np.ndarray, "3"]]]:
    """Each body that has mass: its index, mass (kg) and CM in its own frame (m)."""
    return [
        (i, float(theta_i[MASS]), theta_i[FIRST_MOMENT] / theta_i[MASS])
        for i, theta_i in enumerate(robot.theta)
        if theta_i[MASS]
    ]


class Path(NamedTuple):
    """A flight between its steps: cubics through places and rates at their starts."""

    robot: Robot
    spline: CubicHermiteSpline

    @classmethod
    def through(
        cls, robot: Robot, t: Float[np.ndarray, " steps"], seen: FlightStates
    ) -> "Path":
        """The path of what was seen at the starts `t` (s) of steps."""
        joints = len(robot.joints)
        w, qd = seen.v[:, 3:6], seen.v[:, 6 : 6 + joints]
        w_dot, qdd = seen.vd[:, 3:6], seen.vd[:, 6 : 6 + joints]
        a_S = rotate(quaternion_matrix(seen.x_WB), seen.f_S)
        turning = quaternion_rate(seen.x_WB, w)
        x = np.hstack([seen.q, seen.x_WB, seen.r_S, qd, w, seen.v_S])
        slope = np.hstack([qd, turning, seen.v_S, qdd, w_dot, a_S])
        return cls(robot, CubicHermiteSpline(t, x, slope))

    def at(self, nodes: Float[np.ndarray, "steps 3"]) -> Moving:
        """The robot at start, middle and end of some steps, s."""
        return self._moving(nodes.ravel(), np.repeat(nodes[:, 1], 3))

    def apart(self, other: "Path") -> float:
        """The largest distance of places and attitudes at the steps' starts, m, rad."""
        t = self.spline.x
        a, b = self._moving(t, t), other._moving(t, t)
        return max(
            np.abs(a.r_S - b.r_S).max(),
            np.abs(a.q - b.q).max(initial=0.0),
            rotation_angle(a.x_WB, b.x_WB).max(),
        )

    def _moving(
        self, t: Float[np.ndarray, " n"], inside: Float[np.ndarray, " n"]
    ) -> Moving:
        joints = len(self.robot.joints)
        ends = np.cumsum([joints, 4, 3, joints, 3])
        q, x_WB, r_S, qd, w, v_S = np.split(self.spline(t), ends, axis=1)
        x_WB /= np.linalg.norm(x_WB, axis=1, keepdims=True)
        return Moving(self.robot, t, inside, q, qd, x_WB, w, r_S, v_S)
