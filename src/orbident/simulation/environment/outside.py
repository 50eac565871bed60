"""All that acts on a robot: checked, drawn, and as wrenches for the core."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed, suggestion
from orbident.model.rotations import rotate_back
from orbident.orbits.orbit import Arc
from orbident.robot.description import Robot
from orbident.simulation.environment import air_table, orbital, steady
from orbident.simulation.environment.moving import Force, Path, Vectors, at_rest
from orbident.simulation.flight_steps import FlightStates, WrenchPoint
from orbident.simulation.noise_processes import stream
from orbident.simulation.thrusters import Pulse
from orbident.trajectories.environment import Environment, Firing

MOST_ROUNDS = 60
"""Flights until what acts is that of the motion; a whole orbit takes some 25."""

COARSE = 2**15
"""Steps of a flight that may be too long for the joints' control."""

Wrenches = Callable[[Float[np.ndarray, "steps 3"]], Float[np.ndarray, "steps 3 w 6"]]


@dataclass(frozen=True)
class ExternalForces:
    """What acts on one flight."""

    robot: Robot
    environment: Environment
    forces: tuple[Force, ...]
    points: tuple[WrenchPoint, ...]

    @property
    def edges(self) -> list[float]:
        """When bursts begin and end, s."""
        bursts = self.environment.bursts
        return [edge for b in bursts for edge in (b.start, b.start + b.duration)]

    def wrenches(self, path: Path | None) -> Wrenches:
        """A function that gives force and moment at the points, at any nodes.

        They are in base axes, and zero where there is no path.
        """

        def at(nodes: Float[np.ndarray, "steps 3"]) -> Float[np.ndarray, "..."]:
            net = np.zeros((nodes.size, len(self.points), 6))
            if path is not None and self.forces:
                moving = path.at(nodes)
                every = (each for force in self.forces for each in force(moving))
                for k, acting in enumerate(every):
                    net[:, k, :3] = rotate_back(moving.R_WB, acting.force)
                    net[:, k, 3:] = rotate_back(moving.R_WB, acting.moment)
            return net.reshape(*nodes.shape, -1, 6)

        return at

    def settled(
        self,
        fly: Callable[[Wrenches], FlightStates],
        t: Float[np.ndarray, " steps"],
        path: Path | None,
        tolerance: float,
    ) -> tuple[FlightStates, Path | None]:
        """Fly until what acts is that of the motion which it makes.

        What acts changes motions little, so that each flight is far nearer than the
        one before (Picard's iteration).

        Args:
            fly: a flight under given wrenches.
            t: the starts of its steps, s.
            path: a motion to begin with; without one, nothing acts on the first flight.
            tolerance: of attitude, joints and position, rad or m.

        Returns:
            What was seen, and the path of it. Where it does not settle, the CM is not a
            number: steps that are too long for stiff joints make the motion unstable.

        Raises:
            InputError: it does not settle although steps are short.
        """
        if not self.forces:
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
        return air_table.pull(self.environment, r_S)


def outside_of(
    robot: Robot,
    environment: Environment | None,
    t: Float[np.ndarray, " rows"],
    seed: int,
) -> ExternalForces:
    """All that acts on a flight.

    Args:
        robot: that flies.
        environment: what acts; nothing where it is None.
        t: the rows of the flight, s; slow processes are drawn there.
        seed: of these.

    Raises:
        InputError: this robot cannot be acted on like that.
    """
    environment = environment or Environment()
    check_environment(robot, environment)
    arc = arc_of(robot, environment, t)
    forces = tuple(_forces(environment, arc, t, seed))
    still = at_rest(robot)
    points = [
        WrenchPoint(acting.body, acting.point)
        for force in forces
        for acting in force(still)
    ]
    return ExternalForces(robot, environment, forces, tuple(points))


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

    Args:
        robot: perhaps with an orbit.
        environment: perhaps with another one.
        t: the rows of the flight, s after the epoch.

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
    right wherever a pulse begins.

    Args:
        environment: with the thrusters.
        t: the times of the rows, s.
    """
    return {
        f"thruster.{name}.force": sum(
            (_mean(pulse, t) for pulse in thrust.pulses), np.zeros(t.size)
        )
        for name, thrust in environment.thrusters.items()
    }


def _mean(pulse: Firing, t: Float[np.ndarray, " rows"]) -> Float[np.ndarray, " rows"]:
    since = np.clip(t, pulse.on, pulse.off)
    return np.append(pulse.force * np.diff(since) / np.diff(t), 0.0)


def _forces(
    given: Environment, arc: Arc | None, t: Float[np.ndarray, " rows"], seed: int
) -> Iterator[Force]:
    if given.torque:
        yield partial(steady.constant_torque, given.torque)
    if given.force:
        yield partial(steady.constant_force, given.force)
    for name, act in (
        ("slow_torque", steady.slow_torque),
        ("slow_force", steady.slow_force),
    ):
        slow = getattr(given, name)
        if slow is not None:
            random = stream(seed, f"environment.{name}")
            drawn = steady.Slow(t, slow.std, slow.correlation_time, random)
            yield partial(act, drawn)
    for burst in given.bursts:
        yield partial(steady.burst, burst)
    yield from _on_table(given)
    if given.solar_pressure:
        yield partial(orbital.solar_pressure, given.solar_pressure, arc)
    if arc is not None:
        yield from _in_orbit(given, arc)


def _on_table(given: Environment) -> Iterator[Force]:
    if given.tilt or given.uneven:
        yield partial(air_table.pulls, given)
    for body, film in given.film_drag.items():
        yield partial(air_table.film_drag, body, film)


def _in_orbit(given: Environment, arc: Arc) -> Iterator[Force]:
    if given.gravity_gradient:
        yield partial(orbital.tidal_loads, arc)
    if given.air_drag:
        yield partial(orbital.air_drag, given.air_drag, arc)
    if given.dipole:
        yield partial(orbital.dipole, given.dipole, arc)
