"""Torque columns of another sign, order or unit, as CAD and the motion show them.

What a motion takes of joints follows from CAD values within what these are off. Of a
column that is written as it should be little is left beside it, friction and what a
motor's rotor takes. Where another joint, sign or unit leaves far less, it is that.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.optimize import linear_sum_assignment, nnls

from orbident.estimation.checks import Check
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import joints_with_torques, torque_column
from orbident.files.names import joined
from orbident.model.equations_of_motion import motion_with, movable
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

ROWS = 2000
"""So many samples, spread over a recording, show a wrong column as well as all do."""

KNOWN = 5.0
"""Times: what joints carry is known better than that before they are built."""

FAR_BETTER = 10.0
"""Times less that is left of the squares of a column that is wrong, put right. With CAD
values 10 % off, columns written right left 0.2 to 2 %, and other ones half and more."""

FEWEST = 100
"""Samples: of fewer, five numbers explain too much."""

TINY = 1e-300
"""In place of nothing, whose logarithm is no number."""

LEFT = 0.3
"""The most that may be left of the squares of a column where it is written right."""

MILLI = 1e3
"""Columns in mN m are so many times too large."""


class MeasuredMotion(NamedTuple):
    """How base, joints and wheels move, by what was measured."""

    q: Float[np.ndarray, "n joints"]
    """Joint positions, rad or m."""
    rates: Float[np.ndarray, "n rates"]
    """Rates of the base, of joints and of wheels, rad/s or m/s."""
    accelerations: Float[np.ndarray, "n rates"]
    """Derivatives of the rates, rad/s^2 or m/s^2."""

    def torques(self, robot: Robot) -> Float[np.ndarray, "n joints"]:
        """What it takes of joints of such bodies whose base floats, N m or N."""
        may = movable(robot)
        none, joints = np.zeros((len(self.q), 3)), slice(6, 6 + self.q.shape[1])
        free = may & (np.arange(may.size) < joints.start)
        v, v_dot = (np.hstack([none, x]) * may for x in self[1:])
        return motion_with(robot, self.q, v, v_dot * ~free, free).Q[:, joints]


def measured_motion(samples: Samples, t: Float[np.ndarray, " n"]) -> MeasuredMotion:
    """The motion at these times, s, or at the nearest one that has samples."""
    moved = np.column_stack([*samples.w, *samples.qd, *samples.qd_rw])
    seen = np.isfinite(moved).all(axis=1)
    q = CubicSpline(samples.t[seen], np.column_stack(samples.q)[seen])
    rates = CubicSpline(samples.t[seen], moved[seen])
    t = np.clip(t, *samples.t[seen][[0, -1]])
    return MeasuredMotion(q(t), rates(t), rates(t, 1))


class ColumnFit(NamedTuple):
    """How a column shows the torque of a joint."""

    as_it_should: float
    """Part of the column's squares that is left with a gain that CAD allows."""
    sign: float
    """Sign of the whole column: 1 as it should be, -1 where it is the opposite."""
    gain: float
    """Times the torque by CAD that the column shows; zero where friction is all."""
    left: float
    """Part of the squares that is left with this gain."""


def plain_torques(problem: MomentumProblem) -> list[Check]:
    """Torque columns that are plainly written otherwise, which no fit is needed to see.

    Thrust pulls at joints, and passive ones move by themselves: then nothing is said.
    """
    robot, samples = problem.robot, problem.samples
    names = joints_with_torques(robot, problem.recording)
    if not names or samples.wrenches or robot.passive:
        return []
    t = problem.recording.t
    columns = [problem.recording.columns[torque_column(name)] for name in names]
    rows = np.isfinite(columns).all(axis=0)
    at = np.flatnonzero(rows)[:: max(int(rows.sum()) // ROWS, 1)]
    if at.size < FEWEST:
        return []
    motion = measured_motion(samples, t[at])
    taken, of_rates = motion.torques(robot), slice(3, 3 + len(robot.joints))
    qd, qdd = motion.rates[:, of_rates], motion.accelerations[:, of_rates]
    joints = [robot.joint_names.index(name) for name in names]
    table = [
        [_shown(column[at], taken[:, k], qd[:, k], qdd[:, k]) for k in joints]
        for column in columns
    ]
    words = "; ".join(_wrong(names, table))
    reason = f"{words}: CAD and the motion explain them then, and not as recorded"
    remedy = "correct the columns, or the robot file"
    return [Check("cause", "do not trust", reason, remedy)] if words else []


def _shown(
    column: Float[np.ndarray, " n"],
    taken: Float[np.ndarray, " n"],
    qd: Float[np.ndarray, " n"],
    qdd: Float[np.ndarray, " n"],
) -> ColumnFit:
    """A column as the torque of a joint, with friction and a rotor of at least zero."""
    whole = max(float(np.sum(np.square(column - column.mean()))), TINY)
    fits = []
    for sign in (1.0, -1.0):
        other = sign * np.column_stack([qdd, qd, np.sign(qd)])
        beside = np.column_stack([other, np.ones_like(qd), -np.ones_like(qd)])
        own = sign * taken
        (gain, *_), left = nnls(np.column_stack([own, beside]), column)
        # Friction and a rotor may be all that a column shows.
        known = 0.0, np.clip(gain, 1 / KNOWN, KNOWN)
        held = min(nnls(beside, column - each * own)[1] for each in known)
        fits.append(ColumnFit(held**2 / whole, sign, gain, max(left**2 / whole, TINY)))
    # As it should be, the sign is the first one.
    return min(fits, key=lambda fit: fit.left)._replace(
        as_it_should=fits[0].as_it_should
    )


def _wrong(names: Sequence[str], table: Sequence[Sequence[ColumnFit]]) -> Iterator[str]:
    """What is wrong, by how each column shows each joint."""
    left = np.array([[each.left for each in row] for row in table])
    _, owners = linear_sum_assignment(np.log(left))
    true = [row[k] for row, k in zip(table, owners, strict=True)]
    plain = [
        one.left < min(LEFT, row[k].as_it_should / FAR_BETTER)
        for k, (one, row) in enumerate(zip(true, table, strict=True))
    ]
    moved = [k for k, owner in enumerate(owners.tolist()) if owner != k]
    if moved and all(plain[k] for k in moved):
        order = joined([f"{names[k]} shows {names[owners[k]]}" for k in moved])
        yield f"torques are in another order, or the joints are ({order})"
    turned = [names[k] for k, one in enumerate(true) if plain[k] and one.sign < 0]
    if turned:
        of = joined(turned)
        yield f"the sign of the torque of {of}, or of the joint, is the opposite"
    # A link that is heavier than CAD has it, as with a load, is right as recorded.
    far = [
        (name, one)
        for name, one in zip(names, true, strict=True)
        if one.left < LEFT and (0 < one.gain < 1 / KNOWN or one.gain > MILLI / KNOWN)
    ]
    # Of a unit that is the same for all, each column says something.
    if np.prod([one.as_it_should / one.left for _, one in far]) > FAR_BETTER:
        gain = float(np.median([one.gain for _, one in far]))
        which = joined([name for name, _ in far])
        yield f"the torque of {which} is " + (
            f"{gain:.2g} times what CAD says (its unit, or the motor's side of a gear)"
            if gain < 1
            else "in mN m"
        )
