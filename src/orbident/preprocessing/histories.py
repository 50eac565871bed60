"""What joints and wheels did at the rows of a recording, and which joints were held."""

from collections.abc import Mapping, Sequence
from functools import partial, reduce
from itertools import chain
from operator import or_
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.model.kinematics import inertia_at
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rate_noise import NO_NOISE, RateNoise, waves_of_noise
from orbident.preprocessing.rates import at_times, fill
from orbident.preprocessing.smoothing import (
    AT_ONCE,
    Rates,
    Roughness,
    Settings,
    Smoothed,
    fits_of,
    smooth,
    smooth_rates,
)
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import EncoderSpec
from orbident.threads import side_by_side

Columns = tuple[Float[np.ndarray, " samples"], ...]

LEAST = 1e-60
"""rad/s or m/s: its square and its inverse are still float64s."""

IN_WAVES = 0.57
"""Waves of noise, times the reach of a smoother over the recording's duration `T`, that
hold all that it leaves: of wave `m` it leaves `1 / (1 + (m pi reach / T)^8)`, which is
a hundredth there."""


class Lead(NamedTuple):
    """How one joint moves another: `q = factor q' + offset`, rad or m."""

    by: str
    factor: float
    offset: float


class Histories(NamedTuple):
    """Histories of all joints, or of all wheels, in the robot's order."""

    positions: Columns
    """Empty where they are not recorded."""
    rates: Columns
    origin: Origin
    """How the rates were obtained."""
    shares: tuple[float, ...]
    """Variance of a smoothed position over that of a sample; NaN where the rate was
    measured. A sample determines so many unknowns of the motion."""
    worst: tuple[tuple[float, float], ...]
    """The largest deviations of a smoothed position, rad or m, and of its rate, per
    second: those in the middle of a gap. Zero where they are not known."""
    noise: tuple[RateNoise, ...]
    """None where an angle is recorded. Where none is declared it is what the column
    shows, of a rate that is used as it was read."""

    def held(self, at: Mapping[str, float], names: Sequence[str]) -> "Histories":
        """Those of joints some of which did not move.

        Args:
            at: where these are held, rad or m.
            names: of all joints.
        """
        q, qd = list(self.positions), list(self.rates)
        for k, name in enumerate(names):
            if name in at:
                q[k], qd[k] = np.full_like(q[k], at[name]), np.zeros_like(qd[k])
        return self._replace(positions=tuple(q), rates=tuple(qd))

    def led(self, by: Mapping[str, Lead], names: Sequence[str]) -> "Histories":
        """Those of joints some of which move as others.

        Args:
            by: what moves those that follow.
            names: of all joints.
        """
        at = {name: k for k, name in enumerate(names)}
        q, qd = list(self.positions), list(self.rates)
        shares, worst = list(self.shares), list(self.worst)
        for name, (leader, factor, offset) in by.items():
            k, other = at[name], at[leader]
            q[k], qd[k] = factor * q[other] + offset, factor * qd[other]
            of_q, of_qd = worst[other]
            worst[k] = abs(factor) * of_q, abs(factor) * of_qd
            shares[k] = shares[other]
        return self._replace(
            positions=tuple(q),
            rates=tuple(qd),
            shares=tuple(shares),
            worst=tuple(worst),
        )


