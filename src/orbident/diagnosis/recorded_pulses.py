"""What each column of thrusters does, and what is then wrong with them.

With nominal bodies the momentum is known, and over a block of time it changes by

    dp = sum over k of (int R_WB u_k dt) F_k,   dh = sum over k of (int R_WB u_k dt) n_k

and by what a constant force and torque give, `u_k` the recorded level of a thruster,
`F_k` its force and `n_k` its moment about the CM in base axes. Both are found by least
squares, at that time of the commands which explains most. What a column does then says
which thruster it belongs to.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

from orbident.diagnosis.trial import Trial, amended_trial
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.files.names import joined
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.recordings.columns import OF_PARTS, part_of
from orbident.recordings.recording import Recording

ROWS = 4000
"""So many from the beginning show what columns do as well as all of them do."""

BLOCK = 0.5
"""s: the momentum changes by far more than its noise, and few pulses are in a block."""

FARTHEST = 10.0
"""s: commands whose zero is farther off are looked for in vain, if pulses alternate."""

APART = 0.05
"""s: between times of the commands that are tried; valves need as much to open."""

EXPLAINED = 0.5
"""Part of the squared changes of momentum that pulses explain at least where times are
right; by chance it is a tenth."""

ALIKE = 0.8
"""Cosine between what a column does and what a thruster would do."""

FAR_OFF = 0.3
"""s, or twice the tolerance of the thrusters' clock: a fit finds less, and better."""

SOME = 0.3
"""Part of the median effect below which a column shows too little: a dead valve."""

FEWEST = 4
"""Rows of a recording, and blocks for each unknown."""


class ShownPulses(NamedTuple):
    """What columns of thrusters do, at the time that explains most."""

    names: tuple[str, ...]
    """The thrusters that were recorded to act."""
    late: float
    """s, after their commands."""
    explained: float
    """Part of the squared changes of momentum."""
    alike: Float[np.ndarray, "columns thrusters"]
    """Cosines; NaN of a column that shows too little."""


class _MomentumChanges(NamedTuple):
    """Changes of momentum over blocks, in the axes that are free, and their times."""

    t: Float[np.ndarray, " rows"]
    R_WB: Float[np.ndarray, "rows 3 3"]
    edges: Sequence[int]
    """Rows at which blocks begin and end."""
    p: Float[np.ndarray, "blocks v"]
    h: Float[np.ndarray, "blocks h"]


