"""All that acts on a robot, thrusters too, as wrenches along the motion it makes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicHermiteSpline

from orbident.environment.agent import World
from orbident.environment.agents import AGENTS, loads_of
from orbident.environment.air_table import Pull
from orbident.environment.motion import (
    PointMotion,
    RobotMotion,
    Vectors,
    at_rest,
    by_step,
    straight,
)
from orbident.errors import InputError
from orbident.files.names import listed, suggestion
from orbident.model.rotations import (
    quaternion_matrix,
    quaternion_rate,
    rotate,
    rotate_back,
    rotation_angle,
)
from orbident.orbits.orbit import Arc
from orbident.robot.description import Robot
from orbident.simulation.flight import FlightStates, WrenchPoint
from orbident.simulation.sensor import markov, stream
from orbident.trajectories.environment import Environment, Firing

MOST_ROUNDS = 60
"""Flights until what acts is that of the motion; a whole orbit takes some 25."""

COARSE = 2**15
"""Steps of a flight that may be too long for the joints' control."""

Wrenches = Callable[[Float[np.ndarray, "steps 3"]], Float[np.ndarray, "steps 3 w 6"]]


class Path(NamedTuple):
    """A flight between its steps: cubics through places and rates at their starts."""

    robot: Robot
    spline: CubicHermiteSpline

    @classmethod
    def through(
        cls, robot: Robot, t: Float[np.ndarray, " steps"], seen: FlightStates
    ) -> "Path":
        """The path of what was seen at the starts `t` (s) of steps."""
        joints = len(robot.joints)
        w, qd = seen.v[:, 3:6], seen.v[:, 6 : 6 + joints]
        w_dot, qdd = seen.vd[:, 3:6], seen.vd[:, 6 : 6 + joints]
        a_S = rotate(quaternion_matrix(seen.x_WB), seen.f_S)
        x_dot = quaternion_rate(seen.x_WB, w)
        x = np.hstack([seen.q, seen.x_WB, seen.r_S, qd, w, seen.v_S])
        slope = np.hstack([qd, x_dot, seen.v_S, qdd, w_dot, a_S])
        return cls(robot, CubicHermiteSpline(t, x, slope))

    def at(self, nodes: Float[np.ndarray, "steps 3"]) -> RobotMotion:
        """The robot at start, middle and end of steps that follow each other, s."""
        t = np.append(nodes[:, :2], nodes[-1, 2])
        q, x_WB, r_S, qd, w, v_S = self._parts(t)
        S = PointMotion(r_S, v_S)
        return RobotMotion(self.robot, t, q, qd, quaternion_matrix(x_WB), w, S)

    def apart(self, other: "Path") -> float:
        """The largest distance of places and attitudes at the steps' starts, m, rad."""
        a, b = (path._parts(self.spline.x)[:3] for path in (self, other))
        return max(
            np.abs(a[2] - b[2]).max(),
            np.abs(a[0] - b[0]).max(initial=0.0),
            rotation_angle(a[1], b[1]).max(),
        )

    def _parts(self, t: Float[np.ndarray, " n"]) -> list[np.ndarray]:
        joints = len(self.robot.joints)
        ends = np.cumsum([joints, 4, 3, joints, 3])
        parts = np.split(self.spline(t), ends, axis=1)
        parts[1] /= np.linalg.norm(parts[1], axis=1, keepdims=True)
        return parts


