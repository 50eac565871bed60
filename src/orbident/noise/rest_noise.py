"""What a recording at rest tells of the noise of its sensors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.data_table import DataTable, Numeric, table_of
from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.output_error.sensors import COMPONENTS
from orbident.estimation.whiteness import low_frequencies
from orbident.noise.noise_model import (
    FEWEST,
    MARKOV,
    PARTS,
    NoiseModel,
)
from orbident.noise.spikes import OUTLYING, clean_model, varies
from orbident.noise.stillness import check_joints, check_still
from orbident.recordings.recording import Recording
from orbident.robot.sensor_schema import (
    FLICKER_FLOOR,
    MARKOV_PEAK,
    UNDECLARED,
    InertialSpec,
)

UNITS = {
    "gyro": "rad/s",
    "accelerometer": "m/s^2",
    "attitude": "rad",
    "position": "m",
}


@dataclass(frozen=True)
class AxisNoise:
    """One axis of one sensor at rest."""

    sensor: str
    axis: str
    t: Float[np.ndarray, " n"]
    """s."""
    samples: Float[np.ndarray, " n"]
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
        unit = UNITS[self.sensor]
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
        for sensor in UNITS
        if recording.has(*(f"{sensor}.{k}" for k in COMPONENTS[sensor]))
        for axis, t, x in _axes(recording, sensor)
    ]
    if not found:
        raise InputError(
            f"{recording.source}: found no samples that vary of gyro, accelerometer, "
            "attitude or position; give the columns of one of them, such as "
            "position.x, position.y and position.z"
        )
    return tuple(found)


def _axes(
    recording: Recording, sensor: str
) -> Iterator[tuple[str, Float[np.ndarray, " n"], Float[np.ndarray, " n"]]]:
    table = recording.vector(sensor, COMPONENTS[sensor])
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
    recording: Recording,
    sensor: str,
    axis: str,
    t: Float[np.ndarray, " n"],
    x: Float[np.ndarray, " n"],
) -> AxisNoise:
    """The bias of a gyro or an accelerometer is a Gauss-Markov process alone."""
    where = f"{recording.source}: {sensor}.{axis}"
    inertial = isinstance(UNDECLARED[sensor], InertialSpec)
    model, kept, settled = clean_model(t, x, ((), MARKOV) if inertial else PARTS)
    if not settled:
        raise InputError(
            f"{where} jumps: again and again there are samples beyond {OUTLYING:g} "
            "deviations of all that is left; give a recording at rest"
        )
    check_still(where, t[kept], x[kept], model)
    return AxisNoise(sensor, axis, t[kept], x[kept], model, int(np.sum(~kept)))


def sensor_section(found: tuple[AxisNoise, ...]) -> dict[str, dict[str, Any]]:
    """The `sensors` section of a robot file, SI, three digits.

    White noise is the root mean square of a sensor's axes, which share it in a robot
    file. So do a gyro's axes their bias instability; its correlation time is the
    geometric mean.
    """
    section: dict[str, dict[str, Any]] = {}
    for sensor in UNITS:
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
        part = "markov_std" if name == "correlation_time" else name
        if any(part in model.levels for model in models):
            section[name] = [
                digits(axes[k].model.value(name))
                if k in axes and part in axes[k].model.levels
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
