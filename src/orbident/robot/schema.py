"""The robot file as pydantic models: what may stand where."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.bounds import SMALLEST
from orbident.files.names import first_duplicate
from orbident.files.schema_parts import (
    MappingSchema,
    Positive,
    Vector3,
    WrongValueError,
    finite_number,
    finite_vector,
)
from orbident.robot.description import Axis
from orbident.robot.disturbance_groups import DisturbanceGroup
from orbident.robot.orbit_schema import OrbitEntry
from orbident.robot.sensor_schema import SensorsSpec, Share
from orbident.robot.tolerance_schema import TolerancesEntry


def _direction(value: object) -> tuple[float, ...]:
    vector = finite_vector(value, 3)
    if max(map(abs, vector)) < SMALLEST:
        raise WrongValueError("give a nonzero 3-vector")
    return vector


def _range(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise WrongValueError("give [lower, upper]")
    ends = tuple(finite_number(each) for each in value)
    if ends[0] >= ends[1]:
        raise WrongValueError("give [lower, upper] with lower below upper")
    return ends


Direction = Annotated[tuple[float, float, float], BeforeValidator(_direction)]
Range = Annotated[tuple[float, float], BeforeValidator(_range)]
Name = Annotated[str, Field(min_length=1)]


class WheelEntry(MappingSchema):
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
            if self.axis is not None:
                raise InputError(
                    "'joint' and 'axis' exclude each other: a wheel on a URDF joint "
                    "takes its axis from there; keep one"
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


class ThrusterEntry(MappingSchema):
    """A thruster on the base."""

    name: Name
    position: Vector3
    direction: Direction
    gain: Share = 0.1
    thrust: Positive | None = None


class TorquerEntry(MappingSchema):
    """A magnetic torquer in the base."""

    name: Name
    axis: Direction
    gain: Share = 0.1


class LimitEntry(MappingSchema):
    """Limits of one joint, instead of the URDF's."""

    position: Range | None = None
    velocity: Positive | None = None


class StructureEntry(MappingSchema):
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


class RobotFile(MappingSchema):
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
    torquers: tuple[TorquerEntry, ...] = ()
    pads: dict[str, Vector3] = Field(default_factory=dict)
    disturbances: tuple[DisturbanceGroup, ...] = ()
    orbit: OrbitEntry | None = None
    limits: dict[str, LimitEntry] = Field(default_factory=dict)
    structure: dict[str, StructureEntry] = Field(default_factory=dict)
    sensors: SensorsSpec = SensorsSpec()
    tolerances: TolerancesEntry = TolerancesEntry()

    @model_validator(mode="after")
    def _unique_names(self) -> "RobotFile":
        for key, names in (
            ("wheels", [wheel.label for wheel in self.wheels]),
            ("thrusters", [thruster.name for thruster in self.thrusters]),
            ("torquers", [torquer.name for torquer in self.torquers]),
        ):
            twice = first_duplicate(names)
            if twice is not None:
                raise InputError(f"{key}: the name {twice!r} is given twice")
        return self

    @model_validator(mode="after")
    def _orbit_in_space(self) -> "RobotFile":
        if self.orbit is not None and self.motion == "planar":
            raise InputError(
                "orbit: a robot whose motion is planar floats on a table; remove the "
                "orbit, or say 'motion: spatial'"
            )
        return self
