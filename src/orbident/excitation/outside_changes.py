"""What may act from outside changes both momenta along a motion.

With `F`, `tau` (about S), the pull `a` and the push `b` in inertial axes,

    d h_cm = int (tau - R r_cm x F) dt,    d v_cm = int (F / M + a + b) dt

and an accelerometer feels no pull. These are the columns of the estimators, along the
present motion. Gradients know how they depend on it:

    torques, pulls          on time alone
    on the base             int R_WB b(t) dt
    wheel losing speed      R_WB a l(t)
    drag at a pad           d v_cm = -c / M (x + v_cm t)
                            d h_cm = -c int x x (dx + v_cm dt) - c_r angle

with `x` from the CM, at `v_cm t`, to the pad. In space sizes go with the momentum and
the velocity of the motion at hand.
"""

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.agent import Disturbance
from orbident.environment.agents import AGENTS, FILM, FREE, STEADY, std_of
from orbident.environment.motion import PointMotion, RobotMotion, at_nodes, at_rest
from orbident.environment.worlds import (
    Scale,
    radius_of_gyration,
    scale_of,
    what_may_act,
)
from orbident.excitation.floating import (
    Gradient,
    NodalMotion,
    running_integral,
    running_integral_transposed,
)
from orbident.excitation.table_points import add_point
from orbident.model.kinematics import carrying_joints
from orbident.model.rotations import rotate
from orbident.robot.description import Robot
from orbident.robot.may_act import MayAct
from orbident.robot.parameters import cross_matrix

IN_TIME = {"torque", "slow_torque", "pull"}
LOSSES = ("wheel_loss",)
ON_THE_BASE = ("base_torque", "slow_base_torque")

UP = np.array([0.0, 0.0, 1.0])


def anything_may_act(robot: Robot) -> bool:
    """Whether anything has a size, whatever the motion."""
    allowed = what_may_act(robot, Scale(0.0, 1.0, 1.0, 1.0))
    return any(each.size for each in allowed.values())


class MomentumChanges(NamedTuple):
    """Of some numbers of what may act, at size one; inertial axes, SI."""

    numbers: tuple[Disturbance, ...]
    h: Float[np.ndarray, "n 3 numbers"]
    v: Float[np.ndarray, "n 3 numbers"]
    felt: Float[np.ndarray, "n 3 numbers"]
    torque: Float[np.ndarray, "n 3 numbers"]
    """About S."""


def _changes(
    at: RobotMotion, dt: float, r_cm: Float[np.ndarray, "n 3"], groups: AbstractSet[str]
) -> MomentumChanges:
    numbers = tuple(
        each
        for agent in AGENTS.values()
        if agent.group in groups
        for each in agent.columns(at)
    )
    if not numbers:
        return MomentumChanges((), *(np.zeros((4, at.t.size, 3, 0))))
    force, torque, pull, push = (
        at_nodes(np.stack(parts, axis=-1))
        for parts in zip(*(each.effect for each in numbers), strict=True)
    )
    h = running_integral(torque - np.cross(r_cm[..., None], force, axis=1), dt)
    felt = running_integral(force / at.robot.mass + push, dt)
    return MomentumChanges(numbers, h, felt + running_integral(pull, dt), felt, torque)


@lru_cache(maxsize=64)
def _still_changes(
    robot: Robot, nodes: int, dt: float, shortest: tuple[tuple[str, float | None], ...]
) -> MomentumChanges:
    """Of what depends on time alone: the same along each motion of a search."""
    allowed = {group: MayAct(1.0, least) for group, least in shortest}
    groups = {*allowed} | {STEADY[group] for group in allowed.keys() & STEADY}
    at = replace(at_rest(robot, dt * np.arange(nodes)), allowed=allowed)
    return _changes(at, dt, np.zeros((nodes, 3)), groups & IN_TIME)


