"""The sensors of a robot: what its file says of them, and how large their noise is."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
import yaml
from jaxtyping import Float
from pydantic import BeforeValidator, Field, field_validator, model_validator

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.schema_parts import (
    MappingSchema,
    Vector3,
    WrongValueError,
    finite_number,
    validated,
)
from orbident.robot.units import (
    TORQUE_OF_A_JOINT,
    Angle,
    Lasting,
    Length,
    Rate,
    Time,
    each_of,
    measure_of,
    per_axis,
)

SUITES: Mapping[str, Mapping[str, Any]] = yaml.safe_load(
    Path(__file__).with_name("sensor_suites.yaml").read_text("utf-8")
)
"""Ready-made sensors by the names of their suites, as a robot file would have them."""


class Coloured(NamedTuple):
    """The parts of noise that are not white, by axis; zero where there are none.

    The errors of motion capture's cameras and of the markers that they see last. Each
    axis has two processes of its own, and all are independent. A first-order
    Gauss-Markov process has a standard deviation `s` and a correlation time `T`:

        cov(x(t), x(t + tau)) = s^2 exp(-|tau| / T)

    A random walk has a density `q`, and is zero at the first sample:

        var(x(t)) = q^2 t
    """

    markov_std: Float[np.ndarray, "3"]
    """`s`, m or rad."""
    correlation_time: Float[np.ndarray, "3"]
    """`T`, s; 1 where there is no such part."""
    random_walk: Float[np.ndarray, "3"]
    """`q`, m/sqrt(s) or rad/sqrt(s)."""

    @property
    def absent(self) -> bool:
        """Whether the noise is white."""
        return not (self.markov_std.any() or self.random_walk.any())


WHITE = Coloured(np.zeros(3), np.ones(3), np.zeros(3))
"""Nothing lasts."""

Axes = tuple[float, float, float]


def _probability(value: object) -> float:
    number = finite_number(value)
    if not 0 <= number <= 1:
        raise WrongValueError("give a probability, from 0 to 1")
    return number


class Sampled(MappingSchema):
    """What any sensor may say of its samples; by itself, that no noise is declared."""

    NOISES: ClassVar[tuple[str, ...]] = ()
    """The fields that are sizes of noise."""

    rate: Rate | None = None
    latency: Time | None = None
    drop_out: Annotated[float, BeforeValidator(_probability)] | None = None

    def white_std(self, dt: float = 1.0) -> float:
        """Standard deviation of the white noise of a sample; SI, zero if not declared.

        One sample comes `dt` after the other, s.
        """
        return getattr(self, "white_noise", 0.0)

    @property
    def bias_walk(self) -> float:
        """The random walk of a bias, in the bias's unit per square root of a second."""
        return 0.0

    @property
    def coloured(self) -> Coloured:
        """What lasts of the noise."""
        return WHITE

    def ideal(self) -> "Sampled":
        """A sensor that samples as often, without noise, errors or delay."""
        return self.model_construct(rate=self.rate, white_noise=0.0)

    def louder(self, times: float) -> "Sampled":
        """The same sensor with all of its noise so many times as large."""
        sizes = {name: getattr(self, name) for name in self.NOISES}
        return self.model_copy(
            update={
                name: tuple(times * each for each in size)
                if isinstance(size, tuple)
                else times * size
                for name, size in sizes.items()
                if size is not None
            }
        )


CORRELATION_TIME = 3600.0
"""s. Data sheets give none; an hour is usual for tactical-grade units, and makes the
bias of a record of minutes all but constant, as the paper's own error analysis has it.
"""

FLICKER_FLOOR = math.sqrt(2 * math.log(2) / math.pi)
"""Allan deviation of flicker noise over its coefficient B: 0.664."""

MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a first-order Gauss-Markov process over its std."""


class InertialSpec(Sampled):
    """What gyros and accelerometers share.

    A data sheet's bias instability `B` is the coefficient of flicker noise, whose Allan
    deviation is flat, `sqrt(2 ln 2 / pi) B = 0.664 B` (IEEE Std 952, C.1.3). Flicker
    noise has no finite-dimensional model. A first-order Gauss-Markov process (C.1.5)
    with standard deviation `s` and correlation time `T` has an Allan deviation that
    peaks at `0.617 s`; with the same peak, `s = 0.664 B / 0.617 = 1.076 B`. For times
    short beside `T` its increments have the variance
    `2 s^2 (1 - exp(-dt/T)) = (2 s^2 / T) dt`: it is a random walk of `s sqrt(2 / T)`
    per square root of a second.
    """

    NOISES = ("white_noise", "bias_instability", "turn_on_bias")
    UNKNOWN_BIAS: ClassVar[float]
    """Std of a bias of which nothing is declared: more than any sensor's."""

    correlation_time: Lasting | None = None
    scale: Vector3 | None = None
    misalignment: Annotated[Axes, each_of("angle")] | None = None
    white_noise: float
    """`N`: std of the integrated white noise after one second."""
    bias_instability: float
    """`B`: the floor of the Allan deviation over 0.664."""
    turn_on_bias: float | None
    constant_bias: Axes | None

    def white_std(self, dt: float = 1.0) -> float:
        """Std of the white noise of a sample, the mean over the `dt` s before it.

        The integral of the noise over `dt` has std `N sqrt(dt)`, so its mean has
        `N / sqrt(dt)` (IEEE Std 952, C.1.1: `S(f) = N^2`).
        """
        return self.white_noise / dt**0.5

    @property
    def drift_time(self) -> float:
        """Correlation time of the bias's drift, s; infinite for a bias that stays."""
        T = self.correlation_time
        return CORRELATION_TIME if T is None else T

    @property
    def drift_std(self) -> float:
        """Std of the Gauss-Markov process with flicker's floor, in the unit of `B`."""
        return FLICKER_FLOOR / MARKOV_PEAK * self.bias_instability

    @property
    def bias_walk(self) -> float:
        """The random walk of the bias, in its unit per square root of a second."""
        return self.drift_std * math.sqrt(2 / self.drift_time)

    @property
    def turn_on_std(self) -> float:
        """Std of the bias at the first sample, before it is estimated.

        The bias instability says how the bias wanders, not how large it is at turn-on.
        """
        std = self.turn_on_bias
        return self.UNKNOWN_BIAS if std is None else std


class GyroSpec(InertialSpec):
    """Angular rate of the base, base axes, rad/s."""

    UNKNOWN_BIAS = 0.1

    white_noise: Annotated[float, measure_of("angle random walk")] = Field(
        default=0.0, alias="angle_random_walk"
    )
    bias_instability: Annotated[float, measure_of("angular rate")] = 0.0
    turn_on_bias: Annotated[float, measure_of("angular rate")] | None = None
    constant_bias: Annotated[Axes, each_of("angular rate")] | None = None


class AccelerometerSpec(InertialSpec):
    """Specific force at S, base axes, m/s^2; in free fall that is S's acceleration."""

    UNKNOWN_BIAS = 1.0

    white_noise: Annotated[float, measure_of("velocity random walk")] = Field(
        default=0.0, alias="velocity_random_walk"
    )
    bias_instability: Annotated[float, measure_of("acceleration")] = 0.0
    turn_on_bias: Annotated[float, measure_of("acceleration")] | None = None
    constant_bias: Annotated[Axes, each_of("acceleration")] | None = None
    increments: bool | None = None


class EncoderSpec(Sampled):
    """An angle (or, of a prismatic joint, a length), its rate, or both."""

    NOISES = ("white_noise", "tachometer")

    white_noise: Angle | None = Field(default=None, alias="position")
    """Std of the angle's noise, rad or m; None where only the rate is read."""
    resolution: Angle | None = None
    """One count, rad or m."""
    tachometer: Annotated[float, measure_of("angular rate")] | None = None
    """Std of the rate's noise, rad/s or m/s; None where no rate is read."""

    @model_validator(mode="after")
    def _something(self) -> "EncoderSpec":
        if self.white_noise is None and self.tachometer is None:
            raise WrongValueError("give position, tachometer or both")
        return self

    def white_std(self, dt: float = 1.0) -> float:
        """That of an angle: its noise, and that of counts, `resolution / sqrt(12)`."""
        count = (self.resolution or 0.0) / math.sqrt(12)
        return math.hypot(self.white_noise or 0.0, count)

    @property
    def unseen_std(self) -> float | None:
        """The noise of angles that samples do not show, as with counts; else None."""
        return self.white_std() if self.resolution else None


