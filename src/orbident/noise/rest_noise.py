"""What a recording at rest tells of the noise of its sensors, and whether it is one.

Motion is smooth, and no noise explains it. Gauss-Markov processes and random walks
explain much that lasts, motion too, but not that it goes on: slow motion is a
polynomial in time, and faster motion leaves innovations that are not white.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool
from scipy.spatial.transform import Rotation
from scipy.special import chdtri

from orbident import _core
from orbident.data_table import DataTable, Numeric, table_of
from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.levels import LOW, low_frequencies
from orbident.estimation.signals import SIGNAL_UNITS
from orbident.noise.noise_model import (
    FEWEST,
    MARKOV,
    PARTS,
    WALK,
    NoiseModel,
    Samples,
    best_model,
)
from orbident.recordings.columns import part_of
from orbident.recordings.recording import Recording
from orbident.robot.sensor_schema import (
    FLICKER_FLOOR,
    MARKOV_PEAK,
    UNDECLARED,
    InertialSpec,
)

OUTLYING = 6.0
"""Deviations: noise is beyond them once in half a thousand million samples."""

ROUNDING = 1e-14
"""Relative; of double precision, some operations on."""

ROUNDS = 4
"""Rounds that leave out outlying samples: after a jump there is always another."""


def clean_model(
    where: str, t: Samples, y: Samples, parts: Sequence[tuple[str, ...]]
) -> tuple[NoiseModel, Bool[np.ndarray, " n"]]:
    """As `best_model`, without the samples that it does not explain; which are kept.

    The recording and the axis, `where`, are for the message.

    Raises:
        InputError: there is always a further sample that is not explained.
    """
    kept = np.ones(t.size, dtype=bool)
    model = best_model(t, y, parts)
    for _ in range(ROUNDS):
        outlying = np.abs(model.innovations) > OUTLYING
        if not outlying.any():
            return model, kept
        kept[np.flatnonzero(kept)[outlying]] = False
        if not varies(y[kept]):
            break
        model = best_model(t[kept], y[kept], parts)
    raise InputError(
        f"{where} jumps: again and again there are samples beyond {OUTLYING:g} "
        "deviations of all that is left; give a recording at rest"
    )


def varies(x: Samples) -> bool:
    """Whether samples differ by more than rounding, of rotations too."""
    return bool(np.ptp(x) > ROUNDING * max(1.0, float(np.abs(x).max())))


DEGREE = 5
"""Degree of the polynomial with which slow motion is looked for."""

CHANCE = 1e-6
"""Probability that the noise of one axis looks like slow motion."""

POWER = 2.0
"""Most power of innovations at rest, at the lowest twentieth of all frequencies, over
white noise: a real motion capture system at rest on its table, which shakes, has 1.5;
flights have 4 to 20."""

MOVED = 5e-3
"""rad or m: the play and the counts of a joint that is held are less."""


def check_joints(recording: Recording) -> None:
    """Refuse a recording in which a joint moves.

    Raises:
        InputError: so.
    """
    for name, values in recording.columns.items():
        if part_of("joint", name) is None or not name.endswith(".position"):
            continue
        seen = values[np.isfinite(values)]
        if seen.size and np.ptp(seen) > MOVED:
            raise InputError(
                f"{recording.source}: {name} moves by {np.ptp(seen):.3g} (rad or m), "
                f"and at rest it would by {MOVED:g} at most; give a recording at rest"
            )


def check_still(where: str, t: Samples, x: Samples, model: NoiseModel) -> None:
    """Refuse samples that move.

    Args:
        where: the recording and the axis, for the message.
        t: of the samples, s.
        x: the samples.
        model: their most likely noise.

    Raises:
        InputError: so.
    """
    found, limit = drift(t, x, model), float(chdtri(DEGREE, CHANCE))
    if found > limit:
        raise InputError(
            f"{where} moves: a polynomial in time lowers chi-square by {found:.3g}, "
            f"where noise does by less than {limit:.3g}; give a recording at rest"
        )
    power = low_power(model)
    if power > POWER:
        raise InputError(
            f"{where} moves: what no noise model predicts has {power:.3g} times the "
            f"power of white noise at low frequencies, where rest has less than "
            f"{POWER:g}; give a recording at rest"
        )


def drift(t: Samples, x: Samples, model: NoiseModel) -> float:
    """How much a polynomial lowers chi-square; at rest this is chi-square distributed.

    A straight line alone lowers it by the square of the slope over its deviation.
    """
    at = 2 * (t - t[0]) / (t[-1] - t[0]) - 1
    rows = np.column_stack([np.polynomial.legendre.legvander(at, DEGREE), x])
    coloured = np.array([*(model.value(name) for name in MARKOV + WALK), 0.0])
    variance = np.full(t.size, model.value("white") ** 2)
    innovations, S = _core.innovations(t, rows, variance, coloured)
    white = innovations / np.sqrt(S)[:, None]
    # Below the constant's row, the last column is what each polynomial explains.
    R = np.asarray(np.linalg.qr(white, mode="r"))
    return float(np.sum(R[1:-1, -1] ** 2))


def low_power(model: NoiseModel) -> float:
    """Power of the innovations at low frequencies, over that at all."""
    power = np.abs(np.fft.rfft(model.innovations)[1:]) ** 2
    low = max(int(LOW * power.size), 1)
    return float(np.mean(power[:low]) / np.mean(power))


SENSORS = ("gyro", "accelerometer", "attitude", "position")
"""Those that show noise at rest."""


@dataclass(frozen=True)
class AxisNoise:
    """One axis of one sensor at rest."""

    sensor: str
    axis: str
    t: Samples
    """s."""
    samples: Samples
    """About their mean; of an attitude, small rotations about an axis of the base."""
    model: NoiseModel
    left_out: int
    """Samples beyond six deviations: spikes."""

    @property
    def name(self) -> str:
        """Such as `position.x`."""
        return f"{self.sensor}.{self.axis}"

    @property
    def check(self) -> Check:
        """Whether the model explains the samples: its innovations are white."""
        found = low_frequencies(self.model.innovations[:, None], 1.0)
        if found is None or found.ratio <= found.limit:
            return Check("noise", "trust", f"{self.name}: its model explains it")
        reason = (
            f"{self.name}: at low frequencies it has {found.ratio:.2g} times the power "
            f"of the model's noise, and more than {found.limit:.2g} is no chance"
        )
        remedy = "see the Allan deviation: does something vibrate or sway?"
        return Check("noise", "with care", reason, remedy, *found)

    def unit(self, parameter: str) -> str:
        """The unit of a parameter of the model."""
        unit = SIGNAL_UNITS[self.sensor]
        if parameter == "correlation_time":
            return "s"
        return f"{unit}/sqrt(s)" if parameter == "random_walk" else unit


def rest_noise(recording: Recording) -> tuple[AxisNoise, ...]:
    """Learn the noise of gyro, accelerometer, attitude and position.

    An axis that always shows the same is left out: on a table there are such.

    Raises:
        InputError: the recording has none of these sensors, too few samples of one,
            or something moves in it.
    """
    check_joints(recording)
    found = [
        _axis_noise(recording, sensor, axis, t, x)
        for sensor in SENSORS
        if recording.has_vector(sensor)
        for axis, t, x in _axes(recording, sensor)
    ]
    if not found:
        raise InputError(
            f"{recording.source}: found no samples that vary of gyro, accelerometer, "
            "attitude or position; give the columns of one of them, such as "
            "position.x, position.y and position.z"
        )
    return tuple(found)


def _axes(recording: Recording, sensor: str) -> Iterator[tuple[str, Samples, Samples]]:
    table = recording.vector(sensor)
    seen = np.isfinite(table).all(axis=1)
    t, table = recording.t[seen], table[seen]
    if not len(table):
        return
    if sensor == "attitude":
        attitudes = Rotation.from_quat(table)
        table = (attitudes.mean().inv() * attitudes).as_rotvec()
    for axis, x in zip("xyz", table.T, strict=True):
        if not varies(x):
            continue
        if x.size < FEWEST:
            raise InputError(
                f"{recording.source}: {sensor}.{axis} has {x.size} samples; give at "
                f"least {FEWEST}: with less its kinds of noise cannot be distinguished"
            )
        yield axis, t, x - x.mean()


def _axis_noise(
    recording: Recording, sensor: str, axis: str, t: Samples, x: Samples
) -> AxisNoise:
    """The bias of a gyro or an accelerometer is a Gauss-Markov process alone."""
    where = f"{recording.source}: {sensor}.{axis}"
    inertial = isinstance(UNDECLARED[sensor], InertialSpec)
    model, kept = clean_model(where, t, x, ((), MARKOV) if inertial else PARTS)
    check_still(where, t[kept], x[kept], model)
    return AxisNoise(sensor, axis, t[kept], x[kept], model, int(np.sum(~kept)))


def sensor_section(found: tuple[AxisNoise, ...]) -> dict[str, dict[str, Any]]:
    """The `sensors` section of a robot file, SI, three digits.

    White noise is the root mean square of a sensor's axes, which share it in a robot
    file. So do a gyro's axes their bias instability; its correlation time is the
    geometric mean.
    """
    section: dict[str, dict[str, Any]] = {}
    for sensor in SENSORS:
        axes = {each.axis: each for each in found if each.sensor == sensor}
        if axes:
            kind = type(UNDECLARED[sensor])
            white = kind.model_fields["white_noise"].alias or ""
            make = _inertial if issubclass(kind, InertialSpec) else _tracker
            section[sensor] = make(white, axes)
    return section


def _inertial(white: str, axes: Mapping[str, AxisNoise]) -> dict[str, Any]:
    models = [each.model for each in axes.values()]
    dt = float(np.median(np.diff(next(iter(axes.values())).t)))
    section = {white: digits(_rms(models, "white") * np.sqrt(dt))}
    wandering = [model for model in models if "markov_std" in model.levels]
    if wandering:
        s = _rms(models, "markov_std")
        times = [model.value("correlation_time") for model in wandering]
        # sensor_schema.py has s of B; this is B of s.
        section["bias_instability"] = digits(s * MARKOV_PEAK / FLICKER_FLOOR)
        section["correlation_time"] = digits(np.exp(np.mean(np.log(times))))
    return section


def _tracker(white: str, axes: Mapping[str, AxisNoise]) -> dict[str, Any]:
    models = [each.model for each in axes.values()]
    section: dict[str, Any] = {white: digits(_rms(models, "white"))}
    for name, absent in (
        ("markov_std", 0.0),
        ("correlation_time", 1.0),
        ("random_walk", 0.0),
    ):
        if any(name in model.levels for model in models):
            section[name] = [
                digits(axes[k].model.value(name))
                if k in axes and name in axes[k].model.levels
                else absent
                for k in "xyz"
            ]
    return section


def _rms(models: list[NoiseModel], name: str) -> float:
    return float(np.sqrt(np.mean([model.value(name) ** 2 for model in models])))


def digits(value: float) -> float:
    """Three digits: no noise is known better."""
    return float(f"{value:.3g}")


def noise_table(found: Sequence[AxisNoise]) -> DataTable:
    """Every parameter of every axis, with its 95 % interval."""
    rows = (
        (each.name, name, *map(Numeric, numbers), each.unit(name))
        for each in found
        for name, level in each.model.levels.items()
        for numbers in ((level.value, level.std, *level.interval),)
    )
    head = ("axis", "parameter", "value", "std", "95 % from", "to", "unit")
    return table_of("", head, rows)
