"""What is recorded of the wrenches that act on the base, in one form.

Of what surrounds the base, the directions to the Earth, the air, the sun and the
magnetic field are known in its axes.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.histories import Columns
from orbident.recordings.no_measurements import SURROUNDINGS
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Thruster

GROUND = 6.35e6
"""m: less than the Earth's radius at its poles."""

UNIT = 0.01
"""What the norm of a direction may differ from one by."""

STRONGEST = 7e-5
"""T: the Earth's field at its poles, on the ground."""

Surroundings = Mapping[str, Float[np.ndarray, "samples 3"]]


def surroundings(robot: Robot, recording: Recording, x_WB: Columns) -> Surroundings:
    """The vectors in base axes, as they were recorded, or else of the robot's orbit.

    Between their samples they change evenly.

    Args:
        robot: perhaps with an orbit.
        recording: perhaps with columns.
        x_WB: the attitude at its samples.

    Raises:
        InputError: an orbit is below the ground, a direction has not the norm one, the
            field is stronger than the Earth's, or the orbit needs an attitude, or is
            not known at these times.
    """
    found: dict[str, Float[np.ndarray, "samples 3"]] = {}
    for name in SURROUNDINGS:
        if recording.has_vector(name):
            shown = recording.vector(name)
            known = np.isfinite(shown).all(axis=1)
            if known.any():
                _check(f"{recording.source}: columns '{name}.x .y .z'", name, shown)
                t = recording.t
                found[name] = np.column_stack(
                    [np.interp(t, t[known], x[known]) for x in shown.T]
                )
    missing = [name for name in SURROUNDINGS if name not in found]
    around = {**found, **_by_orbit(robot, recording, x_WB, missing)}
    # There is no sun in the Earth's shadow.
    return {name: vectors for name, vectors in around.items() if vectors.any()}


def _by_orbit(
    robot: Robot, recording: Recording, x_WB: Columns, names: Sequence[str]
) -> Surroundings:
    """The vectors of these names, as far as the robot's orbit tells them."""
    orbit, t = robot.orbit, recording.t
    if orbit is None or not names:
        return {}
    if not recording.has_vector("attitude"):
        raise InputError(
            f"{recording.source}: the robot file gives an orbit, and without "
            "attitude.x to .w nobody knows where the Earth is, seen from the base; add "
            "them, or remove 'orbit:' from the robot file"
        )
    try:
        arc = orbit.arc(float(t[0]), float(t[-1]))
        # Drag goes with the square of the speed, which is one in the mean.
        wind = arc.wind(t)
        speed = np.linalg.norm(wind, axis=1, keepdims=True)
        inertial = {
            "nadir": -arc.position(t),
            "flow": -speed * wind / np.mean(speed**2),
        }
        if orbit.epoch is not None:
            inertial["sun"] = arc.sun(t)
            if "field" in names:
                inertial["field"] = arc.field(t)
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    # Where the attitude is not known, neither is what is seen from the base.
    R_BW = Rotation.from_quat(np.column_stack(x_WB)).inv()
    return {
        name: R_BW.apply(vectors) for name, vectors in inertial.items() if name in names
    }


def _check(where: str, name: str, shown: Float[np.ndarray, "samples 3"]) -> None:
    size = np.linalg.norm(shown, axis=1)
    least, most = float(np.nanmin(size)), float(np.nanmax(size))
    if name == "nadir" and least < GROUND:
        raise InputError(
            f"{where}: found a vector of {least:.4g} m, an orbit below the ground; "
            "give that from the robot to the middle of the Earth, base axes, in metres"
        )
    # The Earth may hide the sun, or a part of it.
    least = 1.0 if name == "sun" else least
    if name in {"flow", "sun"} and not 1 - UNIT < least <= most < 1 + UNIT:
        raise InputError(
            f"{where}: found a vector with norm {most:.4g}; give a direction with norm "
            "one, base axes"
        )
    if name == "field" and most > STRONGEST:
        raise InputError(
            f"{where}: found a field of {most:.3g} T, stronger than the Earth's; give "
            "tesla, base axes"
        )


NET_GAIN = 0.1
"""Standard deviation of a net wrench, over what is recorded: no robot file says it."""


class RecordedWrench(NamedTuple):
    """It acts from a sample until the next; base axes."""

    name: str
    gain: float
    """Standard deviation of its size, over what is recorded."""
    force: Float[np.ndarray, "samples 3"]
    """N."""
    torque: Float[np.ndarray, "samples 3"]
    """About S, N m."""
    dipole: Float[np.ndarray, "samples 3"]
    """Of a torquer, A m^2: the field makes a torque of it."""
    valve: bool = False
    """Whether it is a thruster's: along one direction, and switched."""


def thrust_seen(wrenches: Sequence[RecordedWrench]) -> Iterator[str]:
    """`thrusters` where any is switched, and `thrusters together` where several act."""
    on = np.array([each.force.any(axis=1) for each in wrenches if each.valve])
    if any(np.diff(each.force, axis=0).any() for each in wrenches if each.valve):
        yield "thrusters"
    if (on.sum(axis=0) > 1).any():
        yield "thrusters together"


