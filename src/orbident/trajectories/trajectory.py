"""An exciting trajectory as plain frozen data, and the state it starts from.

Joints follow Eq. 41: a finite Fourier series plus the quintic that meets the ends.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.files.names import listed
from orbident.model.kinematics import JointState
from orbident.robot.description import Robot
from orbident.threads import processors
from orbident.trajectories.environment import Environment

DEGREE = 5
"""Of the polynomial that meets the ends."""


@dataclass(frozen=True, eq=False)
class FourierQuintic:
    r"""Joint motions whose boundary values hold whatever `a` and `b` are.

    q_i(t) = sum_l a_il/(w_f l) sin(w_f l t) - b_il/(w_f l) cos(w_f l t)
             + sum_{j=0..5} c_ij t^j,      w_f = 2 pi / t_f      (Eq. 41)
    """

    a: Float[np.ndarray, "joints harmonics"]
    """Cosine amplitudes of the rate, rad/s or m/s."""
    b: Float[np.ndarray, "joints harmonics"]
    """Sine amplitudes of the rate, rad/s or m/s."""
    start: Float[np.ndarray, "joints 3"]
    """Position, velocity and acceleration at t = 0."""
    end: Float[np.ndarray, "joints 3"]
    """The same at t = t_f."""
    duration: float
    """t_f, s."""

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at the times `t`, s."""
        q, qd, qdd = self._sums(range(3), t)
        return q, qd, qdd

    def derivative(
        self, order: int, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n joints"]:
        """A derivative of any order at the times `t`, s."""
        return self._sums([order], t)[0]

    def bound(self, order: int) -> Float[np.ndarray, " joints"]:
        """A bound of a derivative in which the quintic has no part: sixth or later."""
        return np.hypot(self.a, self.b) @ self._frequencies ** (order - 1)

    def _sums(
        self, orders: Iterable[int], t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "orders n joints"]:
        coefficients = np.stack([self._coefficients(order) for order in orders])
        return _core.fourier_quintic(coefficients, t / self.duration, processors())

    def _coefficients(self, order: int) -> Float[np.ndarray, "joints m"]:
        """Over the cosines and sines of the harmonics and the powers of `s = t / t_f`.

        The series' is `w^(k-1) (a sin(w t + k pi/2) - b cos(w t + k pi/2))`, the
        imaginary part of `w^(k-1) i^k (a - i b) exp(i w t)`; the quintic's is
        `sum_j j!/(j-k)! c_j s^(j-k) / t_f^k`.
        """
        gain = 1j**order * (self.a - 1j * self.b) * self._frequencies ** (order - 1)
        quintic = np.zeros_like(self._quintic)
        for j in range(order, DEGREE + 1):
            quintic[j - order] = math.perm(j, order) * self._quintic[j]
        quintic /= self.duration**order
        return np.concatenate([gain.imag, gain.real, quintic.T], axis=1)

    @property
    def _frequencies(self) -> Float[np.ndarray, " harmonics"]:
        """`w_f l`, rad/s."""
        return 2 * np.pi * np.arange(1, self.a.shape[1] + 1) / self.duration

    @cached_property
    def _quintic(self) -> Float[np.ndarray, "6 joints"]:
        """Coefficients over powers of t / t_f: what the ends need beyond the series."""
        w = self._frequencies
        # The series has the same values at both ends.
        series = np.stack(
            [-(self.b / w).sum(axis=1), self.a.sum(axis=1), self.b @ w], axis=1
        )
        rates = self.duration ** np.arange(3)
        p0, v0, a0 = ((self.start - series) * rates).T
        p1, v1, a1 = ((self.end - series) * rates).T
        p, v, a = p1 - p0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
        return np.stack(
            [
                p0,
                v0,
                a0 / 2,
                10 * p - 4 * v + a / 2,
                -15 * p + 7 * v - a,
                6 * p - 3 * v + a / 2,
            ]
        )


QUATERNION_TOLERANCE = 0.1
"""Printed quaternions are rounded: that of Table 3 has norm 1.0024."""

_ROUNDING = 1e-9
"""Part of the duration by which a time may lie outside."""


@dataclass(frozen=True, eq=False)
class InitialState:
    """How the spacecraft moves at t = 0; at rest by default.

    Raises:
        InputError: A value is not finite, has another length, or the attitude's norm
            is not within 10 % of 1. Within that it is normalised.
    """

    angular_velocity: Float[np.ndarray, "3"] = field(
        default_factory=lambda: np.zeros(3)
    )
    """Angular velocity of the base, base axes, rad/s."""
    attitude: Float[np.ndarray, "4"] = field(
        default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0])
    )
    """Attitude of the base in the inertial frame, unit quaternion, scalar last."""
    velocity: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Velocity of S, inertial axes, m/s."""
    wheel_speed: Mapping[str, float] = field(default_factory=dict)
    """Relative to the base, rad/s; a wheel that is absent stands still."""

    def __post_init__(self) -> None:
        for name, shape in (("angular_velocity", (3,)), ("velocity", (3,))):
            _store(self, name, _numbers(f"initial.{name}", getattr(self, name), shape))
        _store(self, "attitude", _unit_quaternion(self.attitude))
        speeds = {wheel: float(speed) for wheel, speed in self.wheel_speed.items()}
        _numbers("initial.wheel_speed", list(speeds.values()), (len(speeds),))
        _store(self, "wheel_speed", speeds)

    def wheel_speeds(self, wheel_names: Sequence[str]) -> Float[np.ndarray, " wheels"]:
        """`qd_rw` in this order of the wheels, rad/s."""
        return np.array([self.wheel_speed.get(name, 0.0) for name in wheel_names])


AT_REST = np.zeros((0, 3))
"""An end of a motion of which nothing is said: all joints are at zero, and at rest."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Joint motions after Eq. 41, and the state of the spacecraft at their start.

    Raises:
        InputError: The duration is not positive, the shapes disagree, a joint is named
            twice, or a number is not finite.
    """

    duration: float
    """t_f, s."""
    joints: tuple[str, ...]
    """Names of the joints, in the order of the rows below."""
    a: Float[np.ndarray, "joints harmonics"]
    """Cosine amplitudes of the rate, rad/s or m/s."""
    b: Float[np.ndarray, "joints harmonics"]
    """Sine amplitudes of the rate, rad/s or m/s."""
    start: Float[np.ndarray, "joints 3"] = field(default_factory=lambda: AT_REST)
    """Position, velocity, acceleration at t = 0, rad or m, and s; by default zero."""
    end: Float[np.ndarray, "joints 3"] = field(default_factory=lambda: AT_REST)
    """Those at t = t_f."""
    initial: InitialState = field(default_factory=InitialState)
    environment: Environment | None = None
    """What acts from outside meanwhile."""
    design: Mapping[str, Any] | None = None
    """How it was made, its scores and proven margins."""
    source: str = "trajectory"
    """Where it came from, for messages."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.duration) and self.duration > 0):
            raise InputError(
                f"{self.source}: duration: found {self.duration}; "
                "give a positive number of seconds"
            )
        if len(set(self.joints)) < len(self.joints):
            raise InputError(
                f"{self.source}: joints: found {listed(self.joints)}; "
                "name each joint once"
            )
        K, N_f = len(self.joints), np.asarray(self.a).shape[-1]
        for name in ("start", "end"):
            if getattr(self, name) is AT_REST:
                _store(self, name, np.zeros((K, 3)))
        for name, columns in (("a", N_f), ("b", N_f), ("start", 3), ("end", 3)):
            place = f"{self.source}: {name}"
            _store(self, name, _numbers(place, getattr(self, name), (K, columns)))

    def __repr__(self) -> str:
        """Where it is from, how long it is, and of which joints."""
        outside = "" if self.environment is None else ", something acts from outside"
        return (
            f"{self.source}: {self.duration:g} s, {self.a.shape[1]} harmonics, joints "
            f"{listed(self.joints)}{outside}"
        )

    def at(self, t: Float[np.ndarray, " samples"]) -> JointState:
        """Positions, rates and accelerations at these times (Eq. 41).

        Args:
            t: Times, s, within [0, duration].

        Returns:
            `q`, `qd` and `qdd`, in rad or m, and s.

        Raises:
            InputError: A time is outside: the trajectory says nothing there.
        """
        t = np.asarray(t, dtype=np.float64)
        slack = _ROUNDING * self.duration
        outside = np.flatnonzero(~((t >= -slack) & (t <= self.duration + slack)))
        if outside.size:
            raise InputError(
                f"{self.source}: asked for t = {t[outside[0]]} s; "
                f"it is defined from 0 to {self.duration} s"
            )
        return self.motion.at(t)

    @cached_property
    def motion(self) -> FourierQuintic:
        """The same joint motions as functions, with derivatives of any order."""
        return FourierQuintic(
            self.a, self.b, self.start, self.end, float(self.duration)
        )

    def for_robot(self, robot: Robot) -> "Trajectory":
        """The same trajectory with its rows in the order of the robot's joints.

        A joint that it does not name and that follows another moves as the robot says.
        A passive one is not driven: if it is named, it is held where its spring rests.

        Raises:
            InputError: A joint is missing or unknown, or a wheel is unknown.
        """
        table = np.hstack([self.a, self.b, self.start, self.end])
        leaders = {
            name: (name, 1.0, 0.0)
            for name, row in zip(self.joints, table, strict=True)
            if row.any() or name not in robot.passive
        }
        for follower, leader, factor, offset in robot.couplings:
            if leader in self.joints:
                leaders.setdefault(follower, (leader, factor, offset))
        driven = [name for name in robot.joint_names if name not in robot.passive]
        if set(leaders) != set(driven):
            beside = ", passive ones apart" if robot.passive else ""
            raise InputError(
                f"{self.source}: joints: found {listed(self.joints)}, but robot "
                f"'{robot.name}' has {listed(driven)}{beside}; give each of them"
            )
        if not set(self.initial.wheel_speed) <= set(robot.wheel_names):
            raise InputError(
                f"{self.source}: initial.wheel_speed: found "
                f"{listed(self.initial.wheel_speed)}, but robot '{robot.name}' has "
                f"{listed(robot.wheel_names)}; name only wheels of the robot"
            )
        offsets = np.zeros(len(robot.joints))
        lead = np.zeros((offsets.size, len(self.joints)))
        for name, (leader, factor, offset) in leaders.items():
            k = robot.joint_names.index(name)
            lead[k, self.joints.index(leader)], offsets[k] = factor, offset
        a, b, start, end = (
            lead @ each for each in (self.a, self.b, self.start, self.end)
        )
        for state in (start, end):
            state[:, 0] += offsets
        return replace(self, joints=robot.joint_names, a=a, b=b, start=start, end=end)


def _store(instance: object, name: str, value: object) -> None:
    object.__setattr__(instance, name, value)


def _numbers(place: str, values: object, shape: tuple[int, ...]) -> np.ndarray:
    """A private read-only copy, once shape and values are as they should be."""
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        raise InputError(f"{place}: found shape {array.shape}; give shape {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{place}: found {array.tolist()}; give finite numbers")
    array.flags.writeable = False
    return array


def _unit_quaternion(values: object) -> np.ndarray:
    quaternion = _numbers("initial.attitude", values, (4,))
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1.0) > QUATERNION_TOLERANCE:
        raise InputError(
            f"initial.attitude: found {quaternion.tolist()} of norm {norm:.6g}; "
            "give a unit quaternion, scalar last"
        )
    # Normalising twice would move the last bits, and a file would not round-trip.
    if abs(norm - 1.0) < 4 * np.finfo(np.float64).eps:
        return quaternion
    return _numbers("initial.attitude", quaternion / norm, (4,))
