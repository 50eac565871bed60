"""Units as people write them in titles of columns, in one spelling."""

import re

from orbident.robot.units import UNITS

_KNOWN = {"ns", "rpm", *(unit for units in UNITS.values() for unit in units)}
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