Wrenches = tuple[RecordedWrench, ...]


def recorded_wrenches(
    robot: Robot, recording: Recording, around: Surroundings
) -> Wrenches:
    """Wrenches of thrusters and torquers, or net ones, without those that never act.

    Args:
        robot: with thrusters and torquers.
        recording: what they did.
        around: with the magnetic field, if it is known.

    Raises:
        InputError: a thruster's duty is not within 0 and 1, or its thrust is not in the
            robot file; it is recorded twice; a force without its torque; or a dipole
            without the field.
    """
    thrust, net = recorded_thrust(robot, recording)
    if any(np.isnan(wrench.torque).any() for wrench in net):
        raise InputError(
            f"{recording.source}: 'force.x .y .z' act, and 'torque.x .y .z' (about "
            "S) are missing, without which the momentum is not known; add them, or "
            "give each thruster's own force as 'thruster.NAME.force'"
        )
    magnetic = _acting(_of_torquers(robot, recording))
    if magnetic and "field" not in around:
        raise InputError(
            f"{recording.source}: column '{magnetic[0].name}.dipole': without the "
            "magnetic field its torque is not known; add columns field.x .y .z, or an "
            "orbit with an epoch to the robot file"
        )
    return (*thrust, *net, *magnetic)


def recorded_thrust(robot: Robot, recording: Recording) -> tuple[Wrenches, Wrenches]:
    """Wrenches of the thrusters, or the net one, without those that never act.

    Args:
        robot: with thrusters.
        recording: what they did. The net torque is NaN where it was not recorded.

    Raises:
        InputError: as `recorded_wrenches` says of thrusters.
    """
    thrust = _acting(_of_thrusters(robot, recording))
    net = _acting(_net(recording))
    if thrust and net:
        raise InputError(
            f"{recording.source}: the columns 'force.*' are the net force of all "
            "thrusters, and 'thruster.*' are there too: they would count twice; remove "
            "one of them"
        )
    return thrust, net


def _acting(wrenches: Iterator[RecordedWrench]) -> Wrenches:
    return tuple(w for w in wrenches if any(x.any() for x in w[2:5]))


def _of_torquers(robot: Robot, recording: Recording) -> Iterator[RecordedWrench]:
    for torquer in robot.torquers:
        name = f"torquer.{torquer.name}"
        if recording.has(f"{name}.dipole"):
            size = _held(recording.columns[f"{name}.dipole"])
            dipole = np.outer(size, torquer.axis)
            zero = np.zeros_like(dipole)
            yield RecordedWrench(name, torquer.gain, zero, zero, dipole)


def _of_thrusters(robot: Robot, recording: Recording) -> Iterator[RecordedWrench]:
    for thruster in robot.thrusters:
        name = f"thruster.{thruster.name}"
        force = np.outer(_newton(thruster, recording), thruster.direction)
        torque = np.cross(thruster.position - robot.feature_point, force)
        none = np.zeros_like(force)
        yield RecordedWrench(name, thruster.gain, force, torque, none, valve=True)


def _newton(thruster: Thruster, recording: Recording) -> Float[np.ndarray, " samples"]:
    force, duty = (f"thruster.{thruster.name}.{kind}" for kind in ("force", "duty"))
    if not recording.has(duty):
        if recording.has(force):
            return _held(recording.columns[force])
        return np.zeros(recording.t.size)
    where = f"{recording.source}: column '{duty}'"
    if recording.has(force):
        raise InputError(f"{where}: '{force}' is there too; remove one of them")
    if thruster.thrust is None:
        raise InputError(
            f"{where}: a duty is a part of the full thrust, which the robot file does "
            f"not say; add 'thrust: 5' (N) to thruster '{thruster.name}'"
        )
    on = _held(recording.columns[duty])
    wrong = np.flatnonzero((on < 0) | (on > 1))
    if wrong.size:
        percent = 1 < np.max(on) <= 100 and np.min(on) >= 0
        perhaps = ": if it is in percent, divide it by 100" if percent else ""
        raise InputError(
            f"{where}, row {wrong[0] + 1}: found {on[wrong[0]]:g}; a duty is between 0 "
            f"(off) and 1 (full thrust){perhaps}"
        )
    return on * thruster.thrust


def _net(recording: Recording) -> Iterator[RecordedWrench]:
    force, torque = (_vector(recording, name) for name in ("force", "torque"))
    if torque is None and (force is None or not force.any()):
        return
    zero = np.zeros((recording.t.size, 3))
    force = zero if force is None else force
    torque = np.full_like(zero, np.nan) if torque is None else torque
    yield RecordedWrench("wrench", NET_GAIN, force, torque, zero)


def _vector(recording: Recording, name: str) -> Float[np.ndarray, "samples 3"] | None:
    if not recording.has_vector(name):
        return None
    return np.column_stack([_held(column) for column in recording.vector(name).T])


def _held(shown: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """A number holds until the next; before the first there is nothing."""
    rows = np.where(np.isfinite(shown), np.arange(shown.size), 0)
    return np.nan_to_num(shown[np.maximum.accumulate(rows)])
