"""The orbit in a file, as a pydantic model."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, Field, PlainSerializer, model_validator

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.files.schema_parts import MappingSchema, WrongValueError, finite_number
from orbident.orbits.earth import R_E
from orbident.orbits.orbit import Elements, Orbit, read_oem
from orbident.robot.units import UNITS, quantity


def _with_unit(value: object, dimension: str) -> float:
    """A quantity whose unit is said: 51.6 might be degrees, and 400 kilometres."""
    number = quantity(value, dimension)
    if number and not str(value).rstrip()[-1].isalpha():
        units = ", ".join(UNITS[dimension])
        raise WrongValueError(f"it has no unit; add one of {units}")
    return number


def _measured_in(unit: str) -> PlainSerializer:
    return PlainSerializer(lambda x: x and f"{x!r} {unit}")


def _height(value: object) -> float:
    number = _with_unit(value, "altitude")
    if number <= 0:
        raise WrongValueError("the orbit is below the ground; give a height above it")
    return number


def _eccentricity(value: object) -> float:
    number = finite_number(value)
    if not 0 <= number < 1:
        raise WrongValueError("give 0 for a circle, or less than 1 for an ellipse")
    return number


def _date(value: object) -> datetime:
    """A time in UTC, from ISO 8601."""
    try:
        date = datetime.fromisoformat(str(value))
        return date.replace(tzinfo=UTC) if date.tzinfo is None else date.astimezone(UTC)
    except (ValueError, OverflowError):
        raise WrongValueError(
            "give a date and time in UTC, such as 2026-03-01T12:00:00Z"
        ) from None


Height = Annotated[float, BeforeValidator(_height), _measured_in("m")]
AngleWithUnit = Annotated[
    float,
    BeforeValidator(lambda value: _with_unit(value, "angle")),
    _measured_in("rad"),
]
Date = Annotated[
    datetime, BeforeValidator(_date), PlainSerializer(lambda date: date.isoformat())
]


class OrbitEntry(MappingSchema):
    """Elements at the epoch, in J2000 axes, or an OEM; t = 0 is the epoch."""

    altitude: Height | None = None
    """Of a circular orbit, above the Earth's equator."""
    semi_major_axis: Height | None = None
    eccentricity: Annotated[float, BeforeValidator(_eccentricity)] = 0.0
    inclination: AngleWithUnit | None = None
    node: AngleWithUnit = 0.0
    """Right ascension of the ascending node: its angle from inertial x."""
    perigee: AngleWithUnit | None = None
    """Argument of perigee: its angle from the ascending node."""
    anomaly: AngleWithUnit | None = None
    """True anomaly: the angle of the spacecraft from the perigee."""
    argument: AngleWithUnit | None = None
    """Argument of latitude: the angle of the spacecraft from the ascending node."""
    oem: Annotated[str, Field(min_length=1)] | None = None
    """An OEM instead of elements, relative to the file."""
    epoch: Date | None = None

    @model_validator(mode="after")
    def _one_orbit(self) -> "OrbitEntry":
        if self.oem is not None:
            others = sorted(self.model_fields_set - {"oem", "epoch"})
            if others:
                raise InputError(
                    f"'oem' and {listed(others)} exclude each other; keep one"
                )
            if self.epoch is None:
                raise InputError(
                    "'oem' needs 'epoch', the time in UTC at which t of a recording is "
                    "zero; add it"
                )
            return self
        self._check_size()
        if self.inclination is None:
            raise InputError("inclination: this key is missing; add it")
        if self.eccentricity and self.perigee is None:
            raise InputError("an ellipse needs 'perigee'; add it")
        if self.argument is not None and self.anomaly is not None:
            raise InputError(
                "'argument' (of latitude) and 'anomaly' both say where the spacecraft "
                "is; keep one"
            )
        return self

    def _check_size(self) -> None:
        if (self.altitude is None) == (self.semi_major_axis is None):
            raise InputError(
                "give one of 'altitude', of a circular orbit, and 'semi_major_axis'"
            )
        if self.altitude is not None and self.eccentricity:
            raise InputError(
                "'altitude' is that of a circular orbit; give 'semi_major_axis' for an "
                "ellipse"
            )
        lowest = self._semi_major_axis * (1 - self.eccentricity) - R_E
        if lowest <= 0:
            raise InputError(
                f"the orbit is below the ground: its perigee is {-lowest / 1e3:.4g} km "
                "below the equator's; give a semi-major axis from the middle of the "
                "Earth, and the eccentricity"
            )

    @property
    def _semi_major_axis(self) -> float:
        if self.altitude is not None:
            return R_E + self.altitude
        return self.semi_major_axis or 0.0

    def in_si(self, folder: Path | None = None) -> Orbit:
        """The orbit.

        An OEM is in the folder of the file.

        Raises:
            InputError: the OEM cannot be used, or there is no folder.
        """
        if self.oem is not None and self.epoch is not None:
            if folder is None:
                raise InputError("orbit: an OEM stands in a robot file; give elements")
            return Orbit(read_oem(folder / self.oem, self.epoch), self.epoch)
        perigee = self.perigee or 0.0
        anomaly = self.anomaly or 0.0
        if self.argument is not None:
            anomaly = self.argument - perigee
        elements = Elements(
            semi_major_axis=self._semi_major_axis,
            inclination=self.inclination or 0.0,
            eccentricity=self.eccentricity,
            node=self.node,
            perigee=perigee,
            anomaly=anomaly,
        )
        return Orbit(elements, self.epoch)
