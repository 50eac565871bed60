"""What numbers of a table can fill, a vector or one column, and in which units."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.bounds import LARGEST
from orbident.files.names import closest, quoted
from orbident.files.schema_parts import WrongValueError
from orbident.recordings.columns import (
    OF_PARTS,
    VECTORS,
    is_known,
    part_of,
    vector_columns,
)
from orbident.robot.units import UNITS

DIMENSIONS: Mapping[str, Mapping[str, float]] = {
    "angle": UNITS["angle"],
    "angular rate": {**UNITS["angular rate"], "rpm": 2 * math.pi / 60},
    "length": UNITS["length"],
    "velocity": UNITS["speed"],
    "acceleration": UNITS["acceleration"],
    "force": {"N": 1.0, "mN": 1e-3},
    "torque": {"N m": 1.0, "mN m": 1e-3},
    "current": UNITS["current"],
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
    """A unit that was declared, or the form of an attitude."""

    name: str
    dimension: str
    """Empty of a quaternion and the like."""
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


_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_SLOT = re.compile(
    rf"(?P<minus>-?)\s*(?:(?P<factor>{_NUMBER})\s*\*\s*)?(?P<field>\S|\S.*?\S)"
    rf"(?:\s+(?P<offset>[-+]\s+{_NUMBER}))?",
    re.DOTALL,
)


class Slot(NamedTuple):
    """One number of a sample, `factor * field + offset`."""

    field: str
    """Which field it is of; empty for a number that is always the same."""
    factor: float
    offset: float = 0.0


def slots_of(value: object) -> tuple[Slot, ...] | Slot:
    """`x`, `-x`, `0.4 * x + 3` or a number as one slot; a list of them as several."""
    if isinstance(value, list | tuple):
        return tuple(_slot(each) for each in value)
    return _slot(value)


def _slot(value: object) -> Slot:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return _bounded(Slot("", 0.0, value))
    found = _SLOT.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        raise WrongValueError(
            "give a field, a field with a minus before it, counts as '0.4 * field + "
            "3', or a list of these, such as [wx, -wy, 0]"
        )
    factor = float(found["factor"] or 1) * (-1 if found["minus"] else 1)
    offset = "".join((found["offset"] or "0").split())
    return _bounded(Slot(found["field"], factor, float(offset)))


def _bounded(slot: Slot) -> Slot:
    # A whole number of a YAML file may be larger than any float64.
    if not (abs(slot.factor) <= LARGEST and abs(slot.offset) <= LARGEST):
        raise WrongValueError(f"give numbers of at most {LARGEST:g}")
    return slot._replace(offset=float(slot.offset))


DIMENSION_OF = {
    "gyro": "angular rate",
    "accelerometer": "acceleration",
    "position": "length",
    "velocity": "velocity",
    "force": "force",
    "torque": "torque",
}
_OF_PARTS = {
    ("joint", "position"): ("angle", "length"),
    ("joint", "velocity"): ("angular rate", "velocity"),
    ("joint", "torque"): ("torque", "force"),
    ("joint", "current"): ("current",),
    ("wheel", "position"): ("angle",),
    ("wheel", "speed"): ("angular rate",),
    ("thruster", "force"): ("force",),
    ("thruster", "duty"): ("share",),
    ("torquer", "dipole"): ("magnetic moment",),
}
_ATTITUDES: Mapping[str, tuple[int, str]] = {
    "quaternion": (4, "[qx, qy, qz, qw]"),
    "mrp": (3, "[sigma1, sigma2, sigma3]"),
    **dict.fromkeys(DIMENSIONS["angle"], (3, "[roll, pitch, yaw]")),
}
"""How many numbers each form of an attitude has, with an example of their names."""


TURNED = {"gyro", "accelerometer", "attitude", "force", "torque"}
"""What is in, or of, the base's axes."""
AT_S = {"accelerometer", "position", "velocity", "torque"}
"""What is of the feature point, or about it."""


