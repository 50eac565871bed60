"""Pulses of thrusters that excite a robot without joints: the best of random ones.

A sequence is drawn pulse by pulse: none, one or two thrusters for a while. It goes on
with a pulse after which the robot could still brake within its limits. Among sequences
that keep to the limits, the one is taken whose Cramer-Rao bound is smallest: the
geometric mean of the deviations of the base parameters, which depends on no units.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from orbident.errors import InputError
from orbident.excitation.bound import log_deviation
from orbident.excitation.conditions import BaseExtremes, Conditions, Limits
from orbident.excitation.search import Effort, MotionSearch, Progress
from orbident.excitation.table_points import TableSize
from orbident.files.json_parts import nulled
from orbident.model.kinematics import inertia
from orbident.model.rotations import rotation_angle
from orbident.robot.description import Robot
from orbident.simulation.flight import Driven, FreeFlying, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory

SHORTEST_PULSE = 0.3
"""s: three times what commands may be late, so that most of a pulse is no edge."""

LONGEST_PULSE = 0.1
"""Over the duration: there is time for ten and more."""

DRAWS = 16
"""Of a next pulse; where none leaves room to brake, the one that lacks least."""

SEEN = 9
"""Samples of a pulse: the extremes of a parabola are missed by a 64th at most."""


class Brakes(NamedTuple):
    """What one thruster can do at least against any motion."""

    push: float
    """m/s^2."""
    turn: float
    """rad/s^2."""


class PulseSequence(NamedTuple):
    """Pulses that have been drawn, and the motion that they make."""

    pulses: tuple[Pulse, ...]
    flights: tuple[FreeFlying, ...]

    def extremes(self, brakes: Brakes | None = None) -> BaseExtremes:
        """How far it goes; with brakes, until it stands again after its end."""
        w, x, r, speeds = (
            np.concatenate([getattr(each, name) for each in self.flights])
            for name in ("w", "attitude", "r_S", "qd_rw")
        )
        rate = np.linalg.norm(w, axis=1)
        turned = rotation_angle(x, x[0])
        excursion, v = float(turned.max()), self.flights[-1].v_S[-1]
        if brakes:
            excursion = max(excursion, turned[-1] + rate[-1] ** 2 / 2 / brakes.turn)
            r = np.vstack([r, r[-1] + v * np.abs(v) / 2 / brakes.push])
        width, depth = np.ptp(r, axis=0)[:2].tolist()
        return BaseExtremes(
            rate=float(rate.max()),
            excursion=excursion,
            wheel_speed=float(np.abs(speeds).max(initial=0.0)),
            # A circle about the rectangle that holds what S passes over.
            table=TableSize(width, depth, float(np.hypot(width, depth)) / 2),
            impulse=sum((x.force * (x.off - x.on) for x in self.pulses), 0.0),
        )

    def over(self, limits: Limits, brakes: Brakes | None = None) -> float:
        """The largest part by which a limit is exceeded; zero or less where none is."""
        found = self.extremes(brakes).beside(limits)
        return max(own / most for _, own, most in found) - 1


def brakes_of(robot: Robot, limits: Limits) -> Brakes:
    """The least that the best thruster does along or about any axis that shows.

    Where there is no limit of place or turn, nothing needs brakes.

    Raises:
        InputError: no thruster pushes or turns some way in which a limit needs it.
    """
    at = inertia(robot, np.zeros((1, 0)))
    fired = [each for each in robot.thrusters if each.thrust]
    force = np.array([each.direction * (each.thrust or 0.0) for each in fired])
    arms = np.array([each.position for each in fired]) - robot.feature_point
    torque = np.cross(arms - at.r_cm[0], force)
    found = []
    for limit, effect, axes, verb in zip(
        (min(limits.table), limits.excursion),
        (force / robot.mass, torque @ np.linalg.inv(at.D[0])),
        reversed(robot.conserved_axes),
        ("push", "turn"),
        strict=True,
    ):
        ways = effect[:, list(axes)]
        least = float(np.concatenate([ways, -ways], axis=1).max(axis=0).min())
        if np.isfinite(limit) and least <= 0:
            raise InputError(
                f"{robot.name}: limits: its thrusters do not {verb} it every way, and "
                "so it cannot brake; leave the limit out"
            )
        found.append(least if np.isfinite(limit) else np.inf)
    return Brakes(*found)


class FeasiblePulses(NamedTuple):
    """Pulses that keep to their limits."""

    motion: Trajectory
    value: float
    """Logarithm of the geometric mean of the least deviations; infinite where not all
    parameters are determined."""
    extremes: BaseExtremes


@dataclass(eq=False)
class PulseSearch(MotionSearch):
    """Random sequences of pulses, each as it is drawn."""

    robot: Robot
    given: Conditions
    random: np.random.Generator
    brakes: Brakes

    def search(self) -> None:
        """Draw sequences, and keep those within their limits."""
        searched = self.searched
        while self.effort.begins(searched, 1.0):
            drawn = self._sequence()
            if drawn.pulses and drawn.over(self.given.limits) <= 0:
                motion = _trajectory(self.robot, self.given, drawn.pulses)
                value = log_deviation(self.robot, motion)
                searched.random.append(FeasiblePulses(motion, value, drawn.extremes()))
                searched.starts += 1
            else:
                searched.refused += 1
            self.tell(searched.starts)

    def _sequence(self) -> PulseSequence:
        """Pulses until the end, each drawn so that the robot could still brake."""
        robot, given = self.robot, self.given
        still = _trajectory(robot, given, ())
        base = BaseState.of(given.initial, robot)
        state, t, made = standing(base, np.zeros(0)), 0.0, PulseSequence((), ())
        while t < given.duration - SHORTEST_PULSE:
            best = np.inf, made, t
            for _ in range(DRAWS):
                drawn, end = self._drawn(t)
                times = np.linspace(t, end, SEEN)
                flight = free_flying(robot, times, state, still, Driven(), pulses=drawn)
                longer = PulseSequence((*made.pulses, *drawn), (*made.flights, flight))
                paid = end / given.duration * given.limits.impulse
                over = longer.over(replace(given.limits, impulse=paid), self.brakes)
                if over < best[0]:
                    best = over, longer, end
                if over <= 0:
                    break
            _, made, t = best
            state = made.flights[-1].state(-1)
        return made

    def _drawn(self, t: float) -> tuple[tuple[Pulse, ...], float]:
        """None, one or two thrusters from now on, and until when; edges are at rows."""
        duration, rate = self.given.duration, self.robot.sensors.rows_per_second
        longest = max(LONGEST_PULSE * duration, SHORTEST_PULSE)
        length = SHORTEST_PULSE * (longest / SHORTEST_PULSE) ** self.random.uniform()
        end = max(round((t + length) * rate), round(t * rate) + 1) / rate
        end = min(end, duration)
        fired = [each for each in self.robot.thrusters if each.thrust]
        chosen = self.random.permutation(len(fired))[: self.random.integers(0, 3)]
        pulses = (Pulse(fired[k].name, t, end, fired[k].thrust or 0.0) for k in chosen)
        return tuple(pulses), end


def design_pulses(
    robot: Robot,
    given: Conditions,
    effort: Effort,
    seed: int,
    progress: Callable[[Progress], object],
) -> Trajectory:
    """The best of random sequences of pulses that keep to the limits.

    The robot has no joints and a nominal inertia. An interrupt ends the search, which
    then returns the best sequence so far; `progress` is called after each sequence.

    Raises:
        InputError: no thruster has a thrust, no sensor a noise, or no sequence keeps to
            the limits.
    """
    if not any(each.thrust for each in robot.thrusters):
        raise InputError(
            f"{robot.name}: thrusters: found none with a thrust; add 'thrust: 0.45' (N)"
        )
    random, brakes = np.random.default_rng(seed), brakes_of(robot, given.limits)
    searched = PulseSearch(effort, progress, robot, given, random, brakes).run()
    if not searched.random:
        raise InputError(
            f"{robot.name}: limits: none of {searched.refused} random sequences of "
            "pulses keeps to them; raise a limit, or give less time"
        )
    values = np.exp([each.value for each in searched.random])
    best = int(np.argmin(values))
    extremes = searched.random[best].extremes
    made = {
        "objective": "d",
        "value": nulled(values[best]),
        "searched_value": nulled(values[best]),
        "starts": searched.starts,
        "beyond_limits": searched.refused,
        "interrupted": searched.interrupted,
        "median_random_start": nulled(float(np.median(values))),
        "seed": seed,
        "extremes": {
            "rate": extremes.rate,
            "excursion": extremes.excursion,
            "table": list(extremes.table),
            "impulse": extremes.impulse,
        },
    }
    return replace(searched.random[best].motion, design=made)


def _trajectory(
    robot: Robot, given: Conditions, pulses: tuple[Pulse, ...]
) -> Trajectory:
    """A file's, pulses of one thruster that follow each other joined."""
    firing: dict[str, list[dict[str, float]]] = {}
    for name, on, off, force in pulses:
        before = firing.setdefault(name, [])
        if before and before[-1]["off"] == on:
            before[-1]["off"] = off
        else:
            before.append({"on": on, "off": off, "force": force})
    thrusters = {
        each.name: {"pulses": firing[each.name]}
        for each in robot.thrusters
        if each.name in firing
    }
    environment = Environment.model_validate({"thrusters": thrusters})
    acting = environment if thrusters else None
    start, none = given.initial, np.zeros((0, 0))
    return Trajectory(given.duration, (), none, none, initial=start, environment=acting)
