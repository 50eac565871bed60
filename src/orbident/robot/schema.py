"""The robot file as pydantic models: what may stand where."""

from typing import Annotated, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    model_validator,
)

from orbident.errors import InputError
from orbident.files.names import first_duplicate
from orbident.files.schema_parts import (
    Direction,
    MappingSchema,
    Name,
    Positive,
    Vector3,
    WrongValueError,
    finite_number,
    keys_of,
)
from orbident.robot.body_schema import BodyEntry, DhTable, MassEntry
from orbident.robot.description import (
    AtRest,
    KnownQuantities,
    MomentumWalk,
    Stillness,
    Structure,
    Thruster,
    Torquer,
)
from orbident.robot.joint_schema import FrictionSection, PassiveSection, RotorSection
from orbident.robot.may_act import MayAct, may_act
from orbident.robot.orbit_schema import OrbitEntry
from orbident.robot.sensor_schema import SensorsSpec
from orbident.robot.tolerance_schema import ToleranceSection, TolerancesEntry


def _range(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise WrongValueError("give [lower, upper]")
    ends = tuple(finite_number(each) for each in value)
    if ends[0] >= ends[1]:
        raise WrongValueError("give [lower, upper] with lower below upper")
    return ends


Range = Annotated[tuple[float, float], BeforeValidator(_range)]


BODIES = ("model", "urdf", "bodies", "dh")
"""The keys of which a robot file has one: where its bodies and joints are."""


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


class LimitEntry(MappingSchema):
    """Limits of one joint, instead of the URDF's."""

    position: Range | None = None
    velocity: Positive | None = None


def _linear(known: Structure) -> Structure:
    if known.principal_axes and known.com_on_axis is None:
        raise InputError(
            "principal_axes needs com_on_axis: about the body's origin the products of "
            "inertia contain products of CM coordinates, so without it the knowledge "
            "is not linear in the parameters; add com_on_axis or leave principal_axes "
            "out"
        )
    return known


KnownStructure = Annotated[Structure, AfterValidator(_linear), keys_of(Structure)]


class RobotFile(MappingSchema):
    """A robot file, `schema: orbident/robot/1`."""

    # "schema" is a method of pydantic's models.
    schema_: Literal["orbident/robot/1"] = Field(alias="schema")
    name: Name | None = None
    model: Name | None = None
    urdf: Name | None = None
    bodies: dict[Name, BodyEntry] | None = None
    dh: DhTable | None = None
    base_link: Name | None = None
    base: MassEntry | None = None
    """Instead of what the model says of the base link."""
    motion: Literal["spatial", "planar"] = "spatial"
    feature_point: Vector3 = (0.0, 0.0, 0.0)
    wheels: tuple[WheelEntry, ...] = ()
    rotors: RotorSection = Field(default_factory=dict)
    friction: FrictionSection = Field(default_factory=dict)
    thrusters: tuple[Annotated[Thruster, keys_of(Thruster)], ...] = ()
    torquers: tuple[Annotated[Torquer, keys_of(Torquer)], ...] = ()
    pads: dict[str, Vector3] = Field(default_factory=dict)
    disturbances: Annotated[dict[str, MayAct] | None, PlainValidator(may_act)] = None
    momentum_walk: Annotated[MomentumWalk, keys_of(MomentumWalk)] = MomentumWalk()
    passive: PassiveSection = Field(default_factory=dict)
    at_rest: Stillness = AtRest()
    orbit: OrbitEntry | None = None
    limits: dict[str, LimitEntry] = Field(default_factory=dict)
    known: Annotated[KnownQuantities, keys_of(KnownQuantities)] = KnownQuantities()
    structure: dict[str, KnownStructure] = Field(default_factory=dict)
    sensors: SensorsSpec = SensorsSpec()
    tolerances: ToleranceSection = TolerancesEntry()

    @model_validator(mode="after")
    def _one_robot(self) -> "RobotFile":
        given = [key for key in BODIES if getattr(self, key) is not None]
        if not given:
            raise InputError("'model' is missing; give a URDF, xacro, MJCF or SDF file")
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} each describe a robot; keep one")
        if self.base is not None and not self.model_file:
            raise InputError(
                f"'base' is for models; give the base's mass in '{given[0]}'"
            )
        return self

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

    @property
    def model_file(self) -> str:
        """The file with the robot's bodies; `urdf` is the older name of its key."""
        return self.model or self.urdf or ""

    @model_validator(mode="after")
    def _orbit_in_space(self) -> "RobotFile":
        if self.orbit is not None and self.motion == "planar":
            raise InputError(
                "orbit: a robot whose motion is planar floats on a table; remove the "
                "orbit, or say 'motion: spatial'"
            )
        return self
