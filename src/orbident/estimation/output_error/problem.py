"""All equations of a recording, and a state where they are linearised.

The unknowns are those of each boundary between shooting intervals, `z`, and those that
all have in common, `g = [outside | beta | calibration]`. The core linearises interval
after interval and eliminates what belongs to one of them alone, from both ends of the
recording to a boundary in its middle, the meeting one.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import Rotation, Slerp

from orbident import _core
from orbident.environment.agents import AGENTS, FREE
from orbident.estimation.allowance import spend
from orbident.estimation.output_error.acting import Acting, Followed
from orbident.estimation.output_error.calibration import (
    NOTHING_FREE,
    calibrations_of,
)
from orbident.estimation.output_error.joint_laws import (
    IDEAL,
    joint_laws,
    longest_interval,
)
from orbident.estimation.output_error.looseness import CONTINUOUS, Looseness, looseness
from orbident.estimation.output_error.sensors import (
    TORQUES,
    Lasting,
    Sensors,
    at_level,
    lasting_noise,
    walks_of_rates,
)
from orbident.estimation.output_error.shooting import intervals_of, substeps_of
from orbident.estimation.output_error.torques import (
    driven_by,
    joints_driven,
    mean_torques,
)
from orbident.estimation.solution import (
    BySensor,
    Linear,
    Outside,
    Unknowns,
)
from orbident.estimation.unknowns import Unknown
from orbident.model.core_robot import core_tree, wheels_of
from orbident.model.minimal_sets import MinimalSets, unseen_part
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.wrenches import thrust_seen
from orbident.robot.description import Robot
from orbident.threads import processors

SENSORS = (
    *("gyro", "accelerometer", "attitude", "joints", "position", "velocity"),
    TORQUES,
)
"""The sensors, in the core's order."""

NO_ROWS = np.zeros((0, 3))
"""The samples of a sensor that was not recorded."""

NEGLIGIBLE = 0.1
"""Deviations of all samples together. Of a size that shows less, what acts moves no
parameter by more of its deviation, which would be half a percent larger: it would be an
unknown that only takes time. Waves of noise each move another sum of samples."""

NOTHING_SEEN: Mapping[str, float] = {}

NOTHING = Outside(*np.zeros((len(Outside._fields), 3)))


class Problem(NamedTuple):
    """A robot and what was recorded of it."""

    recorded: _core.Recorded
    t: Float[np.ndarray, " rows"]
    """s."""
    boundaries: Float[np.ndarray, " boundaries"]
    """Times at which intervals meet, s."""
    samples: BySensor
    """What each sensor showed; NaN in rows without a sample."""
    weights: BySensor
    """1 over the noise's standard deviation; zero where there was no sample."""
    loose: Looseness
    lasting: Lasting
    """What lasts of the noise of attitude and position."""
    walking: tuple[str, ...]
    """Walks of the momentum that are among it, and of which no density is declared."""
    instruments: tuple[Unknown, ...]
    """The errors that act on it, and gains of recorded thrust."""
    acting: Acting
    """What may act from outside."""
    shows: Mapping[str, float] = NOTHING_SEEN
    """How much of what acts all samples show, in their deviations, by one of its unit;
    what is not among these is not worked out."""

    @property
    def declared(self) -> tuple[Unknown, ...]:
        """Those errors that are unknown in every fit: they have a tolerance."""
        return tuple(each for each in self.instruments if each.std)

    @property
    def gains(self) -> set[str]:
        """Gains of recorded thrust and torque, each a family of its own."""
        return {each.family for each in self.acting.recorded}

    @property
    def expected(self) -> tuple[Unknown, ...]:
        """What may act, and is unknown in every fit: it has a size that would show."""
        return tuple(
            each
            for each in self.acting.expected
            if each.std == FREE
            or each.std * self.shows.get(each.name, np.inf) > NEGLIGIBLE
        )

    def unknowns(self, names: Collection[str]) -> tuple[Unknown, ...]:
        """All that have one of these names, or are of one of these families."""
        named = tuple(each for each in self.instruments if {*each[:2]} & {*names})
        if {*names} <= {name for each in named for name in each[:2]}:
            # What may act takes some 3 kB a row to work out.
            return named
        acting = (each for each in self.acting.unknowns if each.family in names)
        return (*named, *acting)


def linear(problem: Problem, weights: BySensor, state: Unknowns) -> Linear:
    """Linearise all intervals and eliminate what belongs to one of them alone."""
    at = _arguments(problem, weights, state)
    factor, links, cost, residuals = _linearised(problem, at, False)
    return Linear(factor, links, cost, _by_sensor(residuals, weights), state)


