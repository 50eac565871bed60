"""Tables of what acts from outside, for the core's `acting.hpp`.

With `F`, `tau` (about S), the pull `a` and the push `b` in inertial axes, and `r` from
S to the CM,

    dh_cm/dt = tau - r x F,    M dv_cm/dt = F + M (a + b),    M r = moments beta.

An accelerometer feels `F / M + b`.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from orbident.environment.agent import Disturbance
from orbident.environment.agents import NOISE, PUSH, WALKS, disturbances, std_of
from orbident.environment.motion import (
    Effect,
    PointMotion,
    RobotMotion,
    by_step,
    integral,
    straight,
)
from orbident.environment.orbital import GravityGradient
from orbident.environment.worlds import scale_of, what_may_act
from orbident.errors import InputError
from orbident.estimation.output_error.integrated_effects import (
    ROWS,
    moved_by,
    moved_by_beta,
)
from orbident.estimation.output_error.recorded_thrust import (
    SHARED,
    EvenSteps,
    RecordedThrust,
    ThrustErrors,
)
from orbident.estimation.output_error.shooting import Intervals
from orbident.estimation.solution import NOTHING_SELECTED, Unknowns
from orbident.estimation.unknowns import Unknown
from orbident.model.kinematics import first_moments
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.rate_noise import waves_of_noise
from orbident.preprocessing.samples import OutsideMomentum, Samples
from orbident.robot.description import MomentumWalk, Robot
from orbident.robot.may_act import MayAct


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
    predicted: Columns = ()
    """What a fit predicts of the gyro at the rows; NaN where it showed nothing."""
    still: dict[object, np.ndarray] = field(default_factory=dict, init=False)
    """The table of torques and pulls of size one that was last asked for."""

    @cached_property
    def t(self) -> Float[np.ndarray, " nodes"]:
        """Times of the nodes, s."""
        t = self.intervals.t
        nodes = np.empty(2 * t.size - 1)
        nodes[::2], nodes[1::2] = t, (t[:-1] + t[1:]) / 2
        return nodes

    @cached_property
    def thrust(self) -> RecordedThrust:
        """What is known to act on the base from a row until the next."""
        return RecordedThrust(self.motion, self.samples.t, self.samples.wrenches)

    @cached_property
    def motion(self) -> RobotMotion:
        """All of it; in inertial axes the surroundings change slowly."""
        samples, history, t = self.samples, self.intervals.history, self.t
        w = self._between(samples.t, samples.w)
        x = np.column_stack(samples.x_WB)
        known = np.isfinite(x).all(axis=1)
        at, x_WB = samples.t[known], Rotation.from_quat(x[known])
        S = None
        if samples.tracked:
            v_S = self._between(samples.t, samples.v_S)
            S = PointMotion(integral(t, by_step(v_S)), v_S)
        return RobotMotion(
            self.robot,
            t,
            history.at(history.q, history.q_slope, t),
            history.at(history.qd, history.qdd, t),
            Slerp(at, x_WB)(np.clip(t, at[0], at[-1])).as_matrix(),
            w,
            S,
            {
                name: straight(t, at, x_WB.apply(seen[known]))
                for name, seen in samples.surroundings.items()
            },
            samples.pushed,
            self.allowed,
            tuple(each.density for each in samples.speeds),
            waves_of_noise(t[::2].size),
            self._between(self.intervals.t, self.predicted) if self.predicted else None,
        )

    @cached_property
    def disturbances(self) -> tuple[Disturbance, ...]:
        """All that may act beside what was recorded, and shows."""
        return tuple(disturbances(self.motion))

    @cached_property
    def allowed(self) -> dict[str, MayAct]:
        """What may act, by how large the motion is where all was measured."""
        samples, history = self.samples, self.intervals.history
        w = np.column_stack(samples.w)
        v_S = np.column_stack(samples.v_S) if samples.tracked else None
        scale = scale_of(
            self.robot,
            self.intervals.t,
            np.reshape(history.qd_rw, (len(self.robot.wheels), history.t.size)).T,
            w[np.isfinite(w).all(axis=1)],
            v_S if v_S is None else v_S[np.isfinite(v_S).all(axis=1)],
        )
        allowed = what_may_act(self.robot, scale)
        allowed[NOISE] = MayAct(float(any(map(any, samples.speeds))))
        return allowed | {PUSH: MayAct(np.inf)} if samples.pushed else allowed

    def _between(
        self, t: Float[np.ndarray, " n"], columns: Columns
    ) -> Float[np.ndarray, "nodes axes"]:
        x = np.column_stack(columns)
        known = np.isfinite(x).all(axis=1)
        if known.sum() < 2:
            raise InputError(
                f"{self.samples.source}: joints, wheels and base are known together "
                f"at {known.sum()} times, and 2 are needed at least; check the clocks, "
                "or record longer"
            )
        return np.asarray(CubicSpline(t[known], x[known])(self.t))

    def place(
        self, r: Float[np.ndarray, "steps 3 3"]
    ) -> Float[np.ndarray, "steps 3 3"]:
        """Where the CM is beside where it was at first, of that from S; inertial, m."""
        at = r if self.motion.S is None else by_step(self.motion.S.r) + r
        return at - at[0, 0]

    @cached_property
    def moments(self) -> Float[np.ndarray, "nodes 3 beta"]:
        """The first moment about S by each `beta`; inertial axes, kg m by its unit."""
        by_theta = first_moments(self.motion.poses)
        return self.motion.R_WB @ (by_theta @ self.sets.base.theta_of)


LONGEST = 2**15
"""Rows of a recording in which something may act: tables of it take 3 kB a row."""


class Acting:
    """What may act along a recording; it is worked out when it is first asked for."""

    def __init__(
        self, followed: Followed, first: int, allowed: Mapping[str, MayAct]
    ) -> None:
        """Keep what tables are made of.

        Args:
            followed: the motion that was measured.
            first: the place of the first disturbance among the core's calibrations.
            allowed: what may act, by group.
        """
        self.followed, self.first, self.allowed = followed, first, allowed

    @property
    def recorded(self) -> tuple[Unknown, ...]:
        """Gains of what is known to act, behind the places of what thrusters share."""
        first = float(self.first + SHARED)
        return tuple(
            Unknown(name, name, "1", each.gain, first + k)
            for k, each in enumerate(self.followed.samples.wrenches)
            for name in [f"{each.name}.gain"]
        )

    def allowing(self, sizes: Mapping[str, float]) -> "Acting":
        """What acts in a world where it has other sizes, by group, SI."""
        changed = {group: MayAct(size) for group, size in sizes.items()}
        return Acting(self.followed, self.first, {**self.allowed, **changed})

    def following(self, predicted: Columns) -> "Acting":
        """What may act along a motion with the rates that a fit predicts.

        Args:
            predicted: what the gyro would show at the rows, rad/s; NaN without one.
        """
        followed = replace(self.followed, predicted=predicted)
        return Acting(followed, self.first, self.allowed)

    def walking(self, found: Mapping[str, float]) -> "Acting":
        """The same with these densities of walks, by their groups."""
        robot = self.followed.robot
        walk = dict(zip(WALKS, robot.momentum_walk, strict=True)) | dict(found)
        walking = replace(
            robot, momentum_walk=MomentumWalk(*(walk[name] for name in WALKS))
        )
        return Acting(replace(self.followed, robot=walking), self.first, self.allowed)

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Sizes of all that may act beside recorded thrust, in the core's order."""
        first = self.first + SHARED + len(self.recorded)
        return tuple(
            Unknown(
                each.name,
                each.group,
                each.unit,
                std_of(each, self.allowed),
                float(first + k),
                each.positive,
            )
            for k, each in enumerate(self.followed.disturbances)
        )

    def is_free(self, group: str) -> bool:
        """Whether it may be anything."""
        return group in self.allowed and math.isinf(self.allowed[group].size)

    @property
    def expected(self) -> tuple[Unknown, ...]:
        """Those that have a size; what they are is worked out only if any has."""
        few = self.followed.intervals.t.size <= LONGEST
        if not few or not any(each.size for each in self.allowed.values()):
            return ()
        return tuple(each for each in self.unknowns if each.std)

    def table(
        self,
        beta: Float[np.ndarray, " beta"],
        gains: Float[np.ndarray, " selected"],
        selected: Float[np.ndarray, " selected"],
    ) -> Float[np.ndarray, "nodes rows columns"]:
        """What acts at these parameters: its value, and its slopes by gains and `beta`.

        Without a force nothing depends on `beta`: these columns are left out.

        Args:
            beta: base parameters.
            gains: of the selected calibrations and disturbances.
            selected: their places; those before the first are not disturbances.
        """
        sizes = {
            int(place) - self.first: float(gain)
            for place, gain in zip(selected, gains, strict=True)
            if place >= self.first
        }
        tide = "nadir" in self.followed.samples.surroundings
        if not (sizes or self.recorded or tide):
            return np.zeros((0, ROWS, 1))
        motion, theta = self.followed.motion, self.followed.sets.theta(beta)
        r = by_step(motion.to_cm(theta))
        every, total = self._thrust(sizes) if self.recorded else ({}, motion.nothing)
        if tide:
            torque = by_step(GravityGradient().moment(motion, theta))
            total = total._replace(torque=total.torque + torque)
        acting = self.followed.disturbances if sizes.keys() - every.keys() else ()
        uneven = np.zeros((3, 3))
        pushing = [k for k in sizes if k in every]
        for k, each in enumerate(acting, SHARED + len(self.recorded)):
            every[k] = each.effect
            if k in sizes and each.by_place is not None:
                pull = self.followed.place(r) @ each.by_place
                every[k] = motion.nothing._replace(pull=pull)
                uneven += sizes[k] * each.by_place
            if k in sizes and (each.by_place is not None or each.effect.force.any()):
                pushing.append(k)
                total = total.plus(sizes[k], every[k])
        still = {k: every[k] for k in sizes if k not in pushing}
        table = self._without_force(still, sizes)
        table[..., 0] = 0.0
        table[..., 0] = table @ np.array([0, *(sizes[k] * (k in still) for k in sizes)])
        if pushing or self.recorded or tide:
            effects = [total, *(every[k] for k in pushing)]
            own = moved_by(self.followed.t, effects, r, float(beta[0]))
            table[..., 0] += own[..., 0]
            table[..., [1 + [*sizes].index(k) for k in pushing]] = own[..., 1:]
        if not (total.force.any() or uneven.any()):
            return table
        moments = by_step(self.followed.moments)
        by_beta = moved_by_beta(
            self.followed.t, total, uneven, r, moments, float(beta[0])
        )
        return np.concatenate([table, by_beta], axis=2)

    def _thrust(self, sizes: Mapping[int, float]) -> tuple[dict[int, Effect], Effect]:
        """What is recorded to act: by each of its errors, and all of it together."""
        thrust, total = self.followed.thrust, self.followed.motion.nothing
        errors = ThrustErrors(*(sizes.get(k, 0.0) for k in range(SHARED)))
        gains = [sizes.get(SHARED + k, 0.0) for k in range(len(self.recorded))]
        shared = sizes.keys() & {*range(SHARED)}
        by = thrust.by(errors, np.array(gains)) if shared else ()
        every = dict(enumerate(by))
        for k, effect in enumerate(thrust.at(errors)):
            every[SHARED + k] = effect
            total = total.plus(1 + gains[k], effect)
        return every, total

    def given(
        self,
        beta: Float[np.ndarray, " beta"],
        gains: Float[np.ndarray, " selected"],
        selected: Float[np.ndarray, " selected"],
    ) -> OutsideMomentum | None:
        """What has been given at these parameters; None where nothing acts.

        Args:
            beta: base parameters.
            gains: of the selected calibrations and disturbances,
            selected: and their places.
        """
        table = self.table(beta, gains, selected)
        if not table.size:
            return None
        return OutsideMomentum(self.followed.t, table[:, 0:3, 0], table[:, 9:12, 0])

    @cached_property
    def momenta(self) -> Float[np.ndarray, " some"]:
        """Places of what gives momentum; what accelerates does so to any mass."""
        effects = [each.effect for each in self.followed.disturbances]
        own = [not (each.pull.any() or each.push.any()) for each in effects]
        return np.array([x.place for x in self.unknowns])[np.array(own, dtype=bool)]

    def steps_from(self, at: Unknowns) -> EvenSteps:
        """Steps from a state, along which what it shows of what acts is kept."""
        first = self.first + SHARED + len(self.recorded)
        acts = self.momenta if (at.selected >= first).any() else NOTHING_SELECTED
        return EvenSteps(at, self.first, self.followed.samples.wrenches, acts)

    def forget(self) -> None:
        """Free the tables that were last asked for: of all groups 10 kB a row."""
        self.followed.still.clear()

    def _without_force(
        self, effects: Mapping[int, Effect], places: Collection[int]
    ) -> Float[np.ndarray, "nodes rows columns"]:
        """What torques and pulls of size one do: the same at all parameters.

        Before them is a column for what all do together, and in their places are
        columns for what else acts, so that nobody copies them.
        """
        still, nothing = self.followed.still, self.followed.motion.nothing
        key = (*effects, None, *places)
        if key not in still:
            still.clear()
            own = [effects.get(k, nothing) for k in places]
            nowhere = np.zeros((self.followed.t.size // 2, 3, 3))
            still[key] = moved_by(self.followed.t, [nothing, *own], nowhere, 1.0)
        return still[key]
