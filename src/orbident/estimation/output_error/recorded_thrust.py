"""Recorded wrenches on the base, as they act: known but for gains, and for timing.

A recorded level `u` holds from a row until the next. Of a thruster `k`, with `n` of
them open at once,

    F_k(t) = F_k,recorded (1 + g_k) (1 + s) (1 - c (n - 1)) u_k

where each switching acts a time `l` late, and each switching-off `d` later still: gains
`g` and `s`, coupling `c`, clock `l` and pulse `d`. The level before the first row is
taken to be that of the first row.

Switches then fall between rows. Over a step `h` such a level `f` stands as the straight
line that gives the same to velocity and place,

    p = 1/h int f dt,   j = 1/h^2 int int f dt dt:   6 j - 2 p,   p,   4 p - 6 j

at its start, middle and end.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from orbident.environment.motion import Effect, RobotMotion, by_step
from orbident.estimation.solution import OUTSIDE, Unknowns
from orbident.files.bounds import TOGETHER
from orbident.preprocessing.wrenches import RecordedWrench

Levels = Float[np.ndarray, "_ thrusters"]
Lines = Float[np.ndarray, "steps 3 thrusters"]


class ThrustErrors(NamedTuple):
    """Errors that all thrusters share, in the order of `Tolerances`."""

    clock: float = 0.0
    """s."""
    pulse: float = 0.0
    """s."""
    coupling: float = 0.0
    scale: float = 0.0


SHARED = len(ThrustErrors._fields)
SCALE = ThrustErrors._fields.index("scale")

TINY = 1e-9
"""Part of its thrust that no thruster is open by."""


class RecordedThrust:
    """What recorded wrenches do, at any of their errors."""

    def __init__(
        self,
        motion: RobotMotion,
        t: Float[np.ndarray, " samples"],
        wrenches: Sequence[RecordedWrench],
    ) -> None:
        """Keep what effects are made of.

        Args:
            motion: the motion that was measured, at rows and half-way between.
            t: times of the wrenches, s.
            wrenches: from each of these times until the next.
        """
        self.motion, self.t, self.wrenches = motion, t, wrenches
        self.rows = motion.t[::2]
        self.which = [k for k, each in enumerate(wrenches) if each.valve]
        thrusters = [wrenches[k] for k in self.which]
        most = [int(np.abs(each.force).sum(axis=1).argmax()) for each in thrusters]
        both = list(zip(thrusters, most, strict=True))
        self.forces = np.reshape([each.force[k] for each, k in both], (-1, 3))
        self.torques = np.reshape([each.torque[k] for each, k in both], (-1, 3))
        along = [each.force @ each.force[k] for each, k in both]
        levels = np.reshape(along, (-1, t.size)).T
        self.u: Levels = levels / np.sum(self.forces**2, axis=1)

    def at(self, errors: ThrustErrors) -> Iterator[Effect]:
        """What each wrench does, but for its gain."""
        switched = self._switched(errors)
        lines = (1 + errors.scale) * self._lines(switched, switched.levels(errors))
        last = np.searchsorted(self.t, self.rows[:-1] + TOGETHER, side="right") - 1
        before = np.maximum(last, 0)
        for k, each in enumerate(self.wrenches):
            if each.valve:
                one = self.which.index(k)
                line = lines[:, :, one, None]
                yield self._effect(line * self.forces[one], line * self.torques[one])
                continue
            held = (each.force, each.torque, each.dipole)
            force, torque, dipole = (x[before, None] for x in held)
            effect = self._effect(force, torque)
            if dipole.any():
                field = by_step(self.motion.surroundings["field"])
                m = self._effect(dipole, dipole).torque
                effect = effect._replace(torque=effect.torque + np.cross(m, field))
            yield effect

    def by(
        self, errors: ThrustErrors, gains: Float[np.ndarray, " wrenches"]
    ) -> Iterator[Effect]:
        """How what all thrusters do changes with each of the errors that they share."""
        times, scale = 1 + gains[self.which, None], 1 + errors.scale
        switched = self._switched(errors)
        levels = switched.levels(errors)
        jumps = np.diff(levels, axis=0, prepend=levels[:1])
        later, falls = (
            self._later(switched, np.cumsum(np.where(which, jumps, 0.0), axis=0))
            for which in (True, switched.falls[:, None])
        )
        lost = self._lines(switched, -switched.open * switched.others)
        plain = self._lines(switched, levels)
        for slopes in (scale * later, scale * falls, scale * lost, plain):
            yield self._effect(
                slopes @ (times * self.forces), slopes @ (times * self.torques)
            )

    def _effect(
        self,
        force: Float[np.ndarray, "steps _ 3"],
        torque: Float[np.ndarray, "steps _ 3"],
    ) -> Effect:
        """The effect of a force and a torque in base axes, which turn with the base."""
        R_WB = by_step(self.motion.R_WB)
        turned = (
            np.einsum("skij,skj->ski", R_WB, x + np.zeros(3)) for x in (force, torque)
        )
        force, torque = turned
        return self.motion.nothing._replace(force=force, torque=torque)

    def _lines(self, switched: "_Switched", levels: Levels) -> Lines:
        """The lines of levels that hold between switches."""
        _, once, twice = _integrals(switched.t, levels, self.rows)
        return _lines(self.rows, once, twice)

    def _later(self, switched: "_Switched", jumped: Levels) -> Lines:
        """How lines change, by a second, if what has jumped so far does so later."""
        at, once, _ = _integrals(switched.t, jumped, self.rows)
        return -_lines(self.rows, at, once)

    def _switched(self, errors: ThrustErrors) -> "_Switched":
        """All switches in the order in which they act."""
        change = np.diff(self.u, axis=0, prepend=self.u[:1])
        t = np.concatenate([self.t, self.t + errors.pulse]) + errors.clock
        falls = np.repeat([False, True], self.t.size)
        change = np.concatenate([np.maximum(change, 0), np.minimum(change, 0)])
        order = np.argsort(t, kind="stable")
        opened = self.u[:1] + np.cumsum(change[order], axis=0)
        return _Switched(t[order], opened, falls[order])


@dataclass(frozen=True)
class EvenSteps:
    """Steps from a state that change ratios to the mass along lines.

    Of unknown mass and thrust the motion shows the ratio alone, which a long step must
    not change: `t = (1 + s)(1 + g_k)` moves as inertias do (`Unknowns.moved`), and so
    does what gives momentum.
    """

    at: Unknowns
    first: int
    """The place of the clock among what is selected."""
    wrenches: Sequence[RecordedWrench]
    """What was recorded to act."""
    momenta: Float[np.ndarray, " some"]
    """Places of what gives momentum beside it."""

    @cached_property
    def acts(self) -> Int[np.ndarray, " some"]:
        """Where these are among the common unknowns."""
        own = self.at.common.size - self.at.selected.size
        return own + np.flatnonzero(np.isin(self.at.selected, self.momenta))

    @cached_property
    def thrust(self) -> tuple[int, list[int]] | None:
        """Where the scale of thrust and gains of valves are; None if it is known."""
        own = self.at.common.size - self.at.selected.size
        place = {int(x) - self.first: own + k for k, x in enumerate(self.at.selected)}
        if SCALE not in place:
            return None
        valves = [k for k, each in enumerate(self.wrenches, SHARED) if each.valve]
        return place[SCALE], [place[k] for k in valves]

    def changed(self, g: Float[np.ndarray, " common"]) -> Float[np.ndarray, " common"]:
        """A step that is to first order as it is."""
        at, x = self.at, self.at.common[self.acts]
        moved, more = g.copy(), g[OUTSIDE] / at.beta[0]
        moved[self.acts] = at.grown(g) * (x * (1 - more) + g[self.acts]) - x
        if self.thrust is None:
            return moved
        scale, valves = self.thrust
        s, gains = 1 + at.common[scale], 1 + at.common[valves]
        change = s * g[valves] + gains * g[scale]
        t = at.grown(g) * (s * gains * (1 - more) + change)
        moved[valves] = t / (s + g[scale]) - gains
        return moved

    def bends(
        self, slope: Float[np.ndarray, " common"]
    ) -> Float[np.ndarray, "common common"]:
        """Second derivatives along them of a cost with this slope by the unknowns.

        To second order a step adds `e dx` to a numerator `x`, with `e = dM / M`, and to
        a gain `e (dg_k + (1 + g_k) f) - f dg_k`, with `f = ds / (1 + s)`.
        """
        at, out = self.at, np.zeros((slope.size, slope.size))
        even = [*at.ratios, *self.acts]
        out[OUTSIDE, even] = slope[even] / at.beta[0]
        if self.thrust is not None:
            scale, valves = self.thrust
            s, gains = 1 + at.common[scale], 1 + at.common[valves]
            out[OUTSIDE, valves] = slope[valves] / at.beta[0]
            out[OUTSIDE, scale] = slope[valves] @ gains / (s * at.beta[0])
            out[scale, valves] = -slope[valves] / s
        return out + out.T


class _Switched(NamedTuple):
    """What holds from each switch until the next; many of them change nothing."""

    t: Float[np.ndarray, " switches"]
    open: Levels
    falls: Bool[np.ndarray, " switches"]

    @property
    def others(self) -> Float[np.ndarray, "switches 1"]:
        """How many are open beside one that is."""
        # A sum of parts that rise and fall again is zero but for rounding.
        count = (self.open > TINY).sum(axis=1, keepdims=True)
        return np.maximum(count - 1.0, 0.0)

    def levels(self, errors: ThrustErrors) -> Levels:
        """What thrusters give that share a tank."""
        return self.open * (1 - errors.coupling * self.others)


def _lines(t: Float[np.ndarray, " rows"], once: Levels, twice: Levels) -> Lines:
    """From the integrals of a level, and their integrals, at rows."""
    h = np.diff(t)[:, None]
    p = np.diff(once, axis=0) / h
    j = (np.diff(twice, axis=0) / h - once[:-1]) / h
    return np.stack([6 * j - 2 * p, p, 4 * p - 6 * j], axis=1)


def _integrals(
    t: Float[np.ndarray, " switches"], level: Levels, at: Float[np.ndarray, " rows"]
) -> tuple[Levels, Levels, Levels]:
    """What is held from a switch until the next, and its integrals from the first on.

    At a switch it is half-way between before and after.
    """
    h = np.diff(t)[:, None]
    once = np.concatenate([np.zeros_like(level[:1]), np.cumsum(h * level[:-1], axis=0)])
    gained = h * once[:-1] + h**2 / 2 * level[:-1]
    twice = np.concatenate([np.zeros_like(level[:1]), np.cumsum(gained, axis=0)])
    before, after = (
        np.maximum(np.searchsorted(t, at, side=side) - 1, 0)
        for side in ("left", "right")
    )
    s = (at - t[after])[:, None]
    return (
        (level[before] + level[after]) / 2,
        once[after] + s * level[after],
        twice[after] + s * once[after] + s**2 / 2 * level[after],
    )
