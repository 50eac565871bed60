"""Units that a topic map can declare."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.robot.units import UNITS

DIMENSIONS: Mapping[str, Mapping[str, float]] = {
    "angle": UNITS["angle"],
    "angular rate": {**UNITS["angular rate"], "rpm": 2 * math.pi / 60},
    "length": UNITS["length"],
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "acceleration": UNITS["acceleration"],
    "force": {"N": 1.0, "mN": 1e-3},
    "torque": {"N m": 1.0, "mN m": 1e-3},
    "share": UNITS["share"],
    "magnetic moment": {"A m^2": 1.0},
}
"""Each unit's value in SI."""
TIMES: Mapping[str, int] = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
"""Each unit of time in nanoseconds."""
_COUNT = re.compile(r"(?:(\d{1,9}(?:\.\d{1,9})?)\s+)?(\w+)", re.ASCII)


def nanoseconds_of(unit: str) -> int | None:
    """How many a unit of time has, or a count of `0.2 s`; None where it is neither."""
    found = _COUNT.fullmatch(unit)
    if found is None or found[2] not in TIMES:
        return None
    exact = Fraction(found[1] or "1") * TIMES[found[2]]
    return int(exact) if exact > 0 and exact.denominator == 1 else None


@dataclass(frozen=True)
class Unit:
    """A unit that was declared."""

    name: str
    dimension: str
    si: float
    """Its value in SI."""


def unit_of(*dimensions: str) -> Callable[[object], Unit]:
    """What reads the name of a unit of one of these dimensions.

    Raises:
        InputError: by what is returned: the name is of none.
    """
    accepted = {
        "".join(name.split()): Unit(name, dimension, si)
        for dimension in dimensions
        for name, si in DIMENSIONS[dimension].items()
    }

    def read(given: object) -> Unit:
        # YAML reads the unit of a share, 1, as a number.
        found = accepted.get("".join(str(given).split()))
        if found is None:
            names = ", ".join(each.name for each in accepted.values())
            raise InputError(f"declare the messages' unit: {names}")
        return found

    return read


def unit(*dimensions: str) -> BeforeValidator:
    """The same for the field of a schema."""
    return BeforeValidator(unit_of(*dimensions))