def _by_sensor(
    tables: Sequence[Float[np.ndarray, "_ _"]], weights: BySensor
) -> dict[str, Float[np.ndarray, "_ _"]]:
    named = zip(SENSORS, tables, strict=True)
    return {name: table for name, table in named if name in weights}


def common_factor(
    problem: Problem, weights: BySensor, state: Unknowns
) -> Float[np.ndarray, "n n"]:
    """The same equations over `[g, rhs]`: all that they say of the common unknowns."""
    factor, *_ = _linearised(problem, _arguments(problem, weights, state), True)
    local = problem.recorded.local
    return factor[local:, local:]


def changes_factor(
    problem: Problem,
    weights: BySensor,
    state: Unknowns,
    changed: Sequence[tuple[Problem, Float[np.ndarray, " selected"]]],
    sizes: Float[np.ndarray, " changes"],
) -> Float[np.ndarray, "n n"]:
    """`common_factor` of `[g, changes, rhs]`: what changes of a recording would show.

    Args:
        problem: of the recording.
        weights: of all of them.
        state: where all are linearised.
        changed: the recordings that are changed, each with the places of the errors
            that the state has; what acts is the same.
        sizes: of each change.
    """
    at = _arguments(problem, weights, state)
    acts = state.selected >= problem.acting.first
    values = np.delete(at["acting"], 1 + np.arange(np.count_nonzero(acts)), axis=2)
    own = np.delete(state.common, state.common.size - acts.size + np.flatnonzero(acts))
    others = [(each.recorded, values, own, places[~acts]) for each, places in changed]
    spend(problem.t.size * (1 + len(changed)), problem.recorded.local)
    factor = _core.changes_factor(
        problem.recorded, **at, changed=others, sizes=sizes, threads=processors()
    )
    local = problem.recorded.local
    return factor[local:, local:]


def _linearised(
    problem: Problem, at: Mapping[str, Any], factor_only: bool
) -> tuple[
    Float[np.ndarray, "n n"],
    Float[np.ndarray, "intervals local columns"],
    float,
    list[Float[np.ndarray, "_ _"]],
]:
    spend(problem.t.size, problem.recorded.local + len(at["common"]))
    return _core.linearised(
        problem.recorded, **at, threads=processors(), factor_only=factor_only
    )


def by_interval(
    problem: Problem, weights: BySensor, state: Unknowns
) -> Iterator[Float[np.ndarray, "rows columns"]]:
    """The equations of each interval, over `[z at its start, z at its end, g, rhs]`."""
    at = _arguments(problem, weights, state)
    for k in range(problem.boundaries.size - 1):
        yield _core.interval_equations(problem.recorded, **at, interval=k)


def _arguments(problem: Problem, weights: BySensor, state: Unknowns) -> dict[str, Any]:
    """What the core linearises at."""
    return {
        "weights": [
            np.ascontiguousarray(weights.get(name, NO_ROWS)) for name in SENSORS
        ],
        "coloured": at_level(problem.lasting, problem.weights, weights),
        "acting": problem.acting.table(state.beta, state.calibration, state.selected),
        **state._asdict(),
    }


