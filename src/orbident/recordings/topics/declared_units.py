"""Units that a topic map can declare."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

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
}
"""Each unit's value in SI."""
TIMES: Mapping[str, int] = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
"""Each unit of time in nanoseconds."""


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
        name: Unit(name, dimension, si)
        for dimension in dimensions
        for name, si in DIMENSIONS[dimension].items()
    }

    def read(given: object) -> Unit:
        found = accepted.get(given) if isinstance(given, str) else None
        if found is None:
            raise InputError(f"declare the messages' unit: {', '.join(accepted)}")
        return found

    return read


def unit(*dimensions: str) -> BeforeValidator:
    """The same for the field of a schema."""
    return BeforeValidator(unit_of(*dimensions))
