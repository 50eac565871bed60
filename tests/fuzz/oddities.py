"""Numbers, words and values that nobody should give."""

from random import Random
from typing import Any

NUMBERS = (
    *("nan", "inf", "-inf", ".nan", ".inf", "-.inf", "0", "-0", "-0.0", "-1", "1", "2"),
    *("1e-320", "5e-324", "1e-30", "1e30", "1e154", "1e160", "1e300", "-1e300"),
    *("1.7976931348623157e308", "1e309", "1e999999999", "9" * 400, "1e-" + "9" * 20),
    *("0." + "0" * 400 + "1", "9007199254740993", "-9223372036854775809"),
    *("18446744073709551616", "0x10", "0b1", "0o7", "1_000", "1:30", "1:30:00", "1,5"),
    *("١٢٣", "½", "1e", "1e+", "--1", "+-1", ".", "-", "+", "1.2.3", "2001-01-01"),
    *("12:30", "TRUE", "null", "", " "),
)

WORDS = (
    "",
    " ",
    "x" * 20_000,
    "\N{COMBINING ACUTE ACCENT}" * 50,
    "\N{RIGHT-TO-LEFT OVERRIDE}abc",
    "\N{PILE OF POO}",
    "../../../../etc/passwd",
    "/dev/null",
    "/dev/zero",
    "file:///etc/passwd",
    "package://../x.stl",
    "<script>alert(1)</script>",
    "]]>",
    "&amp;&#0;",
    "%s%n%d",
    "{0}{{7*7}}",
    "[bold]x[/nothing]",
    "\\N{x}",
    "a\nb",
    "a\r\nb",
    "a\tb",
    "a\x1b[31mb",
    "on",
    "no",
    "~",
    "null",
    "NaN",
    "*a",
    "&a",
    "!!python/object:os.system",
    "!!bool maybe",
    "!!binary x",
    "'",
    '"',
    "- - -",
    "? :",
    "#",
    "base",
    "joint1",
    "revolute",
    "spatial",
)

VALUES: tuple[Any, ...] = (
    None,
    True,
    False,
    0,
    -1,
    1e308,
    -1e308,
    1e160,
    1e-320,
    float("nan"),
    float("inf"),
    10**400,
    2**63,
    "",
    "x",
    "1",
    "nan",
    [],
    [[]],
    [None],
    [0],
    [1, 2, 3],
    ["x", "y", "z"],
    [1e308] * 3,
    [0, 0, 0, 0],
    {},
    {"x": 1},
    {"": None},
    {"a": {"b": {"c": []}}},
)

BYTES = (
    b"\0",
    b"\xff",
    b"\xc3\x28",
    b"\xed\xa0\x80",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\r",
    b"\r\n\r\n",
    b"\x1a",
    b"\x1b[2J",
    b"PAR1",
    b"PK\x03\x04",
    b"\x1f\x8b\x08",
)


def number(random: Random) -> str:
    """As it may stand in a text."""
    return random.choice(NUMBERS)


def word(random: Random) -> str:
    """Text that is no name of anything."""
    return random.choice(WORDS)


def value(random: Random) -> Any:
    """A value for a place in a JSON or YAML document."""
    return random.choice(VALUES)