@dataclass(frozen=True)
class ExternalForces:
    """What acts on one flight."""

    robot: Robot
    world: World
    points: tuple[WrenchPoint, ...]

    @property
    def edges(self) -> list[float]:
        """When bursts begin and end, s."""
        bursts = self.world.environment.bursts
        return [edge for b in bursts for edge in (b.start, b.start + b.duration)]

    def wrenches(self, path: Path | None) -> Wrenches:
        """Force and moment at the points, base axes, at any nodes; without a path 0."""

        def at(nodes: Float[np.ndarray, "steps 3"]) -> Float[np.ndarray, "..."]:
            net = np.zeros((*nodes.shape, len(self.points), 6))
            if path is not None:
                motion = path.at(nodes)
                R_WB = by_step(motion.R_WB)
                for k, load in enumerate(loads_of(self.world, motion)):
                    net[:, :, k, :3] = rotate_back(R_WB, load.force)
                    net[:, :, k, 3:] = rotate_back(R_WB, load.moment)
            return net

        return at

    def settled(
        self,
        fly: Callable[[Wrenches], FlightStates],
        t: Float[np.ndarray, " steps"],
        path: Path | None,
        tolerance: float,
    ) -> tuple[FlightStates, Path | None]:
        """Fly until what acts is that of the motion which it makes.

        What acts changes motions little, so that each flight is far nearer than the one
        before (Picard's iteration). The steps start at `t`, s. Without a path to begin
        with, nothing acts on the first flight. The tolerance is of attitude, joints and
        position, rad or m.

        Returns:
            What was seen, and the path of it. Where it does not settle, the CM is not a
            number: steps that are too long for stiff joints make the motion unstable.

        Raises:
            InputError: it does not settle although steps are short.
        """
        if not self.points:
            return fly(self.wrenches(None)), None
        seen = fly(self.wrenches(path))
        for _ in range(MOST_ROUNDS):
            # A motion that blows up is not a number, or far beyond all numbers.
            with np.errstate(all="ignore"):
                if not np.isfinite(np.hstack([seen.v, seen.vd, seen.r_S])).all():
                    break
                found = Path.through(self.robot, t, seen)
                if path is not None and found.apart(path) <= tolerance:
                    return seen, found
                path, seen = found, fly(self.wrenches(found))
        if t.size <= COARSE:
            return seen._replace(r_cm=np.full_like(seen.r_cm, np.nan)), None
        raise InputError(
            f"{self.robot.name}: what acts from outside moves the robot so much that "
            "no motion is found; make it weaker, or fly a shorter time"
        )

    def pull_at_S(self, r_S: Vectors) -> Vectors:
        """The pull that an accelerometer at S does not feel, inertial axes, m/s^2."""
        pulls = (agent for agent in AGENTS.values() if isinstance(agent, Pull))
        each = (agent.at(self.world.environment, r_S) for agent in pulls)
        return sum(each, np.zeros_like(r_S))


def outside_of(
    robot: Robot, environment: Environment, t: Float[np.ndarray, " rows"], seed: int
) -> ExternalForces:
    """All that acts on a flight.

    Slow processes are drawn by the seed, at the rows `t` of the flight, s.

    Raises:
        InputError: this robot cannot be acted on like that.
    """
    check_environment(robot, environment)
    drawn = {}
    for name in ("slow_torque", "slow_force"):
        slow = getattr(environment, name)
        if slow is not None:
            random = stream(seed, f"environment.{name}")
            T = np.full(3, slow.correlation_time)
            x = markov(random, t, np.full(3, slow.std), T)
            drawn[name] = partial(straight, at=t, x=x)
    world = World(environment, arc_of(robot, environment, t), drawn)
    loads = loads_of(world, at_rest(robot, np.zeros(3)))
    points = (WrenchPoint(load.body, load.point) for load in loads)
    return ExternalForces(robot, world, tuple(points))


def check_environment(robot: Robot, environment: Environment) -> None:
    """Refuse what cannot act on this robot.

    Raises:
        InputError: it floats in space and not on a table or the other way round, it has
            no such body or thruster, or a body with film drag has no pads.
    """
    planar = robot.motion == "planar"
    wrong = environment.in_space if planar else environment.on_table
    if wrong:
        where, other = ("on a table", "in space")[:: 1 if planar else -1]
        raise InputError(
            f"environment: {listed(wrong)}: {robot.name} floats {where}, and this acts "
            f"{other}; remove it"
        )
    thrusters = [thruster.name for thruster in robot.thrusters]
    for key, kind, named, known in (
        ("film_drag", "body", environment.film_drag, robot.bodies),
        ("thrusters", "thruster", environment.thrusters, thrusters),
    ):
        for name in named:
            if name not in known:
                raise InputError(
                    f"environment: {key}: no {kind} '{name}'; "
                    + suggestion(name, known, {"body": "bodies"}.get(kind, "thrusters"))
                )
    for body in environment.film_drag:
        if body not in robot.pads:
            raise InputError(
                f"environment: film_drag: body '{body}' has no pads; say where "
                "they are under 'pads:' in the robot file"
            )


