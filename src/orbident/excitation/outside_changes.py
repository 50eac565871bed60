"""What may act from outside changes both momenta along a motion.

With `F`, `tau` (about S), the pull `a` and the push `b` in inertial axes,

    d h_cm = int (tau - R r_cm x F) dt,    d v_cm = int (F / M + a + b) dt

and an accelerometer feels no pull. These are the columns of the estimators, along the
present motion. Torques and pulls depend on time alone. The drag of a film follows the
pads, at `x` from the CM: with the CM at `v_cm t`,

    d v_cm = -c / M (x + v_cm t),    d h_cm = -c int x x (dx + v_cm dt)

Gradients hold what drag owes to the motion, but take sizes that go with the motion's
momentum, and what turns with the base, as they are.
"""

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import AGENTS, FILM, STEADY, std_of
from orbident.environment.motion import PointMotion, RobotMotion, by_step
from orbident.environment.worlds import scale_of, what_may_act
from orbident.estimation.output_error.followed import integral
from orbident.excitation.floating import Gradient, NodalMotion
from orbident.model.kinematics import carrying_joints
from orbident.model.rotations import rotate, rotate_back
from orbident.robot.parameters import cross_matrix

UP = np.array([0.0, 0.0, 1.0])


class OutsideChanges:
    """Changes of the momenta by a deviation of each number of what may act."""

    h: Float[np.ndarray, "n 3 numbers"]
    """Of `h_cm`, inertial axes, N m s."""
    v: Float[np.ndarray, "n 3 numbers"]
    """Of `v_cm`, inertial axes, m/s."""
    felt: Float[np.ndarray, "n 3 numbers"]
    """The part of `v` that an accelerometer feels."""

    def __init__(self, motion: NodalMotion) -> None:
        """Along a motion at an odd number of nodes, where anything may act."""
        at = robot_motion(motion)
        groups = {group for group, each in at.allowed.items() if each.size}
        groups |= {STEADY[group] for group in groups & STEADY.keys()}
        every = [
            each
            for agent in AGENTS.values()
            if agent.group in groups
            for each in agent.columns(at)
        ]
        self._at = at
        self._stds = [std_of(each, at.allowed) for each in every]
        self._drag = [k for k, each in enumerate(every) if each.group == FILM]
        self.h = self.v = self.felt = np.zeros((at.t.size, 3, len(every)))
        if every:
            force, torque, pull, push = (
                np.stack(parts, axis=-1) * self._stds
                for parts in zip(*(each.effect for each in every), strict=True)
            )
            r_cm = by_step(rotate(motion.R, motion.r_cm))[..., None]
            self.h = integral(at.t, torque - np.cross(r_cm, force, axis=2))
            self.felt = integral(at.t, force / at.robot.mass + push)
            self.v = self.felt + integral(at.t, pull)

    def add(
        self,
        f: Gradient,
        by_h: Float[np.ndarray, "n h numbers"],
        by_v: Float[np.ndarray, "n v numbers"],
    ) -> None:
        """Adds the gradient, from those with respect to `h` and `v`: that of drag."""
        at, motion, stds = self._at, f.motion, self._stds
        pads = at.robot.pads or {at.robot.bodies[0]: np.zeros(3)}
        columns = np.reshape(self._drag, (-1, 2))
        for (body, pad), (pushed, turned) in zip(pads.items(), columns, strict=False):
            i, c, c_r = at.robot.bodies.index(body), stds[pushed], stds[turned]
            arm = at.arm(i, pad)
            u = arm - motion.r_cm
            by_x = np.zeros_like(u)
            by_x[:, :2] = -c / at.robot.mass * by_v[:, :, pushed]
            by_x -= c * _by_area(
                rotate(motion.R, u), motion.v_cm * motion.dt, by_h[:, 0, pushed]
            )
            by_angle = -c_r * by_h[:, 0, turned]
            f.R += by_x[:, :, None] * u[:, None]
            f.R += by_angle[:, None, None] / 2 * (motion.R @ cross_matrix(UP))
            by_u = rotate_back(motion.R, by_x)
            f.r_cm -= by_u
            poses = at.poses
            by_q = (poses.field_u + np.cross(poses.field_w, arm[:, None])) @ by_u[
                ..., None
            ]
            f.q += carrying_joints(at.robot, i) * (
                by_q[..., 0] + by_angle[:, None] * poses.field_w[:, :, 2]
            )


def _by_area(
    x: Float[np.ndarray, "n 3"],
    step: Float[np.ndarray, "3"],
    by_sums: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n 3"]:
    """The gradient of sums of `(x_i + x_i+1) / 2 x (x_i+1 - x_i + step)` about z.

    Args:
        x: from the CM to a pad, node by node.
        step: of the CM, from node to node.
        by_sums: the gradient with respect to the sums from the first node on.
    """
    after = np.cumsum(by_sums[:0:-1])[::-1, None]
    by_x = np.zeros_like(x)
    by_x[:-1] = after * np.cross(x[1:] + step / 2, UP)
    by_x[1:] += after * np.cross(UP, x[:-1] - step / 2)
    return by_x


def robot_motion(motion: NodalMotion) -> RobotMotion:
    """The motion as what acts from outside knows it, with what may act on it."""
    robot = motion.craft.robot
    t = motion.dt * np.arange(len(motion.w))
    r_cm = rotate(motion.R, motion.r_cm)
    S = PointMotion(np.outer(t, motion.v_cm) + r_cm[0] - r_cm, motion.v_S)
    scale = scale_of(robot, t, motion.qd_rw, motion.w, S.v)
    return RobotMotion(
        robot,
        t,
        motion.q,
        motion.qd,
        motion.R,
        motion.w,
        S,
        allowed=what_may_act(robot, scale),
    )
