"""Quantities with units, as robot files write them: `"0.3 deg/h"` to SI."""

import math
import re
from typing import Annotated, NamedTuple

from pydantic import BeforeValidator

from orbident.files.bounds import LARGEST, SMALLEST
from orbident.files.names import quoted
from orbident.files.schema_parts import WrongValueError, finite_vector

STANDARD_GRAVITY = 9.80665
"""m/s^2, exact by definition."""

_DEG = math.pi / 180
_HOUR = 3600.0
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")

UNITS: dict[str, dict[str, float]] = {
    "angle": {
        "rad": 1.0,
        "mrad": 1e-3,
        "urad": 1e-6,
        "deg": _DEG,
        "arcmin": _DEG / 60,
        "arcsec": _DEG / 3600,
    },
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": _HOUR},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "length random walk": {"m/sqrt(s)": 1.0, "mm/sqrt(s)": 1e-3, "um/sqrt(s)": 1e-6},
    "mass": {"kg": 1.0, "g": 1e-3},
    # "kg m^2": spaces in a unit do not count.
    "inertia": {
        "kgm^2": 1.0,
        "kgcm^2": 1e-4,
        "kgmm^2": 1e-6,
        "gcm^2": 1e-7,
        "gmm^2": 1e-9,
    },
    "altitude": {"m": 1.0, "km": 1e3},
    "area": {"m^2": 1.0, "cm^2": 1e-4},
    "density": {"kg/m^3": 1.0, "g/cm^3": 1e3},
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6},
    "torque": {"Nm": 1.0, "mNm": 1e-3, "uNm": 1e-6},
    "current": {"A": 1.0, "mA": 1e-3},
    "constant of a motor that turns": {"Nm/A": 1.0, "mNm/A": 1e-3},
    "constant of a motor that slides": {"N/A": 1.0, "mN/A": 1e-3},
    "force density": {"N/sqrt(Hz)": 1.0, "mN/sqrt(Hz)": 1e-3, "uN/sqrt(Hz)": 1e-6},
    "torque density": {"Nm/sqrt(Hz)": 1.0, "mNm/sqrt(Hz)": 1e-3, "uNm/sqrt(Hz)": 1e-6},
    "slope": {"1/s^2": 1.0, "urad/m": 1e-6 * STANDARD_GRAVITY},
    "drag": {"Ns/m": 1.0, "mNs/m": 1e-3},
    "stiffness": {"N/m": 1.0, "mN/m": 1e-3},
    "turning drag": {"Nms": 1.0, "mNms": 1e-3},
    "magnetic moment": {"Am^2": 1.0},
    "share": {"1": 1.0, "%": 1e-2, "ppm": 1e-6},
    "frequency": {"Hz": 1.0, "kHz": 1e3},
    "speed": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "angular rate": {
        "rad/s": 1.0,
        "mrad/s": 1e-3,
        "deg/s": _DEG,
        "rad/h": 1 / _HOUR,
        "deg/h": _DEG / _HOUR,
    },
    "angle random walk": {
        "rad/sqrt(s)": 1.0,
        "urad/sqrt(s)": 1e-6,
        "deg/sqrt(s)": _DEG,
        "rad/sqrt(h)": 1 / math.sqrt(_HOUR),
        "deg/sqrt(h)": _DEG / math.sqrt(_HOUR),
        "rad/s/sqrt(Hz)": 1.0,
        "deg/s/sqrt(Hz)": _DEG,
    },
    "acceleration": {
        "m/s^2": 1.0,
        "mm/s^2": 1e-3,
        "g": STANDARD_GRAVITY,
        "mg": 1e-3 * STANDARD_GRAVITY,
        "ug": 1e-6 * STANDARD_GRAVITY,
    },
    "velocity random walk": {
        "m/s/sqrt(s)": 1.0,
        "m/s/sqrt(h)": 1 / math.sqrt(_HOUR),
        "m/s^2/sqrt(Hz)": 1.0,
        "mg/sqrt(Hz)": 1e-3 * STANDARD_GRAVITY,
        "ug/sqrt(Hz)": 1e-6 * STANDARD_GRAVITY,
    },
}
"""Each accepted unit's value in SI, by dimension; the first one is SI's own."""
UNITS["acceleration or slope"] = UNITS["acceleration"] | {
    unit: STANDARD_GRAVITY * angle for unit, angle in UNITS["angle"].items()
}
OF_A_JOINT = "angle or length"
"""The dimension of a position of a joint that may be of either kind."""

TORQUE_OF_A_JOINT = "torque or force"
CONSTANT_OF_A_MOTOR = "torque constant"
FRICTION_OF_A_JOINT = "viscous friction"
ARMATURE_OF_A_JOINT = "inertia or mass"

