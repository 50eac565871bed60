"""The names of a recording's columns, what each one is for, and units in titles."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.robot.units import UNITS

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
OF_PARTS = {
    "joint": {
        "position": "joint position, rad, or m for prismatic",
        "velocity": "joint rate, rad/s, or m/s for prismatic",
        "torque": "torque on what a joint moves, N m, or N for prismatic",
        "current": "current of a joint's motor, A",
    },
    "wheel": {
        "speed": "wheel speed relative to the base, rad/s",
        "position": "unwrapped wheel angle relative to the base, rad",
    },
    "thruster": {
        "force": "thruster force until the next row, N",
        "duty": "part of its full thrust until the next row, 0 to 1",
    },
    "torquer": {"dipole": "dipole of a torquer until the next row, A m^2"},
}
"""Columns of a part of a robot, `wheel.<name>.speed`: by its kind and the last word."""

_ALTERNATIVES = [
    *(f"{name}\\.[{axes}]" for name, (axes, _) in VECTORS.items()),
    *(
        rf"{kind}\.(?P<{kind}>.+)\.(?:{'|'.join(words)})"
        for kind, words in OF_PARTS.items()
    ),
]
_PATTERN = re.compile("|".join(_ALTERNATIVES))


def vector_columns(name: str) -> tuple[str, ...]:
    """The columns of one of `VECTORS`, in their order."""
    return tuple(f"{name}.{k}" for k in VECTORS[name][0])


def is_known(column: str) -> bool:
    """Whether the column has a meaning here; any other is carried along unused."""
    return column == "t" or _PATTERN.fullmatch(column) is not None


def part_of(kind: str, column: str) -> str | None:
    """The name of the joint, wheel, thruster or torquer that the column belongs to.

    It is none's of any other kind.
    """
    match = _PATTERN.fullmatch(column)
    return match[kind] if match else None


def meaning(column: str) -> str:
    """What the column is for, in words with unit and frame; empty if unknown."""
    if column == "t":
        return "time, s, strictly increasing"
    if not is_known(column):
        return ""
    head, last = column.split(".", 1)[0], column.rsplit(".", 1)[1]
    return OF_PARTS[head][last] if head in OF_PARTS else VECTORS[head][1]


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
    """A line for each sensor: its columns, and how many samples it has."""
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


# In a table N/A says that there is nothing.
_KNOWN = {"ns", "rpm", *(unit for x in UNITS.values() for unit in x)} - {"N/A"}
SI = {unit for units in UNITS.values() for unit, si in units.items() if si == 1.0}
"""The units in which a recording is."""
_SPELLED = {
    **dict.fromkeys(("sec", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("usec", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("nsec", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("meter", "meters"), "m"),
    **dict.fromkeys(("millimeter", "millimeters"), "mm"),
    **dict.fromkeys(("degps", "deg/sec", "dps"), "deg/s"),
    **dict.fromkeys(("radps", "rad/sec"), "rad/s"),
    **dict.fromkeys(("m/s2", "m/s/s", "m/sec^2"), "m/s^2"),
    "RPM": "rpm",
}
# The micro sign and the Greek mu, degrees, squares, dots of products.
_SIGNS = str.maketrans(
    {
        "\u00b5": "u",
        "\u03bc": "u",
        "\u00b0": "deg",
        "\u00b2": "^2",
        "\u00b7": "",
        "*": "",
    }
)
_BEHIND = re.compile(r"(.*\S)\s*(?:\[([^][]*)\]|\(([^()]*)\))", re.DOTALL)


def written_unit(text: str) -> str:
    """The unit as `UNITS` names it, such as `deg/s`; empty if it is not known."""
    bare = "".join(text.translate(_SIGNS).split())
    if bare[:1] + bare[-1:] in {"[]", "()"}:
        bare = bare[1:-1]
    unit = _SPELLED.get(bare, _SPELLED.get(bare.lower(), bare))
    return unit if unit in _KNOWN else ""


def split_name(name: str) -> tuple[str, str]:
    """`time [ms]` or `time (ms)` as `time` and `ms`; any other name and nothing."""
    found = _BEHIND.fullmatch(name)
    unit = written_unit(found[2] or found[3] or "") if found else ""
    return (found[1], unit) if found and unit else (name, "")
