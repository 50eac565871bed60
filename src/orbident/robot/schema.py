"""The robot file as pydantic models: what may stand where."""

from collections import defaultdict
from collections.abc import Collection, Sequence
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    create_model,
    model_validator,
)

from orbident.errors import InputError
from orbident.files.names import first_duplicate, quoted, refuse_unknown
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
    Joint,
    KnownQuantities,
    MomentumWalk,
    Stillness,
    Thruster,
    Torquer,
)
from orbident.robot.joint_schema import (
    FrictionSection,
    PassiveSection,
    RotorSection,
    TorqueConstants,
)
from orbident.robot.may_act import MayAct, may_act
from orbident.robot.orbit_schema import OrbitEntry
from orbident.robot.parameters import Structure
from orbident.robot.sensor_schema import SensorsSpec
from orbident.robot.tolerances import (
    CALIBRATION_KINDS,
    EVERY,
    TORQUE_CONSTANTS,
    Tolerances,
)
from orbident.robot.units import OF_A_JOINT, POSITION_OF, at_least_zero, measure_of

DECLARED = {name: kind for name, kind in CALIBRATION_KINDS.items() if kind.entry}
"""The kinds of errors that have a tolerance among those of a robot file."""

USUAL_OF_SLIDES = 1e-4
"""m: where a sliding joint's encoder shows zero."""

EXACT = "exact"
"""In place of all tolerances."""


def _zero(value: object) -> object:
    """An angle or a length; it is converted when the joint's kind is known."""
    at_least_zero(value, OF_A_JOINT)
    return value


def _by_joint(value: object) -> object:
    if isinstance(value, dict) and not all(isinstance(v, dict) for v in value.values()):
        return {EVERY: value}
    return value


def _sections() -> dict[str, Any]:
    """The keys of the section, and what may stand there."""
    sections: dict[str, dict[str, Any]] = defaultdict(dict)
    for kind in DECLARED.values():
        section, _, key = kind.entry.partition(".")
        either: Any = Annotated[Any, BeforeValidator(_zero)]
        read: Any = Annotated[float | None, measure_of(kind.dimension)]
        sections[section][key] = (
            either if kind.dimension == OF_A_JOINT else read,
            None,
        )
    found: dict[str, Any] = {}
    for section, keys in sections.items():
        if "" in keys:
            found[section] = keys[""]
            continue
        model = create_model(f"_{section}", __base__=MappingSchema, **keys)
        found[section] = (model, model())
        if section == "joints":
            each = Annotated[dict[str, model], BeforeValidator(_by_joint)]
            found[section] = (each, Field(default_factory=dict))
    return found


class TolerancesEntry(
    create_model("ToleranceSections", __base__=MappingSchema, **_sections())
):
    """Standard deviations of calibration errors; what is absent is as usual."""

    def in_si(
        self,
        joints: Sequence[Joint],
        thrusters: Sequence[Thruster],
        torque_constants: Collection[str],
        place: str,
    ) -> Tolerances:
        """The tolerances of a robot with these joints, thrusters and torque constants.

        What is said of each thruster may be wrong of all of them alike, as where one
        bench measured them: by as much as of the one that is known best.

        Raises:
            InputError: there is no such joint, or a joint that turns has a zero in
                metres, or one that slides in radians.
        """
        given: dict[str, Any] = dict(self)
        names = [joint.name for joint in joints]
        for name in given["joints"]:
            if name != EVERY:
                fault = f"{place}: tolerances.joints: no joint {name!r}"
                refuse_unknown(name, names, fault, "joints")
        every = given["joints"].get(EVERY)
        own = {each.name: given["joints"].get(each.name, every) for each in joints}
        alike = {"thruster_scale": min((each.gain for each in thrusters), default=0.0)}
        slides = [each.name for each in joints if each.kind == "prismatic"]
        own_usual = {
            "joint_zero": dict.fromkeys(slides, USUAL_OF_SLIDES),
            "joint_torque_scale": dict.fromkeys(torque_constants, TORQUE_CONSTANTS),
        }
        found: dict[str, Any] = {}
        for tolerance, kind in DECLARED.items():
            section, _, key = kind.entry.partition(".")
            usual = alike.get(tolerance, kind.usual)
            if section == "joints":
                stds = {name: getattr(entry, key, None) for name, entry in own.items()}
                if kind.dimension == OF_A_JOINT:
                    stds = {x.name: _zero_of(x, stds[x.name], place) for x in joints}
                usuals = dict.fromkeys(names, usual) | own_usual.get(tolerance, {})
                found[tolerance] = {
                    name: usuals[name] if std is None else std
                    for name, std in stds.items()
                }
            else:
                std = getattr(given[section], key) if key else given[section]
                found[tolerance] = usual if std is None else std
        return Tolerances(**found)


def _zero_of(joint: Joint, zero: object, place: str) -> float | None:
    if zero is None:
        return None
    try:
        return at_least_zero(zero, POSITION_OF[joint.kind])
    except WrongValueError as error:
        raise InputError(
            f"{place}: tolerances.joints: the zero of {joint.kind} joint "
            f"'{joint.name}': found {quoted(zero)}; {error}; joints of two kinds need "
            "an entry each, by name"
        ) from None


def _or_exact(given: object) -> object:
    """Every tolerance zero where the file says that all is exact."""
    if given != EXACT:
        return given
    zeros: dict[str, Any] = defaultdict(dict)
    for kind in DECLARED.values():
        section, _, key = kind.entry.partition(".")
        if key:
            zeros[section][key] = 0.0
        else:
            zeros[section] = 0.0
    return zeros


ToleranceSection = Annotated[TolerancesEntry, BeforeValidator(_or_exact)]
"""As a robot file has it: its sizes, or `exact`."""


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
        if self.joint is not None and self.axis is not None:
            raise InputError(
                "'joint' and 'axis' exclude each other: a wheel on a URDF joint "
                "takes its axis from there; keep one"
            )
        needed = ("name", "axis", "inertia")
        missing = [key for key in needed if getattr(self, key) is None]
        if missing and self.joint is None:
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
    torque_constants: TorqueConstants = Field(default_factory=dict)
    friction: FrictionSection = Field(default_factory=dict)
    thrusters: tuple[Annotated[Thruster, keys_of(Thruster)], ...] = ()
    torquers: tuple[Annotated[Torquer, keys_of(Torquer)], ...] = ()
    pads: dict[str, Vector3] = Field(default_factory=dict)
    disturbances: Annotated[dict[str, MayAct] | None, PlainValidator(may_act)] = None
    momentum_walk: Annotated[MomentumWalk, keys_of(MomentumWalk)] = MomentumWalk()
    passive: PassiveSection = Field(default_factory=dict)
    flexible: PassiveSection = Field(default_factory=dict)
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
