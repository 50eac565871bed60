"""What torque sensors at joints see of changes along a motion.

With the momenta `p` of the joints and the slopes `e` of the energy (Eq. 11), a sensor
shows as a mean over a step (`joint_torques.hpp`)

    (1 + g) (d(p + A qd)/dt - e + d qd + c sign(qd) + o)

with the rotor's `A`, the friction `d`, `c` and `o`, and an error `g` of its scale. `p`
and `e` change with `beta`, with the base rate, as momentum conservation changes it, and
where joints are elsewhere than they are shown.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.output_error.torques import driven_by
from orbident.estimation.unknowns import DRIVE
from orbident.excitation.floating import Gradient, NodalMotion
from orbident.excitation.instrument_changes import InstrumentChanges
from orbident.model.core_robot import core_tree
from orbident.model.minimal_sets import unseen_part
from orbident.robot.description import Robot

NODES = 4
"""From one step to the next: differences of velocities need nodes so much closer."""

STEP = 1e-7
"""Relative or rad/s: one-sided differences over it are good to seven digits."""

OF_A_SENSOR = ("torque_scale", *DRIVE)
"""The last words of errors that are of a joint's torque alone."""


class JointMomenta(NamedTuple):
    """`p` of some joints, then `e` of them, at some states; and their derivatives."""

    values: Float[np.ndarray, "n rows"]
    by_w: Float[np.ndarray, "n rows 3"]
    by_qd: Float[np.ndarray, "n rows joints"]
    by_q: Float[np.ndarray, "n rows joints"]
    by_beta: Float[np.ndarray, "n rows beta"]

    def add(
        self,
        f: Gradient,
        nodes: slice,
        by: Float[np.ndarray, "n rows"],
        scale: Float[np.ndarray, "1 joints"] | float = 1.0,
    ) -> None:
        """Adds the gradient, from that with respect to the values.

        The states are at these nodes of the motion; `scale` is of its joints in them.
        """
        by_w, by_qd, by_q = (
            np.einsum("nr,nrx->nx", by, x) for x in (self.by_w, self.by_qd, self.by_q)
        )
        f.w[nodes] += by_w
        f.qd[nodes] += by_qd * scale
        f.q[nodes] += by_q * scale


class Elsewhere(NamedTuple):
    """An error of where joints are, on one side of none."""

    column: int
    part: float
    """What changes by it are to be multiplied by."""
    momenta: JointMomenta
    scale: Float[np.ndarray, "1 joints"]


