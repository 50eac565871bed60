"""What a robot is commanded to do, as data that the core evaluates."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.model.kinematics import JointState
from orbident.robot.description import Robot
from orbident.trajectories.environment import Environment, Firing


class Hold(NamedTuple):
    """Joints that are commanded to stay."""

    q: Float[np.ndarray, " joints"]

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """The same positions at all times, without rates and accelerations."""
        q = np.tile(self.q, (t.size, 1))
        return q, np.zeros_like(q), np.zeros_like(q)


class JointPD(NamedTuple):
    """`tau = Kp (q_d - q) + Kd (qd_d - qd)`, N m or N."""

    Kp: Float[np.ndarray, " joints"]
    Kd: Float[np.ndarray, " joints"]


class Driven(NamedTuple):
    """The joints do exactly as commanded, whatever torque that takes."""


class WheelSpeed(NamedTuple):
    """`tau_rw = k (qd_rw,d - qd_rw)`: brings each wheel to a speed."""

    k: Float[np.ndarray, " wheels"]
    """N m s/rad."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


class AttitudeHold(NamedTuple):
    """The wheels turn the base back to an attitude: `n = -kp e - kd w`.

    `e` is twice the vector part of the quaternion from the wanted attitude, base
    axes; a rotor that is driven by `tau_rw` turns the base by `-a tau_rw`.
    """

    kp: float
    """N m/rad."""
    kd: float
    """N m s/rad."""
    x_WD: Float[np.ndarray, "4"]
    """The attitude to hold, unit quaternion, scalar last."""
    share: Float[np.ndarray, "wheels 3"]
    """The wheels' part in a moment on the base: the pseudo-inverse of their axes."""


class OpenLoop(NamedTuple):
    """Torques that depend on time alone."""

    torque: Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, "n actuators"]]
    """Torque at given times (s): of each joint (N m or N), or on each rotor (N m)."""


@runtime_checkable
class AttitudeMotion(Protocol):
    """What the base is commanded to do: any function of time."""

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]
    ]:
        """Attitude `x_WD`; its rate and acceleration in D's axes, rad and s."""
        ...


class ComputedTorque(NamedTuple):
    """The torques for which a model says `y'' = y_d'' + kd e' + kp e`, for all of y.

    `y` are the joints and the attitude of the base; the wheels' accelerations are what
    this takes, and the system CM is left alone. One such law is the law of the joints
    and of the wheels.
    """

    model: Robot
    """Its `theta` is what the controller believes."""
    base: AttitudeMotion
    kp: float
    """1/s^2."""
    kd: float
    """1/s."""


JointLaw = JointPD | Driven | OpenLoop | ComputedTorque
WheelLaw = WheelSpeed | AttitudeHold | OpenLoop | ComputedTorque


class WheelLimits(NamedTuple):
    """The greatest torques and speeds of motors; infinite where there is no limit.

    A motor gives at most its greatest torque, and none that drives the wheel beyond its
    top speed: over the last 2 % of that speed the torque falls to zero.
    """

    torque: Float[np.ndarray, " wheels"]
    """N m."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


def attitude_hold(
    robot: Robot, kp: float, kd: float, attitude: Float[np.ndarray, "4"]
) -> AttitudeHold:
    """The law for a robot's wheels, about the axes that they span.

    `kp` is in N m/rad and `kd` in N m s/rad; the attitude is a unit quaternion, scalar
    last.
    """
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    return AttitudeHold(kp, kd, attitude, np.linalg.pinv(axes))


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