def pulses_put_right(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with the columns of thrusters as they act, if that is not so yet.

    Args:
        problem: of a recording that is refused.
    """
    shown = shown_pulses(problem)
    if shown is None or shown.explained < EXPLAINED:
        return
    causes, robot, recording = [], problem.robot, problem.recording
    alike = np.nan_to_num(shown.alike)
    as_named = range(len(shown.names))
    # Where thrusters face each other, all reversed may be all exchanged.
    order, turn = max(
        ((tuple(as_named), 1), (tuple(as_named), -1), (_assigned(alike), 1)),
        key=lambda way: min(np.median(_of_pairs(way[1] * alike, way[0])), ALIKE),
    )
    if np.median(_of_pairs(turn * alike, order)) < ALIKE:
        return
    if turn < 0:
        alike = -alike
        turned = tuple(replace(x, direction=-x.direction) for x in robot.thrusters)
        robot = replace(robot, thrusters=turned)
        causes.append(
            "thrusters push the other way than the robot file says ('direction' is "
            "that of the force on the robot, and not of the gas)"
        )
    order = _assigned(alike)
    if any(_of_pairs(alike, order) - _of_pairs(alike, as_named) > 1 - ALIKE):
        causes.append(_order_in_words(shown.names, order))
        recording = _renamed(recording, shown.names, order)
    if abs(shown.late) > max(FAR_OFF, 2 * problem.robot.tolerances.thruster_clock):
        way = "after" if shown.late > 0 else "before"
        causes.append(
            f"the commands of thrusters act {abs(shown.late):.2g} s {way} the times at "
            "which they are recorded (another clock, or another zero of it)"
        )
        recording = _shifted(recording, shown.late)
    if causes:
        yield amended_trial(" and ".join(causes), problem, robot, recording, True)


def slow_duty(problem: MomentumProblem) -> str | None:
    """Whether duty may have lost pulses because it is recorded less often than rows.

    Args:
        problem: of a recording that is refused.
    """
    t = problem.recording.t
    on = [each.force.any(axis=1) for each in problem.samples.wrenches if each.valve]
    switched = np.flatnonzero(np.any(np.diff(on), axis=0)) + 1 if on else np.zeros(0)
    if switched.size < FEWEST:
        return None
    every = int(np.gcd.reduce(switched - switched[0]))
    if every < 2:
        return None
    row = float(np.median(np.diff(t)))
    return (
        f"perhaps the duty of thrusters is recorded too seldom: it changes every "
        f"{every * row:.3g} s at most, and rows come every {row:.3g} s; of pulses that "
        "begin or end in between the impulse is lost"
    )


def _assigned(alike: Float[np.ndarray, "columns thrusters"]) -> tuple[int, ...]:
    """The thruster of each column, so that all together are most alike."""
    return tuple(linear_sum_assignment(-alike)[1].tolist())


def _of_pairs(
    alike: Float[np.ndarray, "columns thrusters"], order: Sequence[int]
) -> Float[np.ndarray, " columns"]:
    """Cosines of columns that show something; one of those that do not."""
    pairs = alike[np.arange(len(order)), list(order)]
    return np.where(alike.any(axis=1), pairs, 1.0)


def _order_in_words(names: Sequence[str], order: Sequence[int]) -> str:
    steps = {(j - k) % len(names) for k, j in enumerate(order)}
    if len(steps) == 1:
        return (
            f"thrusters are numbered from another corner: what is recorded as "
            f"{names[0]} is {names[order[0]]} of the robot file, and so on around"
        )
    other = (f"{names[k]} is {names[j]}" for k, j in enumerate(order) if j != k)
    return f"columns of thrusters are exchanged: what is recorded as {joined(other)}"


def _renamed(
    recording: Recording, names: Sequence[str], order: Sequence[int]
) -> Recording:
    """What a column does under the name of the thruster that does it."""
    right = {
        f"thruster.{names[j]}.{kind}": recording.columns[f"thruster.{names[k]}.{kind}"]
        for k, j in enumerate(order)
        for kind in OF_PARTS["thruster"]
        if recording.has(f"thruster.{names[k]}.{kind}")
    }
    return recording.with_columns(right)


def _shifted(recording: Recording, late: float) -> Recording:
    """Commands at the times at which they act, as long as they are known."""
    t, right = recording.t, {}
    for name, x in recording.columns.items():
        if part_of("thruster", name) is not None:
            seen = np.isfinite(x)
            held = np.searchsorted(t[seen] + late, t, side="right") - 1
            right[name] = x[seen][np.maximum(held, 0)]
    known = recording.with_columns(right)
    return known.between(t[0] + max(late, 0.0), t[-1] + min(late, 0.0))


def shown_pulses(problem: MomentumProblem) -> ShownPulses | None:
    """What columns do; None where hardly anything of it shows.

    Args:
        problem: of a recording.
    """
    problem = problem.beginning(ROWS)
    valves = [each for each in problem.samples.wrenches if each.valve]
    changes = _changes(problem) if valves and problem.samples.v_S else None
    if changes is None or len(changes.p) < FEWEST * len(valves):
        return None
    h, v = problem.robot.conserved_axes
    sizes = [np.linalg.norm(each.force, axis=1) for each in valves]
    levels = np.array([x / x.max() for x in sizes])
    times = np.arange(-FARTHEST, FARTHEST + APART, APART)
    fits = [_fitted(changes, problem.samples.t, levels, late, h, v) for late in times]
    best = int(np.argmax([fit[0] for fit in fits]))
    explained, found = fits[best]
    declared = np.array([_declared(problem, each, h, v) for each in valves])
    # A moment counts as a force does that acts as far away as thrusters do.
    far = np.linalg.norm(declared[:, : len(v)]) / np.linalg.norm(declared[:, len(v) :])
    scale = np.concatenate([np.ones(len(v)), np.full(len(h), far)])
    found, declared = found * scale, declared * scale
    size = np.linalg.norm(found, axis=1)
    found[size < SOME * np.median(size)] = np.nan
    alike = _units(found) @ _units(declared).T
    names = tuple(each.name.removeprefix("thruster.") for each in valves)
    return ShownPulses(names, float(times[best]), explained, alike)


def _units(x: Float[np.ndarray, "n m"]) -> Float[np.ndarray, "n m"]:
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def _declared(
    problem: MomentumProblem,
    wrench: RecordedWrench,
    h: Sequence[int],
    v: Sequence[int],
) -> Float[np.ndarray, " axes"]:
    """Force and moment about the CM of a full pulse, as they were declared."""
    at = int(np.argmax(np.linalg.norm(wrench.force, axis=1)))
    q = problem.samples.configurations(1)
    r_cm = inertia(problem.robot, q).r_cm[0]
    torque = wrench.torque[at] - np.cross(r_cm, wrench.force[at])
    return np.concatenate([wrench.force[at][list(v)], torque[list(h)]])


def _changes(problem: MomentumProblem) -> _MomentumChanges | None:
    """The momentum of the nominal bodies, from block to block."""
    robot = problem.robot
    t, seen = problem.samples.complete()
    t, seen = t[seen.moving], type(seen)(*(each[seen.moving] for each in seen))
    if t.size < FEWEST:
        return None
    at, R_WB = inertia(robot, seen.q), quaternion_matrix(seen.x_WB)
    h_B = rotate(at.D, seen.w) + rotate(at.D_q, seen.qd)
    h_B += seen.qd_rw @ wheels_of(robot).A_rw.T
    v_B = np.cross(seen.w, at.r_cm) + rotate(at.J_cm, seen.qd)
    edges = np.unique(np.searchsorted(t, np.arange(t[0], t[-1], BLOCK)))
    p, h = robot.mass * (seen.v_S + rotate(R_WB, v_B)), rotate(R_WB, h_B)
    turning, moving = (list(axes) for axes in robot.conserved_axes)
    p, h = (np.diff(x[edges], axis=0) for x in (p[:, moving], h[:, turning]))
    return _MomentumChanges(t, R_WB, edges.tolist(), p, h)


def _fitted(
    changes: _MomentumChanges,
    rows: Float[np.ndarray, " samples"],
    levels: Float[np.ndarray, "columns samples"],
    late: float,
    h: Sequence[int],
    v: Sequence[int],
) -> tuple[float, Float[np.ndarray, "columns axes"]]:
    """The part that is explained, and what each column does."""
    t, edges = changes.t, changes.edges
    held = np.searchsorted(rows, t - late + APART / FEWEST, side="right") - 1
    u = levels[:, np.maximum(held, 0)]
    # R_WB u is held from a row until the next.
    turned = u[:, :-1, None, None] * (np.diff(t)[:, None, None] * changes.R_WB[:-1])
    summed = np.concatenate(
        [np.zeros_like(turned[:, :1]), np.cumsum(turned, axis=1)], axis=1
    )
    given = np.diff(summed[:, edges], axis=1)
    lasting = np.diff(t[edges])
    parts, found = [], []
    for y, axes in ((changes.p, v), (changes.h, h)):
        own = given[:, :, list(axes)][..., list(axes)]
        # Rows are blocks and axes; columns are thrusters and axes.
        A = own.transpose(1, 2, 0, 3).reshape(y.size, -1)
        steady = np.einsum("b,ij->bij", lasting, np.eye(len(axes)))
        steady = steady.reshape(y.size, len(axes))
        x = np.linalg.lstsq(np.hstack([A, steady]), y.ravel())[0]
        left = y.ravel() - np.hstack([A, steady]) @ x
        without = y.ravel() - steady @ np.linalg.lstsq(steady, y.ravel())[0]
        parts.append(1 - left @ left / (without @ without))
        found.append(x[: -len(axes)].reshape(len(levels), len(axes)))
    return float(np.mean(parts)), np.hstack(found)
