"""The names of a recording's columns, and what each one is for."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed

MOST_COLUMNS = 10_000
"""Arrow needs some 30 kB a column, however few the rows: so many take 0.3 GB."""

VECTORS = {
    "gyro": ("xyz", "base angular velocity in base axes, rad/s"),
    "accelerometer": ("xyz", "specific force at S in base axes, m/s^2"),
    "velocity_increment": ("xyz", "integrated specific force over a sample, m/s"),
    "attitude": ("xyzw", "base orientation in the inertial frame, scalar last"),
    "position": ("xyz", "of S, inertial axes, m"),
    "velocity": ("xyz", "of S, inertial axes, m/s"),
    "force": ("xyz", "net thruster force, base axes, N"),
    "torque": ("xyz", "net thruster moment about S, base axes, N m"),
    "nadir": ("xyz", "from the robot to the middle of the Earth, base axes, m"),
    "flow": ("xyz", "direction in which the air flows past, base axes"),
    "sun": ("xyz", "direction to the sun, base axes; shorter in shadow"),
    "field": ("xyz", "magnetic field, base axes, T"),
}
PER_JOINT = {
    "position": "joint position, rad, or m for prismatic",
    "velocity": "joint rate, rad/s, or m/s for prismatic",
}
PER_WHEEL = {
    "speed": "wheel speed relative to the base, rad/s",
    "position": "unwrapped wheel angle relative to the base, rad",
}

PER_THRUSTER = {
    "force": "thruster force until the next row, N",
    "duty": "part of its full thrust until the next row, 0 to 1",
}

PER_TORQUER = {"dipole": "dipole of a torquer until the next row, A m^2"}

_ALTERNATIVES = [
    *(f"{name}\\.[{axes}]" for name, (axes, _) in VECTORS.items()),
    rf"joint\.(?P<joint>.+)\.(?:{'|'.join(PER_JOINT)})",
    rf"wheel\.(?P<wheel>.+)\.(?:{'|'.join(PER_WHEEL)})",
    rf"thruster\.(?P<thruster>.+)\.(?:{'|'.join(PER_THRUSTER)})",
    rf"torquer\.(?P<torquer>.+)\.(?:{'|'.join(PER_TORQUER)})",
]
_PATTERN = re.compile("|".join(_ALTERNATIVES))


def is_known(column: str) -> bool:
    """Whether the column has a meaning here; any other is carried along unused."""
    return column == "t" or _PATTERN.fullmatch(column) is not None


def joint_of(column: str) -> str | None:
    """The joint that the column belongs to, or None."""
    match = _PATTERN.fullmatch(column)
    return match["joint"] if match else None


def wheel_of(column: str) -> str | None:
    """The wheel that the column belongs to, or None."""
    match = _PATTERN.fullmatch(column)
    return match["wheel"] if match else None


def thruster_of(column: str) -> str | None:
    """The thruster that the column belongs to, or None."""
    match = _PATTERN.fullmatch(column)
    return match["thruster"] if match else None


def torquer_of(column: str) -> str | None:
    """The torquer that the column belongs to, or None."""
    match = _PATTERN.fullmatch(column)
    return match["torquer"] if match else None


def meaning(column: str) -> str:
    """What the column is for, in words with unit and frame; empty if unknown."""
    if column == "t":
        return "time, s, strictly increasing"
    if not is_known(column):
        return ""
    head, last = column.split(".", 1)[0], column.rsplit(".", 1)[1]
    if head == "joint":
        return PER_JOINT[last]
    if head == "wheel":
        return PER_WHEEL[last]
    if head == "thruster":
        return PER_THRUSTER[last]
    if head == "torquer":
        return PER_TORQUER[last]
    return VECTORS[head][1]


def check_names(source: str, names: Sequence[str]) -> None:
    """Refuses nameless, repeated and too many columns, and a table without `t`.

    Raises:
        InputError: So.
    """
    if len(names) > MOST_COLUMNS:
        raise InputError(
            f"{source}: has {len(names)} columns; give at most {MOST_COLUMNS}: remove "
            "what is no signal of the robot"
        )
    for name, count in Counter(names).items():
        if not name:
            where = names.index(name) + 1
            raise InputError(
                f"{source}: column {where} has no name; name it or remove it "
                "(pandas writes one unless index=False)"
            )
        if count > 1:
            raise InputError(
                f"{source}: {count} columns are named '{name}'; keep or rename one"
            )
    if "t" not in names:
        raise InputError(
            f"{source}: column 't' is missing (time, s); found {listed(names)}; name "
            "the columns in the first line"
        )


def columns_in_words(columns: Mapping[str, Float[np.ndarray, " samples"]]) -> list[str]:
    """A line for each sensor: its columns, and how many samples it has.

    Args:
        columns: by name; NaN where a sensor has no sample.
    """
    sensors: dict[str, list[str]] = {}
    for name in columns:
        sensor, _, component = name.rpartition(".")
        sensors.setdefault(sensor, []).append(component)
    lines = []
    for sensor, components in sensors.items():
        names = [f"{sensor}.{each}" if sensor else each for each in components]
        samples = max(np.count_nonzero(~np.isnan(columns[name])) for name in names)
        shown = ", ".join([names[0], *(f".{each}" for each in components[1:])])
        lines.append(f"  {shown}: {samples} samples")
    return lines