@dataclass(frozen=True)
class Target:
    """A vector, an attitude, or one column."""

    name: str
    unit: Unit
    """The unit of each of the numbers that the target holds."""
    columns: tuple[str, ...]
    width: int
    """Numbers that it is made of."""
    example: str

    @property
    def part_of_turned(self) -> bool:
        """Whether it is one axis of a vector in the base's axes."""
        return self.name not in VECTORS and self.name.split(".")[0] in TURNED

    def in_si(self, raw: Float[np.ndarray, "n width"]) -> Float[np.ndarray, "n K"]:
        """The values in SI; an attitude as a unit quaternion, scalar last."""
        if self.name != "attitude" or self.unit.name == "quaternion":
            return raw * self.unit.si
        if self.unit.name == "mrp":
            return of_mrp(raw)
        # Late: the import takes as long as that of all the rest.
        from scipy.spatial.transform import Rotation

        # R = R_z(yaw) R_y(pitch) R_x(roll)
        return Rotation.from_euler("xyz", raw * self.unit.si).as_quat()


def of_mrp(sigma: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 4"]:
    """`x = (2 s, 1 - s.s) / (1 + s.s)`, modified Rodrigues parameters."""
    square = np.sum(sigma**2, axis=1, keepdims=True)
    return np.hstack([2 * sigma, 1 - square]) / (1 + square)


Quaternions = Float[np.ndarray, "#n 4"]


def product(x: Quaternions, y: Quaternions) -> Quaternions:
    """`R(x y) = R(x) R(y)`."""
    u, v = x[:, :3], y[:, :3]
    a, b = x[:, 3:], y[:, 3:]
    vector = a * v + b * u + np.cross(u, v)
    scalar = a * b - np.sum(u * v, axis=1, keepdims=True)
    return np.concatenate([vector, scalar], axis=1)


def conjugate(x: Quaternions) -> Quaternions:
    """`R(x*) = R(x)^T`."""
    return x * np.array([-1.0, -1.0, -1.0, 1.0])


def dimension_of(column: str) -> str:
    """What a column of a recording is of, such as "length"; else nothing."""
    head, last = column.split(".")[0], column.rsplit(".", 1)[-1]
    if not is_known(column):
        return ""
    return DIMENSION_OF.get(head) or _OF_PARTS.get((head, last), ("",))[0]


def target_of(name: str, unit: object) -> Target:
    """What a key of `take` names.

    Raises:
        InputError: nothing that numbers can fill, or the unit is none of its.
    """
    if name == "attitude":
        if not isinstance(unit, str) or unit not in _ATTITUDES:
            raise InputError(
                f"take: attitude: found {unit!r}; give its form: "
                + ", ".join(_ATTITUDES)
            )
        width, example = _ATTITUDES[unit]
        of = "angle" if unit in DIMENSIONS["angle"] else ""
        form = Unit(unit, of, DIMENSIONS["angle"].get(unit, 1.0))
        return Target(name, form, vector_columns(name), width, example)
    dimensions = _dimensions(name)
    try:
        found = unit_of(*dimensions)(unit)
    except InputError as error:
        raise InputError(f"take: {name}: found {unit!r}; {error}") from None
    if name in VECTORS:
        return Target(name, found, vector_columns(name), 3, "[x, y, z]")
    return Target(name, found, (name,), 1, "x")


def _dimensions(name: str) -> tuple[str, ...]:
    head, last = name.split(".")[0], name.rsplit(".", 1)[-1]
    if head in OF_PARTS and part_of(head, name):
        return _OF_PARTS[head, last]
    if not (name in VECTORS or is_known(name)) or head not in DIMENSION_OF:
        middle = ".".join(name.split(".")[1:-1]) or "<name>"
        parts = (f"{kind}.{middle}.{of}" for kind, of in _OF_PARTS)
        close = closest(name, [*DIMENSION_OF, "attitude", *parts])
        hint = f"did you mean {quoted(close)}? " if close else ""
        raise InputError(
            f"take: found {quoted(name)}; {hint}give a column that numbers can fill, "
            "such as wheel.<name>.speed, joint.<name>.position, gyro or attitude"
        )
    return (DIMENSION_OF[head],)
