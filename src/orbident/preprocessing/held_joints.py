"""Which joints did not move: they are held, for their encoders' noise is no motion."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.model.kinematics import inertia_at
from orbident.robot.description import Robot

LOCKED = 1e-3
"""A joint that moved less (rad or m) did not move: encoders are finer than that."""

UNSEEN = 0.1
"""Part of the noise of a sample of the gyro: what turns the base more slowly all the
time would take ten thousand samples to be seen."""


class Range(NamedTuple):
    """The finite samples of some columns."""

    low: Float[np.ndarray, " columns"]
    """Infinite where there is none."""
    high: Float[np.ndarray, " columns"]
    samples: Float[np.ndarray, " columns"]
    total: Float[np.ndarray, " columns"]

    @classmethod
    def of(cls, columns: Sequence[Float[np.ndarray, " samples"]]) -> "Range":
        """Those of these columns."""
        found = np.empty((4, len(columns)))
        for k, column in enumerate(columns):
            x = column[np.isfinite(column)]
            low, high = x.min(initial=np.inf), x.max(initial=-np.inf)
            found[:, k] = low, high, x.size, x.sum()
        return cls(*found)

    def and_of(self, other: "Range") -> "Range":
        """Those of both."""
        return Range(
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
            self.samples + other.samples,
            self.total + other.total,
        )

    def ends(self, k: int) -> list[float] | None:
        """The least and the largest value of column `k`; None without a sample."""
        both = [float(self.low[k]), float(self.high[k])]
        return both if self.samples[k] else None


def held_joints(robot: Robot, q: Range, qd: Range, dt: float) -> dict[str, float]:
    """The joints that did not move, and where they are held, rad or m.

    A controller that holds a joint lets it tremble. That is no motion where, with the
    nominal inertia, the base turns so little by it that the gyro does not see it.

    Args:
        robot: with its nominal inertia, and the gyro's noise, where that is known.
        q: of all joints, rad or m.
        qd: of all joints, rad/s or m/s.
        dt: from one sample of the gyro to the next, s.
    """
    still = q.high - q.low < LOCKED
    if not still.all():
        still |= _trembling(robot, q, qd, dt)
    return {
        name: float(q.total[k] / q.samples[k])
        for k, name in enumerate(robot.joint_names)
        if still[k]
    }


def _trembling(
    robot: Robot, q: Range, qd: Range, dt: float
) -> Bool[np.ndarray, " joints"]:
    """Revolute joints alone: a sliding one may move S without a turn."""
    turning = np.array([joint.kind == "revolute" for joint in robot.joints])
    noise = robot.sensors.of("gyro").white_std(dt)
    at = inertia_at(robot, (q.low + q.high) / 2)
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    # h = D w + D_q qd stays: w = -D^-1 D_q qd (Eq. 3).
    turns = np.linalg.solve(at.D[np.ix_(axes, axes)], at.D_q[axes])
    fastest = np.maximum(qd.high, -qd.low)
    return turning & (np.linalg.norm(turns, axis=0) * fastest < UNSEEN * noise)
