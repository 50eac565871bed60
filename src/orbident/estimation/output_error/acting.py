"""Tables of what acts from outside, for the core's `acting.hpp`.

With `F`, `tau` (about S), the pull `a` and the push `b` in inertial axes, and `r` from
S to the CM,

    dh_cm/dt = tau - r x F,    M dv_cm/dt = F + M (a + b),    M r = moments beta.

An accelerometer feels `F / M + b`.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from orbident.environment.agent import Disturbance
from orbident.environment.agents import WALKS, std_of
from orbident.environment.motion import Effect, by_step
from orbident.environment.orbital import GravityGradient
from orbident.estimation.momentum_problem import OutsideMomentum
from orbident.estimation.output_error.followed import Followed, at_nodes, integral
from orbident.estimation.unknowns import Unknown
from orbident.robot.description import MomentumWalk
from orbident.robot.may_act import MayAct

LONGEST = 2**15
"""Rows of a recording in which something may act: tables of it take 3 kB a row."""

ROWS = 15
"""A node has so many: h_cm, its rate, r_cm, v_cm and what is felt, three axes each."""


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
        self._still: tuple[tuple[int, ...], np.ndarray] | None = None

    @cached_property
    def recorded(self) -> tuple[Disturbance, ...]:
        """What is known to act, but for a gain each; its places are the first."""
        return tuple(recorded_gains(self.followed))

    def allowing(self, sizes: Mapping[str, float]) -> "Acting":
        """What acts in a world where it has other sizes, by group, SI."""
        changed = {group: MayAct(size) for group, size in sizes.items()}
        return Acting(self.followed, self.first, {**self.allowed, **changed})

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
        first = self.first + len(self.recorded)
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
        every = (*self.recorded, *(self.followed.disturbances if sizes else ()))
        motion, theta = self.followed.motion, self.followed.sets.theta(beta)
        r = by_step(motion.to_cm(theta))
        total = motion.nothing
        if tide:
            torque = by_step(GravityGradient().moment(motion, theta))
            total = total._replace(torque=torque)
        pushing = [k for k in sizes if every[k].effect.force.any()]
        for k in {*range(len(self.recorded)), *pushing}:
            size = every[k].acts + (sizes[k] if k in pushing else 0.0)
            if size:
                total = total.plus(size, every[k].effect)
        own = self._moved([total, *(every[k].effect for k in pushing)], r, beta[0])
        still = [k for k in sizes if k not in pushing]
        table = self._without_force(tuple(still))
        table[..., 0] = 0.0
        table[..., 0] = own[..., 0] + table @ np.array([0, *(sizes[k] for k in still)])
        if pushing:
            table = np.concatenate([table, own[..., 1:]], axis=2)
            order = [[*still, *pushing].index(k) for k in sizes]
            table = table[..., [0, *(1 + place for place in order)]]
        if not total.force.any():
            return table
        return np.concatenate([table, self._by_beta(total, r, beta[0])], axis=2)

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

    def forget(self) -> None:
        """Free the tables that were last asked for: of all groups 10 kB a row."""
        self._still = None

    def _without_force(
        self, which: tuple[int, ...]
    ) -> Float[np.ndarray, "nodes rows columns"]:
        """What torques and pulls of size one do: the same at all parameters.

        Before them is a column for what all do together, so that nobody copies them.
        """
        if self._still is None or self._still[0] != which:
            every = (*self.recorded, *self.followed.disturbances) if which else ()
            effects = [every[k].effect for k in which]
            nowhere = np.zeros((self.followed.t.size // 2, 3, 3))
            together = self.followed.motion.nothing
            self._still = which, self._moved([together, *effects], nowhere, 1.0)
        return self._still[1]

    def _moved(
        self, effects: Sequence[Effect], r: Float[np.ndarray, "steps 3 3"], M: float
    ) -> Float[np.ndarray, "nodes rows effects"]:
        t = self.followed.t
        table = np.zeros((t.size, ROWS, len(effects)))
        if not effects:
            return table
        rate = np.stack([each.torque for each in effects], axis=-1)
        pushing = [k for k, each in enumerate(effects) if each.accelerates]
        if pushing:
            force = np.stack([effects[k].force for k in pushing], axis=-1)
            pull = np.stack([effects[k].pull for k in pushing], axis=-1)
            rate[..., pushing] -= np.cross(r[..., None], force, axis=2)
            push = np.stack([effects[k].push for k in pushing], axis=-1)
            v = integral(t, force / M + pull + push)
            table[:, 6:9, pushing] = integral(t, by_step(v))
            table[:, 9:12, pushing] = v
            table[:, 12:15, pushing] = at_nodes(force / M + push)
        table[:, 0:3], table[:, 3:6] = integral(t, rate), at_nodes(rate)
        return table

    def _by_beta(
        self, effect: Effect, r: Float[np.ndarray, "steps 3 3"], M: float
    ) -> Float[np.ndarray, "nodes 15 beta"]:
        """The slopes by `beta`: of lever arms, and of how a force moves the mass."""
        t = self.followed.t
        by_r = by_step(self.followed.moments) / M
        by_r[..., 0] -= r / M
        rate = -np.cross(by_r, effect.force[..., None], axis=2)
        slopes = np.zeros((t.size, ROWS, by_r.shape[-1]))
        slopes[:, 0:3], slopes[:, 3:6] = integral(t, rate), at_nodes(rate)
        felt = -effect.force / M**2
        v = integral(t, felt)
        slopes[:, 6:9, 0], slopes[:, 9:12, 0] = integral(t, by_step(v)), v
        slopes[:, 12:15, 0] = at_nodes(felt)
        return slopes


def recorded_gains(followed: Followed) -> Iterator[Disturbance]:
    """The wrenches that were recorded, known up to a gain each.

    A wrench holds in base axes, and turns with these, from a row until the next.

    Args:
        followed: the motion that was measured.
    """
    for each in followed.wrenches:
        motion, steps = followed.motion, followed.t.size // 2
        force, torque, dipole = (
            np.einsum("skij,sj->ski", by_step(motion.R_WB), held[:steps])
            for held in (each.force, each.torque, each.dipole)
        )
        if dipole.any():
            torque = torque + np.cross(dipole, by_step(motion.surroundings["field"]))
        effect = motion.nothing._replace(force=force, torque=torque)
        name = f"{each.name}.gain"
        yield Disturbance(name, name, "1", effect, acts=1.0, std=each.gain)
