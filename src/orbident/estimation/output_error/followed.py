"""Where the robot was along a recording, as it was measured, for what acts on it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from orbident.errors import InputError
from orbident.estimation.output_error.shooting import Intervals, with_middles
from orbident.files.bounds import TOGETHER
from orbident.model.kinematics import Poses, carrying_joints, poses
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS, PER_BODY


class Motion(NamedTuple):
    """How a point or the system CM moves; inertial axes, from the first place of S."""

    r: Float[np.ndarray, "nodes 3"]
    """m."""
    v: Float[np.ndarray, "nodes 3"]
    """m/s."""


@dataclass(frozen=True)
class Followed:
    """The motion at every row, and half-way to the next, worked out as it is asked for.

    It is that measured. A disturbance adds up over time, and its noise does not: where
    drag takes a third of the momentum, deviations still hold.
    """

    robot: Robot
    sets: MinimalSets
    samples: Samples
    intervals: Intervals
    """With the rows."""

    @cached_property
    def q(self) -> Float[np.ndarray, "nodes joints"]:
        """Positions of the joints."""
        history = self.intervals.history
        return history.at(history.q, history.q_slope, self.t)

    @cached_property
    def qd(self) -> Float[np.ndarray, "nodes joints"]:
        """Their rates."""
        history = self.intervals.history
        return history.at(history.qd, history.qdd, self.t)

    @property
    def qd_rw(self) -> Float[np.ndarray, "nodes wheels"]:
        """Speeds of the wheels, rad/s."""
        history = self.intervals.history
        return history.at(history.qd_rw, history.qdd_rw, self.t)

    @cached_property
    def t(self) -> Float[np.ndarray, " nodes"]:
        """Times of the nodes, s."""
        return with_middles(self.intervals.t)

    @cached_property
    def R_WB(self) -> Float[np.ndarray, "nodes 3 3"]:
        """The attitude of the base."""
        at, turns, _ = self._attitude
        return turns(np.clip(self.t, at[0], at[-1])).as_matrix()

    @cached_property
    def w(self) -> Float[np.ndarray, "nodes 3"]:
        """Base axes, rad/s."""
        return self._between(self.samples.w)

    @cached_property
    def v_S(self) -> Float[np.ndarray, "nodes 3"] | None:
        """Inertial axes, m/s; None where it is not known."""
        v_S = self.samples.v_S
        return self._between(v_S) if v_S else None

    @cached_property
    def wrenches(self) -> tuple[RecordedWrench, ...]:
        """What is known to act on the base from a row until the next."""
        return _at(self.samples, self.intervals.t)

    @cached_property
    def surroundings(self) -> Mapping[str, Float[np.ndarray, "nodes 3"]]:
        """Where Earth, air, sun and field are; inertial axes."""
        if not self.samples.surroundings:
            return {}
        at, turns, known = self._attitude
        # In inertial axes they change slowly.
        return {
            name: _between(at, turns(at).apply(x[known]), self.t)
            for name, x in self.samples.surroundings.items()
        }

    @property
    def _attitude(self) -> "_Attitude":
        x = np.column_stack(self.samples.x_WB)
        known = np.asarray(np.isfinite(x).all(axis=1))
        at = self.samples.t[known]
        return _Attitude(at, Slerp(at, Rotation.from_quat(x[known])), known)

    def _between(self, columns: Columns) -> Float[np.ndarray, "nodes axes"]:
        x = np.column_stack(columns)
        known = np.isfinite(x).all(axis=1)
        if known.sum() < 2:
            raise InputError(
                f"{self.samples.source}: joints, wheels and base are known together "
                f"at {known.sum()} times, and 2 are needed at least; check the clocks, "
                "or record longer"
            )
        return np.asarray(CubicSpline(self.samples.t[known], x[known])(self.t))

    @property
    def tracked(self) -> bool:
        """Whether the velocity of S is known."""
        return bool(self.samples.v_S)

    @cached_property
    def S(self) -> Motion:
        """The motion of S."""
        assert self.v_S is not None
        return Motion(integral(self.t, by_step(self.v_S)), self.v_S)

    @cached_property
    def poses(self) -> Poses:
        """Where all bodies are."""
        return poses(self.robot, self.q)

    @cached_property
    def moments(self) -> Float[np.ndarray, "nodes 3 beta"]:
        """The first moment about S by each `beta`; inertial axes, kg m by its unit."""
        at = self.poses
        n, bodies = at.d.shape[:2]
        by_theta = np.zeros((n, 3, PER_BODY * bodies))
        for i in range(bodies):
            own = np.zeros((n, 3, PER_BODY))
            own[:, :, MASS] = at.d[:, i]
            own[:, :, FIRST_MOMENT] = at.R[:, i]
            by_theta[:, :, PER_BODY * i : PER_BODY * (i + 1)] = own
        return self.R_WB @ (by_theta @ self.sets.base.theta_of)

    def to_cm(self, beta: Float[np.ndarray, " beta"]) -> Float[np.ndarray, "nodes 3"]:
        """From S to the system CM with these parameters; inertial axes, m."""
        theta = (self.sets.base.theta_of @ beta).reshape(-1, PER_BODY)
        at = self.poses
        first_moment = np.einsum("nbi,b->ni", at.d, theta[:, MASS])
        first_moment += np.einsum("nbij,bj->ni", at.R, theta[:, FIRST_MOMENT])
        return self.in_inertial(first_moment / beta[0])

    @cached_property
    def nominal_cm(self) -> Motion:
        """The system CM, by CAD."""
        beta = self.sets.beta(self.robot.theta)
        r = self.S.r + self.to_cm(beta)
        return Motion(r, np.gradient(r, self.t, axis=0))

    def point(self, body: int, p: Float[np.ndarray, "3"]) -> Motion:
        """A point of a body, its axes."""
        at, arm = self.poses, self.arm(body, p)
        relative = np.cross(self.w, arm)
        for k in np.flatnonzero(carrying_joints(self.robot, body)):
            field = at.field_u[:, k] + np.cross(at.field_w[:, k], arm)
            relative = relative + self.qd[:, k : k + 1] * field
        return Motion(
            self.S.r + self.in_inertial(arm), self.S.v + self.in_inertial(relative)
        )

    def rate(self, body: int) -> Float[np.ndarray, "nodes 3"]:
        """The angular velocity of a body, inertial axes, rad/s."""
        w = self.w.copy()
        for k in np.flatnonzero(carrying_joints(self.robot, body)):
            w += self.qd[:, k : k + 1] * self.poses.field_w[:, k]
        return self.in_inertial(w)

    def arm(self, body: int, p: Float[np.ndarray, "3"]) -> Float[np.ndarray, "nodes 3"]:
        """The vector from S to a point of a body; base axes, m."""
        return self.poses.d[:, body] + self.poses.R[:, body] @ p

    def in_inertial(
        self, x: Float[np.ndarray, "nodes 3"]
    ) -> Float[np.ndarray, "nodes 3"]:
        """A vector in base axes, in inertial ones."""
        return np.einsum("nij,nj->ni", self.R_WB, x)


def by_step(x: Float[np.ndarray, "nodes ..."]) -> Float[np.ndarray, "steps 3 ..."]:
    """The values at each row, half-way, and at the next row, side by side."""
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


class _Attitude(NamedTuple):
    t: Float[np.ndarray, " known"]
    at: Slerp
    known: Bool[np.ndarray, " samples"]


def _between(
    at: Float[np.ndarray, " known"],
    x: Float[np.ndarray, "known 3"],
    t: Float[np.ndarray, " nodes"],
) -> Float[np.ndarray, "nodes 3"]:
    return np.column_stack([np.interp(t, at, column) for column in x.T])


def _at(samples: Samples, t: Float[np.ndarray, " rows"]) -> tuple[RecordedWrench, ...]:
    """What acts at these times: what the last sample before says."""
    last = np.searchsorted(samples.t, t + TOGETHER, side="right") - 1
    before = np.maximum(last, 0)
    return tuple(
        each._replace(
            force=each.force[before],
            torque=each.torque[before],
            dipole=each.dipole[before],
        )
        for each in samples.wrenches
    )