def histories(
    recording: Recording,
    what: str,
    names: Sequence[str],
    rate: str,
    sensor: EncoderSpec | None,
    late: float,
    settings: Settings,
    shows: float = 0.0,
) -> Histories:
    """Positions and rates at every row, gaps filled.

    Rates that were measured are used as they are. Others are those of the positions,
    as smooth as the encoders' noise says. Where the file declares the noise of a
    tachometer beside an encoder, the rate is the mean of what both say when smoothed.
    That of a tachometer alone is smoothed where the waves of its noise that a fit has
    among its unknowns hold all that smoothing leaves. A faster one is much larger than
    its noise, and has corners, next to which smoothing would be far off. Noise that
    hardly shows stays as it is.

    Args:
        recording: with a position or a rate of each of `names`.
        what: `"joint"` or `"wheel"`: how the columns begin.
        names: of the robot.
        rate: how the columns of rates end.
        sensor: the encoders, as the robot file has them.
        late: by how much the encoders' times are behind, s.
        settings: of the whole recording.
        shows: density of a tachometer's noise from which on it shows in the base's
            rate, rad/s/sqrt(Hz).

    Raises:
        InputError: a column has too few samples.
    """
    noise = None if sensor is None else sensor.unseen_std
    tachometer = None if sensor is None else sensor.tachometer

    def group(names: Sequence[str]) -> list[_History]:
        at = {name: f"{what}.{name}.position" for name in names}
        measured = {name: f"{what}.{name}.{rate}" for name in names}
        both = [n for n in names if recording.has(at[n], measured[n]) and tachometer]
        derived = [n for n in names if n in both or not recording.has(measured[n])]
        every = bool(both) or not all(settings.knows(_share(at[n])) for n in derived)
        angles = _smoothed(
            recording, [at[n] for n in derived], noise, late, settings, every
        )
        read = _smoothed(
            recording, [measured[n] for n in both], tachometer, late, settings, every
        )

        def one(name: str) -> _History:
            angle = angles.get(at[name])
            if angle is None:
                q = [at[name]] if recording.has(at[name]) else []
                q = [_at(recording, column, late) for column in q]
                if tachometer and not q:
                    return _read_alone(
                        recording, measured[name], tachometer, late, settings, shows
                    )
                qd, noise = _at(recording, measured[name], late), NO_NOISE
                if not q:
                    column = recording.columns[measured[name]]
                    shown = partial(RateNoise.undeclared, column)
                    noise = settings.once(f"noise of {measured[name]}", shown)
                return _History(q, qd, np.nan, (0.0, 0.0), Origin.MEASURED, noise)
            share = settings.once(_share(at[name]), partial(_share_of, angle))
            qd, origin = angle.rate[:, 0], Origin.SMOOTHED_POSITIONS
            if name in both:
                qd = _combined(angle, read[measured[name]])
                origin = Origin.SMOOTHED_POSITIONS_AND_RATES
            return _History([angle.x[:, 0]], qd, share, _worst(angle), origin)

        return [one(name) for name in names]

    groups = [names[k : k + AT_ONCE] for k in range(0, len(names), AT_ONCE)]
    # One group alone has all threads of the core, and starts none for itself.
    each = side_by_side if len(groups) > 1 else map
    every = [*chain.from_iterable(each(group, groups))]
    return Histories(
        tuple(q for each in every for q in each.positions),
        tuple(each.rate for each in every),
        reduce(or_, (each.origin for each in every), Origin(0)),
        tuple(each.share for each in every),
        tuple(each.worst for each in every),
        tuple(each.noise for each in every),
    )


class _History(NamedTuple):
    """That of one joint or wheel."""

    positions: list[Float[np.ndarray, " samples"]]
    """One, or none where it is not recorded."""
    rate: Float[np.ndarray, " samples"]
    share: float
    worst: tuple[float, float]
    origin: Origin
    noise: RateNoise = NO_NOISE


def _read_alone(
    recording: Recording,
    name: str,
    std: float,
    late: float,
    settings: Settings,
    shows: float,
) -> _History:
    """The rate by a tachometer with noise of this deviation, rad/s."""
    t, column = recording.t, recording.columns[name]
    noise = RateNoise.read(std, t, int(np.isfinite(column).sum()), shows)
    if noise.density and settings.whole:
        rate = _smoothed(recording, [name], std, late, settings, False)[name].x[:, 0]
        (fit,) = settings.smoothers(name, list)
        if fit.reach * waves_of_noise(t.size) >= IN_WAVES * (t[-1] - t[0]):
            noise = noise._replace(white=0.0)
            return _History([], rate, np.nan, (0.0, 0.0), Origin.SMOOTHED_RATES, noise)
    rate = _at(recording, name, late)
    return _History([], rate, np.nan, (0.0, 0.0), Origin.MEASURED, noise)


def _combined(
    angle: Smoothed | Rates, rate: Smoothed | Rates
) -> Float[np.ndarray, " samples"]:
    """The rate by the angle and by the tachometer, weighted by their variances."""
    assert isinstance(angle, Smoothed)
    assert isinstance(rate, Smoothed)
    by_angle, by_rate = (
        np.maximum(std[:, 0], LEAST) ** -2.0 for std in (angle.std_rate, rate.std_x)
    )
    total = by_angle * angle.rate[:, 0] + by_rate * rate.x[:, 0]
    return total / (by_angle + by_rate)