POSITION_OF = {"revolute": "angle", "prismatic": "length"}
"""The dimension of a joint's position, by its kind."""

BY_KIND = {
    OF_A_JOINT: POSITION_OF,
    TORQUE_OF_A_JOINT: {"revolute": "torque", "prismatic": "force"},
    CONSTANT_OF_A_MOTOR: {
        "revolute": "constant of a motor that turns",
        "prismatic": "constant of a motor that slides",
    },
    FRICTION_OF_A_JOINT: {"revolute": "turning drag", "prismatic": "drag"},
    ARMATURE_OF_A_JOINT: {"revolute": "inertia", "prismatic": "mass"},
}
"""What is one dimension or another, by the kind of a joint."""
UNITS |= {
    either: {unit: si for each in own.values() for unit, si in UNITS[each].items()}
    for either, own in BY_KIND.items()
}


def si_unit(dimension: str) -> str:
    """The SI unit, such as `rad`."""
    return next(iter(UNITS[dimension]))


def quantity(given: object, dimension: str) -> float:
    """A quantity in SI.

    A number is taken as SI; a text is such as `"0.01 deg/sqrt(h)"`. The dimension is a
    key of `UNITS`.

    Raises:
        WrongValueError: no finite number, or a unit that the dimension does not have.
    """
    units = UNITS[dimension]
    number, unit = _split(given)
    factor = units.get(unit) if unit else 1.0
    if factor is None:
        article = "an" if dimension[0] in "aeiou" else "a"
        raise WrongValueError(
            f"unknown unit {quoted(unit)} of {article} {dimension}; "
            f"accepted: {', '.join(units)}"
        )
    si = next(iter(units))
    if number is None or not math.isfinite(number):
        raise WrongValueError(
            f"give a finite number, with or without a unit ('0.1 {si}')"
        )
    if abs(number * factor) > LARGEST:
        raise WrongValueError(f"give at most {LARGEST:g} {si}")
    return number * factor


class MeasuredQuantity(NamedTuple):
    """What somebody measured, in SI."""

    value: float
    std: float


def measured(given: object, dimension: str) -> MeasuredQuantity:
    """What was measured, and its standard deviation, such as `23.09 +- 0.01 kg`.

    The unit, of both, may be left out where it is SI's. The dimension is a key of
    `UNITS`.

    Raises:
        WrongValueError: a deviation is missing, or not above zero.
    """
    value, sign, std = str(given).partition("+-")
    if not sign:
        raise WrongValueError(
            f"give a value and its deviation ('1.2 +- 0.1 {si_unit(dimension)}')"
        )
    _, unit = _split(std)
    number, own = _split(value)
    deviation = at_least_zero(std, dimension)
    if not deviation:
        raise WrongValueError("give a deviation above zero")
    return MeasuredQuantity(quantity(f"{number} {own or unit}", dimension), deviation)


def measurement_of(dimension: str) -> BeforeValidator:
    """Reads what was measured, in SI."""
    return BeforeValidator(lambda value: measured(value, dimension))


def _split(given: object) -> tuple[float | None, str]:
    """The number, None where there is none, and the unit's text."""
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        return None, ""
    found = _NUMBER.match(str(given))
    if found is None:
        return None, ""
    return float(found[0]), "".join(found.string[found.end() :].split())


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


def quantity_of(dimension: str) -> BeforeValidator:
    """Reads a quantity of either sign, in SI."""
    return BeforeValidator(lambda value: quantity(value, dimension))


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


def per_axis(dimension: str, *, above_zero: bool = False) -> BeforeValidator:
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


def positive_of(dimension: str, words: str, more: str = "") -> BeforeValidator:
    """Reads a quantity above zero, in SI; the words say what it is."""

    def in_si(value: object) -> float:
        number = quantity(value, dimension)
        if number < SMALLEST:
            raise WrongValueError(f"give a {words} above zero{more}")
        return number

    return BeforeValidator(in_si)


def _lasting(value: object) -> float:
    """A time above zero; infinite for what never changes."""
    if value == math.inf:
        return math.inf
    number = quantity(value, "time")
    if number < SMALLEST:
        raise WrongValueError("give a time above zero, or .inf")
    return number


Rate = Annotated[float, positive_of("frequency", "rate")]
Damping = Annotated[float, positive_of("share", "damping, such as 0.5 %,")]
Lasting = Annotated[float, BeforeValidator(_lasting)]
Time = Annotated[float, measure_of("time")]
Angle = Annotated[float, measure_of("angle")]
Length = Annotated[float, measure_of("length")]
Share = Annotated[float, measure_of("share")]
