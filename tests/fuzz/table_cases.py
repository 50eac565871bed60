"""Text tables as laboratories write them, and as nobody should."""

from random import Random

import mutations
import oddities
from case import Case
from mutations import spoiled
from seeds import LOG_MAP, Seeds

ROWS = 20
UNITS = ("s", "us", "deg", "rad", "rad/s", "mm", "-", "", "[s]", "1", "furlong")
COMMENTS = (
    "# made by hand",
    "% x = 1",
    "// note",
    "",
    ";;;",
    '"',
    "Format Version,1.23",
)
SEPARATORS = (",", ",", ",", ";", "\t", " ", "|", ", ", "  ")
ISO = "2024-03-01T12:{:02}:{:06.3f}{}"


def tables(random: Random, seeds: Seeds) -> Case:
    """A text table in the style of some tool, one thing of it odd."""
    separator = random.choice(SEPARATORS)
    decimal = random.choice((".",) * 6 + (",",))
    columns = {"timestamp": _times(random)}
    for name in ("q", "w.0", "w.1", "count", "vector")[: random.randrange(1, 6)]:
        columns[name] = _cells(random, name)
    names = [random.choice((name, f" {name} ", f'"{name}"')) for name in columns]
    lines = [random.choice(COMMENTS) for _ in range(random.choice((0, 0, 1, 7)))]
    if random.random() < 0.9:
        lines.append(separator.join(names))
    if random.random() < 0.3:
        lines.append(separator.join(random.choice(UNITS) for _ in columns))
    for row in zip(*columns.values(), strict=True):
        cells = (cell.replace(".", decimal) for cell in row)
        lines.append(
            separator.join(cells) + random.choice(("",) * 30 + (separator, "x"))
        )
        if random.random() < 0.02:
            lines.append(random.choice((*COMMENTS, lines[0])))
    text = random.choice(("\n",) * 4 + ("\r\n", "\r")).join([*lines, ""])
    content = text.encode(
        random.choice(("utf-8",) * 5 + ("utf-16", "latin-1", "cp1252"))
    )
    if random.random() < 0.3:
        content = spoiled(random, content, mutations.TEXT)
    name = "log" + random.choice((".csv",) * 5 + (".tsv", ".txt", ".dat", ".42", ""))
    topic_map = LOG_MAP.replace("/log", "/")
    unit = random.choice(("us",) * 3 + ("s", "ns", "iso", "x"))
    files = {name: content, "map.yaml": topic_map.replace(": us", f": {unit}").encode()}
    arguments = random.choice(
        (
            ["topics", name],
            ["topics", name, "-o", "proposed.yaml"],
            ["convert", name, "--map", "map.yaml", "-o", "r.csv"],
            ["identify", "cepheus-like", name, "--method", "least-squares"],
            ["noise", name, "-o", "sensors.yaml"],
        )
    )
    return Case("tables", tuple(arguments), files)


def _times(random: Random) -> list[str]:
    """Of a counter that wraps, of a clock that is set, or as text."""
    start = random.choice((0, 1_700_000_000, 2**32 - 500_000, 2**53, -1_000_000))
    step = random.choice((50_000, 1, 0, -50_000, 2**31))
    times = [start + step * k for k in range(ROWS)]
    how = random.randrange(7)
    if how == 0:
        return [str(t % 2 ** random.choice((16, 32))) for t in times]
    if how == 1:
        return [str(t if k < ROWS // 2 else t - times[-1]) for k, t in enumerate(times)]
    if how == 2:
        zone = random.choice(("", "Z", "+02:00", " UTC", "+99:00"))
        return [
            ISO.format(k // 12 + random.choice((0, 0, 55)), k % 61, zone)
            for k in range(ROWS)
        ]
    if how == 3:
        return [f"{k:02}:{k:02}.{k}" for k in range(ROWS)]
    if how == 4:
        return [f"{t / 1e6:.6e}" for t in times]
    return [str(t) for t in times]


def _cells(random: Random, name: str) -> list[str]:
    if name == "count":
        values = [str(random.choice((0, 65535, -32768, 2**40))) for _ in range(ROWS)]
    elif name == "vector":
        vector = random.choice(
            (
                "[{0}, 0, 1]",
                "({0} 0 1)",
                '"[{0}, {0}]"',
                "[{0}",
                "[[{0}]]",
                "{0} {0}",
                "[]",
            )
        )
        values = [vector.format(k) for k in range(ROWS)]
    else:
        values = [repr(0.01 * k) for k in range(ROWS)]
    if random.random() < 0.3:
        odd = random.choice(
            (*oddities.NUMBERS[:40], "-9999", "#N/A", "NaN", "--", "ok")
        )
        values[random.randrange(ROWS)] = odd
    return values
