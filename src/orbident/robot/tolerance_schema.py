"""The tolerances of a robot file as pydantic models."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, create_model

from orbident.errors import InputError
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import MappingSchema, WrongValueError
from orbident.robot.description import Joint, Thruster
from orbident.robot.tolerances import CALIBRATION_KINDS, Tolerances
from orbident.robot.units import (
    OF_A_JOINT,
    POSITION_OF,
    at_least_zero,
    measure_of,
)

DECLARED = {name: kind for name, kind in CALIBRATION_KINDS.items() if kind.entry}
"""The kinds of errors that have a tolerance among those of a robot file."""

EVERY = "*"
"""Instead of a joint's name: what is said of all of them."""

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
        self, joints: Sequence[Joint], thrusters: Sequence[Thruster], place: str
    ) -> Tolerances:
        """The tolerances of a robot with these joints and thrusters.

        What is said of each thruster may be wrong of all of them alike, as where one
        bench measured them: by as much as of the one that is known best.

        Raises:
            InputError: there is no such joint, or a joint that turns has a zero in
                metres, or one that slides in radians.
        """
        given: dict[str, Any] = dict(self)
        names = [joint.name for joint in joints]
        for name in given["joints"]:
            if name not in (*names, EVERY):
                raise InputError(
                    f"{place}: tolerances.joints: no joint {name!r}; "
                    + suggestion(name, names, "joints")
                )
        every = given["joints"].get(EVERY)
        own = {each.name: given["joints"].get(each.name, every) for each in joints}
        alike = {"thruster_scale": min((each.gain for each in thrusters), default=0.0)}
        found: dict[str, Any] = {}
        for tolerance, kind in DECLARED.items():
            section, _, key = kind.entry.partition(".")
            usual = alike.get(tolerance, kind.usual)
            if section == "joints":
                stds = {name: getattr(entry, key, None) for name, entry in own.items()}
                if kind.dimension == OF_A_JOINT:
                    stds = {x.name: _zero_of(x, stds[x.name], place) for x in joints}
                found[tolerance] = {
                    name: usual if std is None else std for name, std in stds.items()
                }
            else:
                std = getattr(given[section], key) if key else given[section]
                found[tolerance] = usual if std is None else std
        return Tolerances(**found)


def _zero_of(joint: Joint, zero: object, place: str) -> float | None:
    if zero is None:
        return None if joint.kind == "revolute" else USUAL_OF_SLIDES
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