def arc_of(
    robot: Robot, environment: Environment, t: Float[np.ndarray, " rows"]
) -> Arc | None:
    """The orbit during a flight: the environment's, or else the robot's; or none.

    The rows of the flight are at `t`, s after the epoch.

    Raises:
        InputError: the orbit is not known then, or what is given needs one.
    """
    orbit = environment.orbit.in_si() if environment.orbit else robot.orbit
    if orbit is not None:
        return orbit.arc(float(t[0]), float(t[-1]))
    if environment.in_orbit:
        raise InputError(
            f"environment: {environment.in_orbit[0]} acts in an orbit, and none is "
            "given; add orbit: with altitude and inclination"
        )
    return None


class Pulse(NamedTuple):
    """One thruster, on for a while at a constant force."""

    thruster: str
    on: float
    """s."""
    off: float
    """s."""
    force: float
    """N."""


def check_pulses(
    robot: Robot, pulses: Sequence[Pulse], start: float, end: float
) -> None:
    """Refuse a schedule that no thruster can fly.

    Raises:
        InputError: a thruster is unknown, a pulse is empty or outside of the run, or
            two pulses of one thruster overlap.
    """
    names = [thruster.name for thruster in robot.thrusters]
    for pulse in pulses:
        where = f"{robot.name}: thruster '{pulse.thruster}'"
        if pulse.thruster not in names:
            raise InputError(
                f"{robot.name}: no thruster '{pulse.thruster}'; "
                + suggestion(pulse.thruster, names, "thrusters")
            )
        if not start <= pulse.on < pulse.off <= end:
            raise InputError(
                f"{where}: pulse from {pulse.on:g} to {pulse.off:g} s; it must end "
                f"after it begins, within the run from {start:g} to {end:g} s"
            )
    for first, second in pairwise(sorted(pulses)):
        if first.thruster == second.thruster and second.on < first.off:
            raise InputError(
                f"{robot.name}: thruster '{first.thruster}': the pulses at "
                f"{first.on:g} s and {second.on:g} s overlap; join them"
            )


def thrust(
    robot: Robot, pulses: Sequence[Pulse], t: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 6"]:
    """Net force on the base and its moment about S, base axes, N and N m.

    Each pulse, checked before, is on from `on` until just before `off`, s.
    """
    net = np.zeros((t.size, 6))
    by_name = {thruster.name: thruster for thruster in robot.thrusters}
    for name, on, off, force in pulses:
        thruster = by_name[name]
        arm = thruster.position - robot.feature_point
        unit = np.append(thruster.direction, np.cross(arm, thruster.direction))
        net += np.where((on <= t) & (t < off), force, 0.0)[:, None] * unit
    return net


def true_pulses(environment: Environment) -> tuple[Pulse, ...]:
    """What the thrusters do: the recorded force times the gain."""
    return tuple(
        Pulse(name, pulse.on, pulse.off, thrust.gain * pulse.force)
        for name, thrust in environment.thrusters.items()
        for pulse in thrust.pulses
    )


def thrust_columns(
    environment: Environment, t: Float[np.ndarray, " rows"]
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns that a recording has of them, N.

    A number holds until the next row: it is the mean over that time, and the impulse is
    right wherever a pulse begins. The times of the rows are in s.
    """
    return {
        f"thruster.{name}.force": sum(
            (pulse.force * part_on(pulse, t) for pulse in thrust.pulses),
            np.zeros(t.size),
        )
        for name, thrust in environment.thrusters.items()
    }


def part_on(pulse: Firing, t: Float[np.ndarray, " rows"]) -> Float[np.ndarray, " rows"]:
    """The part of the time until the next row in which a pulse is on; zero at last."""
    since = np.clip(t, pulse.on, pulse.off)
    return np.append(np.diff(since) / np.diff(t), 0.0)
