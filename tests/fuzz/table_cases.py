"""Text tables as laboratories write them, and as nobody should."""

from collections.abc import Mapping
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
SEPARATORS = (*(",",) * 6, ";", "\t", " ", "|", ", ", "  ")
ISO = "2024-03-01T12:{:02}:{:06.3f}{}"


def tables(random: Random, seeds: Seeds) -> Case:
    """A text table in the style of some tool, one thing of it odd."""
    name = "log" + random.choice((".csv",) * 6 + (".tsv", ".txt", ".dat", ".42", ""))
    arguments = random.choice(
        (
            ["topics", name],
            ["topics", name, "-o", "proposed.yaml"],
            ["convert", name, "--map", "map.yaml", "-o", "r.csv"],
            ["convert", name, "--map", "map.yaml", "-o", "r.csv"],
            ["identify", "paper-spatial", name, "--method", "least-squares"],
            ["noise", name, "-o", "sensors.yaml"],
        )
    )
    columns = {"timestamp": _times(random)}
    for each in ("q", "w.0", "w.1", "count", "vector")[: random.choice((3, 4, 5))]:
        columns[each] = _cells(random, each)
    if arguments[0] in {"identify", "noise"}:
        header, *rows = seeds.csv["paper-spatial"].decode().splitlines()
        cells = zip(*(row.split(",") for row in rows), strict=True)
        columns = dict(zip(header.split(","), map(list, cells), strict=True))
        if random.random() < 0.3:
            columns["t"] = _times(random, len(rows))
    content = _styled(random, columns)
    if random.random() < 0.2:
        content = spoiled(random, content, mutations.TEXT)
    unit = random.choice(("us",) * 4 + ("s", "ns", "iso", "x"))
    topic_map = LOG_MAP.replace("/log", "/").replace(": us", f": {unit}")
    files = {name: content, "map.yaml": topic_map.encode()}
    return Case("tables", tuple(arguments), files)


def _styled(random: Random, columns: Mapping[str, list[str]]) -> bytes:
    """As tools differ: separators, comments, units, commas, line ends, encodings."""
    separator = random.choice(SEPARATORS)
    decimal = "," if random.random() < 0.1 else "."
    wrapped = random.choice(("{}",) * 8 + (" {} ", '"{}"', "{} [s]"))
    comments = random.choice((0, 0, 0, 1, 7))
    lines = [random.choice(COMMENTS) for _ in range(comments)]
    if random.random() < 0.95:
        lines.append(separator.join(map(wrapped.format, columns)))
    if random.random() < 0.2:
        lines.append(separator.join(random.choice(UNITS) for _ in columns))
    rows = [
        separator.join(cell.replace(".", decimal) for cell in row)
        for row in zip(*columns.values(), strict=True)
    ]
    if random.random() < 0.2:
        k = random.randrange(len(rows))
        rows[k] += random.choice((separator, "x", separator + "1", '"'))
    if random.random() < 0.1:
        rows.insert(random.randrange(len(rows)), random.choice((*COMMENTS, *lines[:1])))
    text = random.choice(("\n",) * 6 + ("\r\n", "\r")).join([*lines, *rows, ""])
    encoding = random.choice(("utf-8",) * 9 + ("utf-16", "latin-1", "utf-8-sig"))
    return text.encode(encoding, errors="replace")


def _times(random: Random, count: int = ROWS) -> list[str]:
    """Of a counter that wraps, of a clock that is set, or as text."""
    start = random.choice((0, 1_700_000_000, 2**32 - 500_000, 2**53, -1_000_000))
    step = random.choice((50_000, 1, 0, -50_000, 2**31))
    times = [start + step * k for k in range(count)]
    how = random.randrange(7)
    if how == 0:
        return [str(t % 2 ** random.choice((16, 32))) for t in times]
    if how == 1:
        return [
            str(t if k < count // 2 else t - times[-1]) for k, t in enumerate(times)
        ]
    if how == 2:
        zone = random.choice(("", "Z", "+02:00", " UTC", "+99:00"))
        return [
            ISO.format(k // 12 + random.choice((0, 0, 55)), k % 61, zone)
            for k in range(count)
        ]
    if how == 3:
        return [f"{k:02}:{k:02}.{k}" for k in range(count)]
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
