"""The robot file as pydantic models: what may stand where."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.names import first_duplicate
from orbident.files.schema_parts import (
    Positive,
    Section,
    Vector3,
    finite_number,
    finite_vector,
)
from orbident.robot.description import Axis
from orbident.robot.units import quantity


def _direction(value: object) -> tuple[float, ...]:
    vector = finite_vector(value, 3)
    if not any(vector):
        raise InputError("give a nonzero 3-vector")
    return vector


def _range(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError("give [lower, upper]")
    ends = tuple(finite_number(each) for each in value)
    if ends[0] >= ends[1]:
        raise InputError("give [lower, upper] with lower below upper")
    return ends


def _measure(dimension: str) -> BeforeValidator:
    """Zero or more of a dimension, in SI."""

    def in_si(value: object) -> float:
        number = quantity(value, dimension)
        if number < 0:
            raise InputError("give zero or more")
        return number

    return BeforeValidator(in_si)


def _rate(value: object) -> float:
    number = quantity(value, "frequency")
    if number <= 0:
        raise InputError("give a rate above zero")
    return number


Direction = Annotated[tuple[float, float, float], BeforeValidator(_direction)]
Range = Annotated[tuple[float, float], BeforeValidator(_range)]
Name = Annotated[str, Field(min_length=1)]
Angle = Annotated[float, _measure("angle")]
Length = Annotated[float, _measure("length")]


class WheelEntry(Section):
    """A wheel: declared, or a joint of the URDF."""

    name: Name | None = None
    joint: Name | None = None
    axis: Direction | None = None
    inertia: Positive | None = None
    mode: Literal["held", "free"] = "held"

    @model_validator(mode="after")
    def _one_kind(self) -> "WheelEntry":
        given = {"axis": self.axis, "inertia": self.inertia}
        if self.joint is not None:
            extra = [key for key, value in given.items() if value is not None]
            if extra:
                raise InputError(
                    f"'joint' and {' and '.join(map(repr, extra))} exclude each other: "
                    "a wheel on a URDF joint takes both from there; keep one"
                )
            return self
        missing = [
            key for key, value in ({"name": self.name} | given).items() if value is None
        ]
        if missing:
            raise InputError(
                f"{' and '.join(map(repr, missing))} missing; give name, axis and "
                "inertia, or the URDF's joint"
            )
        return self

    @property
    def label(self) -> str:
        """The wheel's name: its joint's where none is given."""
        return self.name or self.joint or ""


class ThrusterEntry(Section):
    """A thruster on the base."""

    name: Name
    position: Vector3
    direction: Direction


class LimitEntry(Section):
    """Limits of one joint, instead of the URDF's."""

    position: Range | None = None
    velocity: Positive | None = None


class StructureEntry(Section):
    """What is known of one body's mass distribution."""

    com_on_axis: Axis | None = None
    principal_axes: bool = False

    @model_validator(mode="after")
    def _linear(self) -> "StructureEntry":
        if self.principal_axes and self.com_on_axis is None:
            raise InputError(
                "principal_axes needs com_on_axis: about the body's origin the "
                "products of inertia contain products of CM coordinates, so without it "
                "the knowledge is not linear in the parameters; add com_on_axis or "
                "leave principal_axes out"
            )
        return self


class Gyro(Section):
    """Noise of the base's angular rate."""

    angle_random_walk: Annotated[float, _measure("angle random walk")] = 0.0
    bias_instability: Annotated[float, _measure("angular rate")] = 0.0


class Accelerometer(Section):
    """Noise of the specific force at S."""

    velocity_random_walk: Annotated[float, _measure("velocity random walk")] = 0.0
    bias_instability: Annotated[float, _measure("acceleration")] = 0.0


class Encoder(Section):
    """Standard deviation of an angle that is read."""

    position: Angle


class Attitude(Section):
    """Star tracker or motion capture."""

    angle: Angle


class Position(Section):
    """Motion capture."""

    std: Length


class Sensors(Section):
    """What is measured, how often and how well, SI; absent is not measured."""

    rate: Annotated[float, BeforeValidator(_rate)] | None = None
    gyro: Gyro | None = None
    accelerometer: Accelerometer | None = None
    joints: Encoder | None = None
    attitude: Attitude | None = None
    position: Position | None = None
    wheels: Encoder | None = None


class RobotFile(Section):
    """A robot file, `schema: orbident/robot/1`."""

    # "schema" is a method of pydantic's models.
    schema_: Literal["orbident/robot/1"] = Field(alias="schema")
    name: Name | None = None
    urdf: Name
    base_link: Name | None = None
    motion: Literal["spatial", "planar"] = "spatial"
    feature_point: Vector3 = (0.0, 0.0, 0.0)
    wheels: tuple[WheelEntry, ...] = ()
    thrusters: tuple[ThrusterEntry, ...] = ()
    limits: dict[str, LimitEntry] = Field(default_factory=dict)
    structure: dict[str, StructureEntry] = Field(default_factory=dict)
    sensors: Sensors = Sensors()

    @model_validator(mode="after")
    def _unique_names(self) -> "RobotFile":
        for key, names in (
            ("wheels", [wheel.label for wheel in self.wheels]),
            ("thrusters", [thruster.name for thruster in self.thrusters]),
        ):
            twice = first_duplicate(names)
            if twice is not None:
                raise InputError(f"{key}: the name {twice!r} is given twice")
        return self