class OutsideChanges:
    """Changes of the momenta by a deviation of each number of what may act."""

    h: Float[np.ndarray, "n 3 numbers"]
    """Of `h_cm`, inertial axes, N m s."""
    v: Float[np.ndarray, "n 3 numbers"]
    """Of `v_cm`, inertial axes, m/s."""
    felt: Float[np.ndarray, "n 3 numbers"]
    """The part of `v` that an accelerometer feels."""

    def __init__(self, motion: NodalMotion) -> None:
        """Along a motion at an odd number of nodes."""
        t = motion.dt * np.arange(len(motion.w))
        robot = motion.craft.robot
        self._scale = scale_of(robot, t, motion.qd_rw, motion.w, motion.v_S)
        self._at = at = RobotMotion(
            robot,
            t,
            motion.q,
            motion.qd,
            motion.R,
            motion.w,
            PointMotion(motion.r_S, motion.v_S),
            allowed=what_may_act(robot, self._scale),
        )
        allowed = {group: each for group, each in at.allowed.items() if each.size}
        groups = {*allowed} | {STEADY[group] for group in allowed.keys() & STEADY}
        shortest = tuple((name, each.shortest) for name, each in allowed.items())
        still = _still_changes(at.robot, at.t.size, motion.dt, shortest)
        r_cm = rotate(motion.R, motion.r_cm)
        moving = _changes(at, motion.dt, r_cm, groups - IN_TIME)
        # Those from here on depend on how the robot moves.
        self._first = len(still.numbers)
        numbers = (*still.numbers, *moving.numbers)
        stds = np.array([std_of(each, at.allowed) for each in numbers])
        self._numbers, self._all_stds = numbers, stds
        self.h, self.v, self.felt = (
            np.concatenate(parts, axis=2) * stds
            for parts in zip(still[1:4], moving[1:4], strict=True)
        )
        self._stds = stds[self._first :]
        self._torque = moving.torque * self._stds
        self._of = {
            group: [k for k, each in enumerate(moving.numbers) if each.group == group]
            for group in groups
        }

    @property
    def drift(self) -> float:
        """How far along an axis what has a size moves the robot at most, m.

        It is one standard deviation; what may be anything has no size.
        """
        sized = self._all_stds < FREE
        moved = running_integral(self.v[..., sized], self._at.t[1] - self._at.t[0])
        return float(np.sqrt(np.sum(moved**2, axis=2)).max())

    def add_v(self, f: Gradient, by_v: Float[np.ndarray, "n v numbers"]) -> None:
        """Adds the gradient, from that with respect to `v`."""
        by_v = by_v[:, :, self._first :]
        for i, pad, pushed, _ in self._pads:
            by_x = np.zeros_like(f.w)
            by_x[:, :2] = -self._stds[pushed] / self._at.robot.mass * by_v[:, :, pushed]
            self._add_pad(f, i, pad, by_x, np.zeros(len(by_x)))

    def add_h(self, f: Gradient, by_h: Float[np.ndarray, "n h numbers"]) -> None:
        """Adds the gradient, from that with respect to `h`."""
        motion, by_h = f.motion, by_h[:, :, self._first :]
        lost, on_base = (
            [k for group in groups for k in self._of.get(group, ())]
            for groups in (LOSSES, ON_THE_BASE)
        )
        if lost:
            by = by_h[:, :, lost]
            h = self.h[:, :, self._first :][:, :, lost]
            f.R += by @ (np.swapaxes(h, 1, 2) @ motion.R)
        if on_base:
            by = running_integral_transposed(by_h[:, :, on_base], motion.dt)
            torque = self._torque[:, :, on_base]
            f.R += by @ (np.swapaxes(torque, 1, 2) @ motion.R)
        for i, pad, pushed, turned in self._pads:
            x = self._at.in_inertial(self._at.poses.arm(i, pad) - motion.r_cm)
            by_x = _by_area(x, motion.v_cm * motion.dt, by_h[:, 0, pushed])
            by_angle = -self._stds[turned] * by_h[:, 0, turned]
            self._add_pad(f, i, pad, -self._stds[pushed] * by_x, by_angle)

    def add_sizes(self, f: Gradient, by_log: Float[np.ndarray, " numbers"]) -> None:
        """Adds the gradient, from that with respect to the logarithms of all sizes."""
        for name, value, add in (
            ("h", self._scale.h, _add_scale_h),
            ("v", self._scale.v, lambda f, by: f.add_v_S(by * f.motion.v_S)),
        ):
            doubled = self._scale._replace(**{name: 2 * value})
            allowed = what_may_act(self._at.robot, doubled)
            if allowed != self._at.allowed:
                stds = [std_of(each, allowed) for each in self._numbers]
                # A size is proportional to it, or does not depend on it.
                by = np.sum(by_log * np.log2(stds / self._all_stds))
                add(f, by / value**2 / self._at.t.size)

    @property
    def _pads(self) -> Iterator[tuple[int, Float[np.ndarray, "3"], int, int]]:
        """The body that a pad is on, its place there, and the columns of its drag."""
        robot = self._at.robot
        pads = robot.pads or {robot.bodies[0]: np.zeros(3)}
        drag = self._of.get(FILM, [])
        columns = zip(drag[::2], drag[1::2], strict=True)
        for (body, pad), own in zip(pads.items(), columns, strict=False):
            yield robot.bodies.index(body), pad, *own

    def _add_pad(
        self,
        f: Gradient,
        body: int,
        pad: Float[np.ndarray, "3"],
        by_x: Float[np.ndarray, "n 3"],
        by_angle: Float[np.ndarray, " n"],
    ) -> None:
        """From the gradients by where a pad is from the CM, and how far it turned."""
        at, R = self._at, f.motion.R
        add_point(f, at.poses, (body, pad), by_x)
        f.R += by_angle[:, None, None] / 2 * (R @ cross_matrix(UP))
        by_q = by_angle[:, None] * at.poses.field_w[:, :, 2]
        f.q += carrying_joints(at.robot, body) * by_q


def _by_area(
    x: Float[np.ndarray, "n 3"],
    step: Float[np.ndarray, "3"],
    by_sums: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n 3"]:
    """The gradient of sums of `(x_i + x_i+1) / 2 x (x_i+1 - x_i + step)` about z.

    Both `x`, from the CM to a pad, and `step`, of the CM, go from node to node; the
    sums are from the first node on.
    """
    after = np.cumsum(by_sums[:0:-1])[::-1, None]
    by_x = np.zeros_like(x)
    by_x[:-1] = after * np.cross(x[1:] + step / 2, UP)
    by_x[1:] += after * np.cross(UP, x[:-1] - step / 2)
    return by_x


def _add_scale_h(f: Gradient, by: float) -> None:
    """From the gradient by half the sum of squares of `h` over the nodes."""
    motion, craft = f.motion, f.motion.craft
    wheels, robot = craft.wheels, craft.robot
    by_speed = by * (motion.qd_rw @ wheels.A_rw.T) @ wheels.A_rw
    f.w -= (by_speed * wheels.free) @ wheels.axes.T
    f.w += by * (robot.mass * radius_of_gyration(robot) ** 2) ** 2 * motion.w
