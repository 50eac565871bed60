"""The sensor section of a robot file as pydantic models."""

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, field_validator, model_validator

from orbident.files.bounds import SMALLEST
from orbident.files.schema_parts import (
    MappingSchema,
    Vector3,
    WrongValueError,
    finite_number,
    finite_vector,
)
from orbident.robot.sensor_suites import sensor_suite
from orbident.robot.units import quantity


def at_least_zero(value: object, dimension: str) -> float:
    """A quantity of zero or more, in SI.

    Raises:
        WrongValueError: it is negative, too small, or of another dimension.
    """
    number = quantity(value, dimension)
    if number < 0:
        raise WrongValueError("give zero or more")
    if number and number < SMALLEST:
        raise WrongValueError(f"give zero, or at least {SMALLEST:g} in SI units")
    return number


def measure_of(dimension: str) -> BeforeValidator:
    """Reads a quantity of zero or more, in SI."""
    return BeforeValidator(lambda value: at_least_zero(value, dimension))


def each_of(dimension: str, length: int = 3) -> BeforeValidator:
    """Reads so many numbers of a dimension, in SI."""

    def in_si(value: object) -> tuple[float, ...]:
        if not isinstance(value, list | tuple):
            raise WrongValueError(f"give a {length}-vector")
        return finite_vector([quantity(each, dimension) for each in value], length)

    return BeforeValidator(in_si)


def _per_axis(dimension: str, *, above_zero: bool = False) -> BeforeValidator:
    """One quantity for all axes, or one for each, in SI."""

    def one(value: object) -> float:
        number = at_least_zero(value, dimension)
        if above_zero and not number:
            raise WrongValueError(f"give a {dimension} above zero")
        return number

    def in_si(value: object) -> tuple[float, ...]:
        if not isinstance(value, list | tuple):
            return 3 * (one(value),)
        if len(value) != 3:
            raise WrongValueError("give one number, or one for each of x, y, z")
        return tuple(one(each) for each in value)

    return BeforeValidator(in_si)


def _rate(value: object) -> float:
    number = quantity(value, "frequency")
    if number < SMALLEST:
        raise WrongValueError("give a rate above zero")
    return number


def _lasting(value: object) -> float:
    """A time above zero; infinite for what never changes."""
    if value == math.inf:
        return math.inf
    number = quantity(value, "time")
    if number < SMALLEST:
        raise WrongValueError("give a time above zero, or .inf")
    return number


def _probability(value: object) -> float:
    number = finite_number(value)
    if not 0 <= number <= 1:
        raise WrongValueError("give a probability, from 0 to 1")
    return number


Rate = Annotated[float, BeforeValidator(_rate)]
Lasting = Annotated[float, BeforeValidator(_lasting)]
Time = Annotated[float, measure_of("time")]
Angle = Annotated[float, measure_of("angle")]
Length = Annotated[float, measure_of("length")]
Share = Annotated[float, measure_of("share")]


class Sampled(MappingSchema):
    """What every sensor may say of its samples."""

    rate: Rate | None = None
    latency: Time | None = None
    drop_out: Annotated[float, BeforeValidator(_probability)] | None = None


class Inertial(Sampled):
    """What gyros and accelerometers share."""

    correlation_time: Lasting | None = None
    scale: Vector3 | None = None
    misalignment: Annotated[tuple[float, float, float], each_of("angle")] | None = None


class GyroSpec(Inertial):
    """Noise of the base's angular rate."""

    angle_random_walk: Annotated[float, measure_of("angle random walk")] = 0.0
    bias_instability: Annotated[float, measure_of("angular rate")] = 0.0
    turn_on_bias: Annotated[float, measure_of("angular rate")] | None = None
    constant_bias: (
        Annotated[tuple[float, float, float], each_of("angular rate")] | None
    ) = None


class AccelerometerSpec(Inertial):
    """Noise of the specific force at S."""

    velocity_random_walk: Annotated[float, measure_of("velocity random walk")] = 0.0
    bias_instability: Annotated[float, measure_of("acceleration")] = 0.0
    turn_on_bias: Annotated[float, measure_of("acceleration")] | None = None
    constant_bias: (
        Annotated[tuple[float, float, float], each_of("acceleration")] | None
    ) = None
    increments: bool | None = None


class EncoderSpec(Sampled):
    """Standard deviations of an angle and of a rate that are read, and one count."""

    position: Angle | None = None
    resolution: Angle | None = None
    tachometer: Annotated[float, measure_of("angular rate")] | None = None

    @model_validator(mode="after")
    def _something(self) -> "EncoderSpec":
        if self.position is None and self.tachometer is None:
            raise WrongValueError("give position, tachometer or both")
        return self


Axes = tuple[float, float, float]
LastingAxes = Annotated[Axes, _per_axis("time", above_zero=True)]


class TrackerSpec(Sampled):
    """What attitude and position share: noise that is not white."""

    correlation_time: LastingAxes | None = None

    @model_validator(mode="after")
    def _complete(self) -> "TrackerSpec":
        std = getattr(self, "markov_std", None)
        if std is not None and any(std) and self.correlation_time is None:
            raise WrongValueError("markov_std needs a correlation_time beside it")
        if self.correlation_time is not None and std is None:
            raise WrongValueError("correlation_time needs a markov_std beside it")
        return self


class AttitudeSpec(TrackerSpec):
    """Star tracker or motion capture."""

    angle: Angle
    markov_std: Annotated[Axes, _per_axis("angle")] | None = None
    random_walk: Annotated[Axes, _per_axis("angle random walk")] | None = None


class PositionSpec(TrackerSpec):
    """Motion capture."""

    std: Length
    markov_std: Annotated[Axes, _per_axis("length")] | None = None
    random_walk: Annotated[Axes, _per_axis("length random walk")] | None = None


class SensorsSpec(MappingSchema):
    """What is measured, how often and how well, SI; absent is not measured."""

    suites: tuple[str, ...] = ()
    """Ready-made sensors; a sensor that the file gives itself stands instead."""
    rate: Rate | None = None
    gyro: GyroSpec | None = None
    accelerometer: AccelerometerSpec | None = None
    joints: EncoderSpec | None = None
    attitude: AttitudeSpec | None = None
    position: PositionSpec | None = None
    wheels: EncoderSpec | None = None

    @field_validator("suites")
    @classmethod
    def _known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            sensor_suite(name)
        return names

    def in_si(self) -> dict[str, Any]:
        """What is said of each sensor."""
        sensors: dict[str, Any] = {}
        for name in self.suites:
            sensors |= sensor_suite(name)
        return sensors | self.model_dump(exclude_none=True, exclude={"suites"})