def _smoothed(
    recording: Recording,
    names: Sequence[str],
    noise: float | None,
    late: float,
    settings: Settings,
    every: bool,
) -> dict[str, Smoothed | Rates]:
    """Each of these columns, by its name; with deviations where `every`."""
    if not names:
        return {}
    t, x = recording.t, np.empty((recording.t.size, len(names)))
    fits: list[Roughness] = []
    for k, name in enumerate(names):
        label, column = f"{recording.source}: column '{name}'", recording.columns[name]
        x[:, k] = column
        find = partial(fits_of, t, x[:, k : k + 1], noise, label)
        fits += settings.smoothers(name, find)
    at, source = t + late, recording.source
    found = (
        smooth(t, x, noise, at, source, fits)
        if every
        else smooth_rates(t, x, at, source, fits)
    )
    return {
        name: type(found)(*(part[..., k : k + 1] for part in found))
        for k, name in enumerate(names)
    }


def _share(column: str) -> str:
    return f"share of {column}"


def _share_of(angle: Smoothed | Rates) -> float:
    """Variance of a smoothed position over that of a sample.

    NaN where 4 samples do not tell their noise, or the clock is off by all of them.
    """
    assert isinstance(angle, Smoothed)
    std = angle.std_x[~np.isnan(angle.std_x)]
    return float((np.median(std) / angle.noise_std[0]) ** 2) if std.size else np.nan


def _worst(angle: Smoothed | Rates) -> tuple[float, float]:
    if isinstance(angle, Rates):
        return 0.0, 0.0
    x, rate = (np.nanmax(std, initial=0.0) for std in (angle.std_x, angle.std_rate))
    return float(x), float(rate)


def _at(recording: Recording, name: str, late: float) -> Float[np.ndarray, " samples"]:
    t, column = recording.t, recording.columns[name]
    label = f"{recording.source}: column '{name}'"
    if late:
        return at_times(t, column, t + late, label)
    return fill(t, column, label) if np.isnan(column).any() else column


LOCKED = 1e-3
"""A joint that moved less (rad or m) did not move: encoders are finer than that."""

UNSEEN = 0.1
"""Part of the noise of a sample of the gyro: what turns the base more slowly all the
time would take ten thousand samples to be seen."""


class Range(NamedTuple):
    """The finite samples of some columns."""

    low: Float[np.ndarray, " columns"]
    """Infinite where there is none."""
    high: Float[np.ndarray, " columns"]
    samples: Float[np.ndarray, " columns"]
    total: Float[np.ndarray, " columns"]

    @classmethod
    def of(cls, columns: Sequence[Float[np.ndarray, " samples"]]) -> "Range":
        """Those of these columns."""
        found = np.empty((4, len(columns)))
        for k, column in enumerate(columns):
            x = column[np.isfinite(column)]
            low, high = x.min(initial=np.inf), x.max(initial=-np.inf)
            found[:, k] = low, high, x.size, x.sum()
        return cls(*found)

    def and_of(self, other: "Range") -> "Range":
        """Those of both."""
        return Range(
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
            self.samples + other.samples,
            self.total + other.total,
        )

    def ends(self, k: int) -> list[float] | None:
        """The least and the largest value of column `k`; None without a sample."""
        return [float(self.low[k]), float(self.high[k])] if self.samples[k] else None


def held_joints(robot: Robot, q: Range, qd: Range, dt: float) -> dict[str, float]:
    """The joints that did not move, and where they are held, rad or m.

    A controller that holds a joint lets it tremble. That is no motion where, with the
    nominal inertia, the base turns so little by it that the gyro does not see it.

    Args:
        robot: with its nominal inertia, and the gyro's noise, where that is known.
        q: of all joints, rad or m.
        qd: of all joints, rad/s or m/s.
        dt: from one sample of the gyro to the next, s.
    """
    still = q.high - q.low < LOCKED
    if not still.all():
        still |= _trembling(robot, q, qd, dt)
    # Of a joint without any sample nothing is known.
    still &= q.samples > 0
    return {
        name: float(q.total[k] / q.samples[k])
        for k, name in enumerate(robot.joint_names)
        if still[k]
    }


def _trembling(
    robot: Robot, q: Range, qd: Range, dt: float
) -> Bool[np.ndarray, " joints"]:
    """Revolute joints alone: a sliding one may move S without a turn."""
    turning = np.array([joint.kind == "revolute" for joint in robot.joints])
    noise = robot.sensors.of("gyro").white_std(dt)
    at = inertia_at(robot, (q.low + q.high) / 2)
    axes = list(robot.conserved_axes[0])
    # h = D w + D_q qd stays: w = -D^-1 D_q qd (Eq. 3).
    turns = np.linalg.solve(at.D[np.ix_(axes, axes)], at.D_q[axes])
    fastest = np.maximum(qd.high, -qd.low)
    return turning & (np.linalg.norm(turns, axis=0) * fastest < UNSEEN * noise)
