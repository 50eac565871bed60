"""Whether the base rings: a narrow line in the spectrum of what is left of its rate.

What swings on a spring, and is taken for rigid, turns the base at a frequency of its
own. Wrong instruments or mass properties leave what moves with the joints: without that
the spectrum is smooth, and no oscillator explains most of it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.signal import bilinear, lfilter

from orbident.estimation.levels import limit, outstanding
from orbident.estimation.signals import Signal, Signals
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.samples import Batch, Samples
from orbident.robot.description import Robot
from orbident.simulation.free_floating import rate_law

ROWS = 2**13
"""So many rows from the beginning show a ring."""

CYCLES = 8
"""Fewer of them in a recording are no line."""

LOBE, DETUNED = 2, 0.1
"""Width of a line to either side: that of Hann's window, in steps of frequency, and
how far a frequency changes as joints move."""

RISES = 25.0
"""Times its surroundings: at its frequency what is damped by a tenth of critical moves
with `1 / (2 zeta)^2` of the power that drives it."""

NEAR = np.linspace(0.9, 1.1, 81)
"""Frequencies that are tried, over that of the line. Joints that move at one near by
pull the line towards theirs."""

ZETA = 0.01
"""Damping of structures over critical. The frequency hardly depends on it."""

Course = Float[np.ndarray, "n axes"]

Rates = Float[np.ndarray, "n rates"]


class RigidMotion(NamedTuple):
    """What shakes a part that swings in a robot that is rigid apart from it."""

    t: Float[np.ndarray, " n"]
    """s."""
    rates: Rates
    """Rates of the base, rad/s and m/s, base axes, and of functions of the joints."""


class Ring(NamedTuple):
    """What rings."""

    frequency: float
    """Hz, where nothing holds the base."""
    alike: bool
    """Whether gyro and attitude both show it; else the sensor may swing."""

    @property
    def reason(self) -> str:
        """What is said of it."""
        rings = f"something rings at {self.frequency:.3g} Hz and moves in the robot "
        of = "(a panel, fuel, a flexible joint, a loose mass)"
        if self.alike:
            return f"{rings}{of}: gyro and attitude show it alike"
        return f"perhaps {rings}{of}, or the mount of the sensor that shows it does"

    @property
    def remedy(self) -> str:
        """How it is declared."""
        at = f"{{frequency: {self.frequency:.3g} Hz}}"
        either = f"'passive: {{JOINT: {at}}}' or 'flexible: {{JOINT: {at}}}'"
        return f"declare what swings, {either}, and identify again"


def rigid_motion(robot: Robot, samples: Samples) -> RigidMotion:
    """How a robot moves if it is rigid and as its file says, of its joints and wheels.

    The rates of the fit are no such thing: it moves joints, within the noise of their
    encoders, so that they explain some of a ring.
    """
    t, complete = samples.complete()
    at = Batch(*(part[:ROWS] for part in complete))
    now, q, qd = inertia(robot, at.q), at.q, at.qd
    # D w + h = R_WB^T h_cm (Eq. 3), and v is that of S beside the CM.
    h = rotate(now.D_q, qd) + at.qd_rw @ wheels_of(robot).A_rw.T
    h_cm = rotate(quaternion_matrix(at.x_WB), rotate(now.D, at.w) + h).mean(axis=0)
    law = rate_law(now.D, h, robot.motion == "planar")
    w = law.rate(at.x_WB, np.broadcast_to(h_cm, h.shape))
    v = -np.cross(w, now.r_cm) - rotate(now.J_cm, qd)
    # Encoders off in scale or off centre turn the base as the pose says.
    by_joints = [qd, np.cos(q) * qd, np.sin(q) * qd]
    return RigidMotion(t[:ROWS], np.column_stack([w, v, *by_joints]))


def ring_of(signals: Signals, moved: RigidMotion) -> Ring | None:
    """The line with most power in what is left of the base's rate.

    Args:
        signals: of a fit.
        moved: the robot at the same time, if it were rigid.

    Returns:
        The ring; None where no line stands out of the spectrum around it, no oscillator
        explains most of what is left, or the gyro alone shows it.
    """
    by_sensor = {each.sensor: each for each in signals}
    attitude = by_sensor.get("attitude")
    shown = by_sensor.get("gyro", attitude)
    if shown is None or shown.t.size <= 2 * CYCLES:
        return None
    t, left = at_even_times(shown)
    if shown is attitude:
        left = np.gradient(left, t, axis=0)
    rates = [np.interp(t, moved.t, rate) for rate in moved.rates.T]
    drive = np.column_stack([*rates, np.ones(t.size)])
    left = left - drive @ np.linalg.lstsq(drive, left)[0]
    line = narrow_line(left)
    if line is None:
        return None
    f, unexplained = _oscillator(t, left, line, drive)
    if unexplained > 1 / 2:
        return None
    if attitude is None or shown is attitude:
        return Ring(f, alike=False)
    part, std = _part_shown(t, left, line, attitude)
    most = limit("ring", 1)
    if ((part - 1) / std) ** 2 > most and part < 1 / 2:
        return None
    return Ring(f, alike=(part / std) ** 2 > most)


def at_even_times(signal: Signal) -> tuple[Float[np.ndarray, " n"], Course]:
    """Evenly spaced times from the beginning on, and what is left there."""
    n, left = min(signal.t.size, ROWS), signal.measured - signal.predicted
    t = np.linspace(signal.t[0], signal.t[n - 1], n)
    return t, np.column_stack([np.interp(t, signal.t, x) for x in left.T])


def narrow_line(x: Course) -> int | None:
    """The step of frequency of the line with most power that stands out."""
    n, axes = x.shape
    windowed = np.hanning(n)[:, None] * x
    power = np.sum(np.abs(np.fft.rfft(windowed, axis=0)) ** 2, axis=1)
    most = max(RISES, outstanding(axes, power.size))
    for k in CYCLES + np.argsort(-power[CYCLES:]):
        half = LOBE + int(DETUNED * k)
        around = power[k // 2 : k - half], power[k + half + 1 : 2 * k + 1]
        if power[k] < power[k - half : k + half + 1].max() or not around[1].size:
            continue
        if power[k] > most * max(map(np.median, around)):
            return int(k)
    return None


def _oscillator(
    t: Float[np.ndarray, " n"], x: Course, line: int, drive: Rates
) -> tuple[float, float]:
    """The frequency, Hz, that explains most, and the part of `x` that is left then.

    What moves drives the oscillator, and it swings from the beginning on. As that is
    without what the ring itself turns, `w` is that of the free robot, not of one whose
    base is held:

        y'' + 2 zeta w y' + w^2 y = B u'',  w = 2 pi f
    """
    since, dt = t - t[0], t[1] - t[0]

    def unexplained(f: float) -> float:
        w = 2 * np.pi * f
        # Bilinear, with the frequency itself as it is.
        rate = w / (2 * np.tan(w * dt / 2))
        b, a = bilinear([1, 0, 0], [1, 2 * ZETA * w, w**2], rate)
        driven = lfilter(b, a, drive - drive[:1], axis=0)
        decay = np.exp((-ZETA + 1j) * w * since)
        X = np.column_stack([driven, decay.real, decay.imag, drive])
        return float(np.sum((x - X @ np.linalg.lstsq(X, x)[0]) ** 2))

    f = float(min(line / (t.size * dt) * NEAR, key=unexplained))
    return f, unexplained(f) / float(np.sum(x**2))


def _part_shown(
    t: Float[np.ndarray, " n"], x: Course, line: int, attitude: Signal
) -> tuple[float, float]:
    """How much of the turn by which the gyro rings the attitude shows, and how surely.

    It is one if the base rings, and zero if the gyro alone does.
    """
    spectrum = np.fft.rfft(x, axis=0)
    k = np.arange(len(spectrum))
    w = 2 * np.pi * np.maximum(k, 1) / (t.size * (t[1] - t[0]))
    of_line = np.abs(k - line) <= LOBE + int(DETUNED * line)
    turn = np.fft.irfft(spectrum * (of_line / (1j * w))[:, None], t.size, axis=0)
    seen = attitude.t <= t[-1]
    at = attitude.t[seen]
    swings = np.column_stack([np.interp(at, t, axis) for axis in turn.T])
    off = (attitude.measured - attitude.predicted)[seen]
    off = off - off.mean(axis=0)
    part = np.sum(swings * off) / np.sum(swings**2)
    rest = np.sum((off - part * swings) ** 2) / off.size
    return float(part), float(np.sqrt(rest / np.sum(swings**2)))