class TorqueChanges:
    """Mean torques that sensors show, step by step, and how they change."""

    def __init__(
        self,
        joints: tuple[int, ...],
        beta_of: Float[np.ndarray, "beta unknowns"],
        motion: NodalMotion,
        instruments: InstrumentChanges,
    ) -> None:
        """Work out the momenta of some joints along a motion at nodes.

        The joints are those whose torque counts, `beta_of` is `d beta` of a change of
        the unknowns, and the errors' columns follow those of the unknowns.
        """
        robot, sets = motion.craft.robot, motion.craft.sets
        self._robot, self._joints, self._beta_of = robot, joints, beta_of
        self._axes = list(sets.regressors.momentum_axes)
        self._nodes, self.dt = np.s_[::NODES], NODES * motion.dt
        self._q, self._qd, self._w = (
            x[self._nodes] for x in (motion.q, motion.qd, motion.w)
        )
        # What no motion shows of the bodies is as declared.
        self._theta_of = np.column_stack([sets.base.theta_of, unseen_part(robot, sets)])
        self._beta = np.tile(np.append(sets.beta(robot.theta), 1.0), (len(self._w), 1))
        self._at = self._momenta(robot, self._beta, self._q, self._qd, self._w)
        self._drives = driven_by(robot)[list(joints)].T
        self._elsewhere = [*self._where_joints_are_elsewhere(instruments)]
        of = {
            f"joint.{robot.joint_names[joint]}.{error}": (what, k)
            for what, error in enumerate(OF_A_SENSOR)
            for k, joint in enumerate(joints)
        }
        self._own = [
            (column, each.std, *of[each.name])
            for column, each in enumerate(instruments.errors)
            if each.name in of
        ]

    def rows(
        self, by_h: Float[np.ndarray, "n h columns"]
    ) -> Float[np.ndarray, "steps driven columns"]:
        """Changes of mean torques by one of each column.

        Those of the base rate, `by_h`, are as momentum conservation has it, in the axes
        in which it is conserved.
        """
        u, at = self._beta_of.shape[1], self._at
        changes = at.by_w[:, :, self._axes] @ by_h[self._nodes]
        changes[:, :, :u] += at.by_beta @ self._beta_of
        for each in self._elsewhere:
            changes[:, :, u + each.column] += each.part * each.momenta.values
        rows, shapes = self._by_step(changes), self._shapes()
        for column, std, what, k in self._own:
            rows[:, k, u + column] += std * shapes[what, :, k]
        return rows

    def add(
        self,
        f: Gradient,
        by_rows: Float[np.ndarray, "steps driven columns"],
        by_h: Float[np.ndarray, "n h columns"],
    ) -> Float[np.ndarray, "n h columns"]:
        """Adds the gradient from that of `rows`, and gives that of the momenta."""
        u = self._beta_of.shape[1]
        by_shapes = np.zeros((len(OF_A_SENSOR), *by_rows.shape[:2]))
        for column, std, what, k in self._own:
            by_shapes[what, :, k] += std * by_rows[:, k, u + column]
        self._add_shapes(f, by_shapes)
        by = self._by_step_transposed(by_rows)
        for each in self._elsewhere:
            on = each.part * by[:, :, u + each.column]
            each.momenta.add(f, self._nodes, on, each.scale)
        # Of the slopes: differences of those of all rows, each along its own change.
        by_beta = np.zeros((*by.shape[:2], self._beta.shape[1]))
        by_beta[:, :, :-1] = by[:, :, :u] @ self._beta_of.T
        by_w = np.zeros((*by.shape[:2], 3))
        by_w[:, :, self._axes] = by @ np.swapaxes(by_h[self._nodes], 1, 2)
        for row in range(by.shape[1]):
            beta, w = by_beta[:, row], by_w[:, row]
            size = np.hypot(
                np.linalg.norm(beta, axis=1) / np.linalg.norm(self._beta[0]),
                np.linalg.norm(w, axis=1),
            )[:, None]
            step = STEP / np.where(size > 0, size, 1.0)
            moved = self._momenta(
                *(self._robot, self._beta + step * beta),
                *(self._q, self._qd, self._w + step * w),
            )
            on = np.zeros(by.shape[:2])
            on[:, row] = 1 / step[:, 0]
            moved.add(f, self._nodes, on)
            self._at.add(f, self._nodes, -on)
        by_by_h = np.zeros_like(by_h)
        by_by_h[self._nodes] = np.swapaxes(self._at.by_w[:, :, self._axes], 1, 2) @ by
        return by_by_h

    def _momenta(
        self,
        robot: Robot,
        beta: Float[np.ndarray, "n beta"],
        q: Float[np.ndarray, "n joints"],
        qd: Float[np.ndarray, "n joints"],
        w: Float[np.ndarray, "n 3"],
    ) -> JointMomenta:
        joints = np.array(self._joints)
        tables = _core.joint_momenta(core_tree(robot), self._theta_of, beta, q, qd, w)
        K = q.shape[1]
        tables = tables[:, 3 + np.concatenate([joints, K + joints])]
        by_w, by_qd, by_q, by_beta = np.split(
            tables[:, :, 1:], np.cumsum([3, K, K]), axis=2
        )
        return JointMomenta(tables[:, :, 0], by_w, by_qd, by_q, by_beta[:, :, :-1])

    def _where_joints_are_elsewhere(
        self, instruments: InstrumentChanges
    ) -> Iterator[Elsewhere]:
        for at in instruments.elsewhere:
            q, qd = (
                x.reshape(len(at.errors), -1, x.shape[1])[:, self._nodes]
                for x in (at.q, at.qd)
            )
            for k, (of, part) in enumerate(at.errors):
                # Parts are of what is taken from the momentum that is conserved.
                momenta = self._momenta(at.robot, self._beta, q[k], qd[k], self._w)
                yield Elsewhere(of.column, -part, momenta, at.scale[k])

    def _by_step(
        self, x: Float[np.ndarray, "nodes rows *_"]
    ) -> Float[np.ndarray, "steps driven *_"]:
        """`dp/dt - e`."""
        p, e = np.split(x, 2, axis=1)
        return np.diff(p, axis=0) / self.dt - (e[1:] + e[:-1]) / 2

    def _by_step_transposed(
        self, by: Float[np.ndarray, "steps driven columns"]
    ) -> Float[np.ndarray, "nodes rows columns"]:
        by_e = -(np.pad(by, (*BEFORE, (0, 0))) + np.pad(by, (*AFTER, (0, 0)))) / 2
        return np.concatenate([_steps_transposed(by / self.dt), by_e], axis=1)

    def _shapes(self) -> Float[np.ndarray, "errors steps driven"]:
        """What a sensor shows by one of each error of its own."""
        q, qd = (x[:, list(self._joints)] for x in (self._q, self._qd))
        rates, moved = (np.diff(x, axis=0) / self.dt for x in (qd, q))
        sign, _ = _mean_signs(qd)
        drive = np.stack([rates, moved, sign, np.ones_like(sign)])
        torque = self._by_step(self._at.values)
        torque += np.einsum("wsk,wk->sk", drive, self._drives)
        return np.concatenate([torque[None], drive])

    def _add_shapes(
        self, f: Gradient, by_shapes: Float[np.ndarray, "errors steps driven"]
    ) -> None:
        """Adds the gradient, from that with respect to `_shapes`."""
        joints, by_torque = list(self._joints), by_shapes[:1]
        by_rate, by_moved, by_sign, _ = (
            by_shapes[1:] + self._drives[:, None] * by_torque
        )
        by_values = self._by_step_transposed(by_torque[0][..., None])
        self._at.add(f, self._nodes, by_values[..., 0])
        f.q[self._nodes][:, joints] += _steps_transposed(by_moved / self.dt)
        qd = self._qd[:, joints]
        sign, size = _mean_signs(qd)
        by_sign = by_sign / size
        f.qd[self._nodes][:, joints] += (
            _steps_transposed(by_rate / self.dt)
            + np.pad(by_sign * (1 - sign * np.sign(qd[1:])), BEFORE)
            + np.pad(by_sign * (1 - sign * np.sign(qd[:-1])), AFTER)
        )


BEFORE, AFTER = ((1, 0), (0, 0)), ((0, 1), (0, 0))
"""One row more."""


def _steps_transposed(
    by: Float[np.ndarray, "steps ..."],
) -> Float[np.ndarray, "nodes ..."]:
    """The gradient with respect to `x`, from that with respect to `x[1:] - x[:-1]`."""
    return -np.diff(by, axis=0, prepend=0, append=0)


def _mean_signs(
    x: Float[np.ndarray, "n columns"],
) -> tuple[Float[np.ndarray, "steps columns"], Float[np.ndarray, "steps columns"]]:
    """The mean sign of what changes linearly in each step, and the sum of sizes."""
    size = np.abs(x[1:]) + np.abs(x[:-1])
    size = np.where(size > 0, size, 1.0)
    return (x[1:] + x[:-1]) / size, size