def problem_of(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    sensors: Sensors,
    free: Mapping[str, float] = NOTHING_FREE,
    unexplained: float = IDEAL,
    turning: float = CONTINUOUS,
    like: Problem | None = None,
) -> Problem:
    """The equations of a recording.

    Args:
        robot: geometry and wheels, and a nominal inertia for the sizes of steps.
        sets: its minimal sets.
        samples: histories of joints and wheels.
        sensors: what is predicted.
        free: standard deviations beforehand in place of tolerances, by family or by
            name; SI.
        unexplained: what no spring explains moves passive joints by so much in a
            period, rad or m.
        turning: what the attitude walks at least, rad/sqrt(s).
        like: the equations of a recording that differs little: it is cut into the same
            intervals, and what acts is worked out along the same motion.
    """
    longest = longest_interval(robot, unexplained)
    followed = like and like.acting.followed
    like_these = followed and followed.intervals
    intervals = intervals_of(robot, samples, sensors, longest, like_these)
    walks = walks_of_rates(robot, sensors, samples)
    lasting = lasting_noise(robot, sensors, walks)
    loose = looseness(robot, samples, sensors, lasting, turning)
    history = intervals.history
    last = np.arange(intervals.t.size) == intervals.t.size - 1
    pushed = _during(samples.pushed, intervals.t)
    seen, weights = {}, {}
    torques = mean_torques(robot, samples, sensors, intervals)
    for name, sensed in sensors.by_name.items():
        if name == TORQUES:
            seen[name], weights[name] = torques[:2]
            continue
        table = sensed.values[intervals.kept]
        valid = np.isfinite(table).all(axis=1)
        if name == "accelerometer":
            # The rate of the velocity is taken over the time to the next row.
            valid &= ~last
        if name != "joints":
            valid &= ~pushed
        seen[name] = table
        still = {*samples.locked, *samples.led, *robot.passive}
        axes = _axes(robot, name, still) / sensed.std
        # Where all rows count alike, one is held in place of a table.
        weights[name] = (
            np.broadcast_to(axes, (valid.size, axes.size))
            if valid.all()
            else np.outer(valid, axes)
        )
    recorded = _core.Recorded(
        tree=core_tree(robot),
        theta_0=unseen_part(robot, sets),
        theta_of=np.ascontiguousarray(sets.base.theta_of),
        planar=robot.motion == "planar",
        substeps=substeps_of(robot, samples, unexplained),
        t=intervals.t,
        edge=intervals.edges.astype(float),
        knots=history.t,
        q=history.q,
        q_slope=history.q_slope,
        qd=history.qd,
        qdd=history.qdd,
        A_rw=np.ascontiguousarray(wheels_of(robot).A_rw.T),
        qd_rw=history.qd_rw,
        qdd_rw=history.qdd_rw,
        samples=[_without_nan(seen.get(name, _none(name))) for name in SENSORS],
        **loose._asdict(),
        **joint_laws(robot, samples.wrenches, unexplained)._asdict(),
        driven=driven_by(robot),
        over_intervals=torques.over_intervals,
    )
    followed = followed or Followed(
        without_walks(robot, walks), sets, samples, intervals
    )
    acting = Acting(followed, recorded.places, followed.allowed)
    driven = joints_driven(robot, torques.weights)
    shown = {*sensors.by_name, *thrust_seen(samples.wrenches), *driven}
    return Problem(
        recorded,
        intervals.t,
        intervals.boundaries,
        seen,
        weights,
        loose,
        lasting,
        tuple(x for x in walks if not getattr(robot.momentum_walk, AGENTS[x].density)),
        (*calibrations_of(robot, shown, free), *acting.recorded),
        acting,
    )


def without_walks(robot: Robot, walks: Collection[str]) -> Robot:
    """The robot without these walks, which act otherwise than as waves."""
    kept = {
        name: x for name, x in (robot.disturbances or {}).items() if name not in walks
    }
    densities = dict.fromkeys((AGENTS[each].density for each in walks), 0.0)
    return replace(
        robot,
        disturbances=None if robot.disturbances is None else kept,
        momentum_walk=robot.momentum_walk._replace(**densities),
    )


def _during(
    pushed: tuple[float, float] | None, t: Float[np.ndarray, " rows"]
) -> Bool[np.ndarray, " rows"]:
    """Rows while something pushes: how it does so from one to the next is unknown."""
    begin, end = pushed or (np.inf, -np.inf)
    return (t > begin) & (t < end)


def _without_nan(
    x: Float[np.ndarray, "rows axes"],
) -> Float[np.ndarray, "rows axes"]:
    """What is not copied where all is there."""
    return x if np.isfinite(x).all() else np.nan_to_num(x)


def _none(name: str) -> Float[np.ndarray, "0 axes"]:
    return np.zeros((0, 4 if name == "attitude" else 3))


def _axes(
    robot: Robot, sensor: str, still: Collection[str]
) -> Float[np.ndarray, " axes"]:
    """1 for those in which momentum is conserved, and for encoders that tell of motion.

    Those of joints that are `still` do not.
    """
    if sensor == "joints":
        return np.array([float(name not in still) for name in robot.joint_names])
    if robot.motion != "planar":
        return np.ones(3)
    turning = sensor in {"gyro", "attitude"}
    return np.array([0.0, 0.0, 1.0] if turning else [1.0, 1.0, 0.0])


def start_of(
    problem: Problem,
    samples: Samples,
    outside: Outside,
    beta: Float[np.ndarray, " beta"],
) -> Unknowns:
    """The state with the measured attitude, without biases, corrections and errors."""
    known = np.flatnonzero(np.logical_and.reduce([*map(np.isfinite, samples.x_WB)]))
    at = samples.t[known]
    wanted = np.clip(problem.boundaries, at[0], at[-1])
    # Those beside the boundaries alone: rotations take much memory.
    after = np.clip(np.searchsorted(at, wanted), 1, at.size - 1)
    beside = np.unique([after - 1, after])
    x = np.column_stack([column[known[beside]] for column in samples.x_WB])
    x_WB = Slerp(at[beside], Rotation.from_quat(x))(wanted).as_quat()
    local = np.zeros((len(x_WB), problem.recorded.local))
    state = Unknowns(
        np.ascontiguousarray(x_WB), local, np.concatenate([*outside, beta])
    )
    return state.selecting(np.array([each.place for each in problem.declared]))