class TrackerSpec(Sampled):
    """Pose from outside, with noise that is not white."""

    NOISES = ("white_noise", "markov_std", "random_walk")

    correlation_time: Annotated[Axes, per_axis("time", above_zero=True)] | None = None
    white_noise: float
    """Of a sample, about or along each axis, rad or m."""
    markov_std: Axes | None
    random_walk: Axes | None

    @model_validator(mode="after")
    def _complete(self) -> "TrackerSpec":
        std = self.markov_std
        if std is not None and any(std) and self.correlation_time is None:
            raise WrongValueError("markov_std needs a correlation_time beside it")
        if self.correlation_time is not None and std is None:
            raise WrongValueError("correlation_time needs a markov_std beside it")
        return self

    @property
    def coloured(self) -> Coloured:
        """What lasts of the noise, by axis."""
        std, time, walk = (
            np.array(each or (0.0, 0.0, 0.0))
            for each in (self.markov_std, self.correlation_time, self.random_walk)
        )
        return Coloured(std, np.where(std > 0, time, 1.0), walk)


class AttitudeSpec(TrackerSpec):
    """Orientation of the base: a star tracker or motion capture; SI."""

    white_noise: Angle = Field(alias="angle")
    markov_std: Annotated[Axes, per_axis("angle")] | None = None
    random_walk: Annotated[Axes, per_axis("angle random walk")] | None = None


class PositionSpec(TrackerSpec):
    """Position of S: motion capture or vision; SI."""

    white_noise: Length = Field(alias="std")
    markov_std: Annotated[Axes, per_axis("length")] | None = None
    random_walk: Annotated[Axes, per_axis("length random walk")] | None = None


class TorqueSpec(Sampled):
    """Torques between each joint's two bodies, N m, or N of a joint that slides."""

    NOISES = ("white_noise",)

    white_noise: Annotated[float, measure_of(TORQUE_OF_A_JOINT)] = Field(alias="std")


OfJoints = EncoderSpec | TorqueSpec
"""Sensors of which each joint has one."""

AnySensor = GyroSpec | AccelerometerSpec | OfJoints | AttitudeSpec | PositionSpec
"""A sensor of which something is declared."""

UNDECLARED: dict[str, AnySensor] = {
    "gyro": GyroSpec(),
    "accelerometer": AccelerometerSpec(),
    "joints": EncoderSpec(position=0.0),
    "attitude": AttitudeSpec(angle=0.0),
    "position": PositionSpec(std=0.0),
    "wheels": EncoderSpec(position=0.0),
    "torques": TorqueSpec(std=0.0),
}
"""Sensors of which a robot file says nothing: no noise is no noise that is known."""


class SensorsSpec(MappingSchema, validate_default=True):
    """What is measured, how often and how well, SI; absent is not measured."""

    suites: tuple[str, ...] = ()
    """Ready-made sensors; a sensor that the file gives itself stands instead."""
    rate: Rate | None = None
    """Rows of a recording in a second."""
    gyro: GyroSpec | None = None
    accelerometer: AccelerometerSpec | None = None
    joints: EncoderSpec | None = None
    attitude: AttitudeSpec | None = None
    position: PositionSpec | None = None
    wheels: EncoderSpec | None = None
    torques: TorqueSpec | None = None

    @field_validator("suites")
    @classmethod
    def _known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in SUITES:
                known = suggestion(name, SUITES, "sensor suites")
                raise InputError(f"sensor suite {name!r}: {known}")
        return names

    @field_validator("*", mode="before")
    @classmethod
    def _ready_made(cls, given: Any, info: Any) -> Any:
        """That of the last suite that has it, where the file gives none of its own."""
        if given is None:
            for name in info.data.get("suites", ()):
                given = SUITES[name].get(info.field_name, given)
        return given

    @property
    def rows_per_second(self) -> float:
        """The rate of a recording, Hz: the paper's where the file says nothing."""
        return self.rate or 20.0

    @property
    def declared(self) -> dict[str, AnySensor]:
        """The sensors that are there, by their names in a robot file."""
        return {name: each for name, each in self if isinstance(each, AnySensor)}

    @property
    def of_base(self) -> dict[str, AnySensor]:
        """Those of the motion of the base: no encoders, and no torques."""
        declared = self.declared.items()
        return {name: x for name, x in declared if not isinstance(x, OfJoints)}

    def of(self, name: str) -> Sampled:
        """What is said of a sensor, even where that is nothing."""
        return self.declared.get(name, UNDECLARED.get(name, Sampled()))


def declared_sensors(section: Mapping[str, Any]) -> SensorsSpec:
    """The sensors of a section that is written as in a robot file.

    Raises:
        InputError: it has an unknown key, lacks one, or a value is wrong.
    """
    return validated(SensorsSpec, dict(section), "sensors")
