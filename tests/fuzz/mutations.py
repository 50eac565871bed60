"""Ways to spoil a valid file."""

import io
import json
import re
from collections.abc import Callable
from random import Random
from typing import Any

import oddities
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

Mutation = Callable[[Random, bytes], bytes]


def spoiled(random: Random, content: bytes, ways: tuple[Mutation, ...]) -> bytes:
    """A file after one of these ways, or two of them.

    What the first has left may be no file of its kind any more: then bytes are changed.
    """
    for _ in range(random.choice((1, 1, 1, 2))):
        try:
            content = random.choice(ways)(random, content)
        except Exception:
            content = flipped(random, content)
    return content


# Of any file.


def cut(random: Random, content: bytes) -> bytes:
    """As a writer that was killed leaves it."""
    return content[: random.randrange(len(content) + 1)]


def flipped(random: Random, content: bytes) -> bytes:
    """Some bytes replaced by any others."""
    changed = bytearray(content)
    for _ in range(random.choice((1, 2, 10))):
        if changed:
            changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def inserted(random: Random, content: bytes) -> bytes:
    """Bytes that are no text, or belong to another format."""
    at = random.choice((0, random.randrange(len(content) + 1)))
    return content[:at] + random.choice(oddities.BYTES) + content[at:]


def doubled(random: Random, content: bytes) -> bytes:
    """A piece stands twice, or the whole."""
    start, end = sorted(random.randrange(len(content) + 1) for _ in range(2))
    return content[:end] + content[start:]


def emptied(random: Random, content: bytes) -> bytes:
    """Nothing, or only white space."""
    return random.choice((b"", b"\n", b" " * 1000, b"\0" * 100))


def recoded(random: Random, content: bytes) -> bytes:
    """The text in another encoding."""
    text = content.decode(errors="replace")
    return text.encode(random.choice(("utf-16", "utf-32", "utf-8-sig", "utf-7")))


BINARY = (cut, flipped, inserted, doubled, emptied)


# Of text.

NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9-]*")


def replaced(
    random: Random, content: bytes, found: re.Pattern[bytes], by: Callable[[], str]
) -> bytes:
    """One match of the pattern stands for other text."""
    places = list(found.finditer(content))
    if not places:
        return content
    place = random.choice(places)
    new = by().encode(errors="surrogatepass")
    return content[: place.start()] + new + content[place.end() :]


def odd_number(random: Random, content: bytes) -> bytes:
    """A number is another one, or none."""
    return replaced(random, content, NUMBER, lambda: oddities.number(random))


def other_number(random: Random, content: bytes) -> bytes:
    """A number is another one that might be meant."""
    places = list(NUMBER.finditer(content))
    if not places:
        return content
    place = random.choice(places)
    factor = random.choice((-1.0, 0.0, 1e-6, 0.1, 0.5, 0.99, 1.01, 2.0, 10.0, 1e6))
    new = repr(factor * float(place.group())).encode()
    return content[: place.start()] + new + content[place.end() :]


def odd_word(random: Random, content: bytes) -> bytes:
    """A word is another one."""
    return replaced(random, content, WORD, lambda: oddities.word(random))


def swapped_words(random: Random, content: bytes) -> bytes:
    """A word of the file stands where another one was."""
    words = WORD.findall(content) or [b""]
    other = random.choice(words).decode(errors="replace")
    return replaced(random, content, WORD, lambda: other)


def lines_changed(random: Random, content: bytes) -> bytes:
    """A line is gone, stands twice, or stands elsewhere."""
    lines = content.splitlines(keepends=True) or [b""]
    k, other = random.randrange(len(lines)), random.randrange(len(lines))
    line = lines[k]
    how = random.randrange(3)
    if how != 1:
        del lines[k]
    if how != 0:
        lines.insert(other, line)
    return b"".join(lines)


TEXT = (odd_number, other_number) * 4 + (odd_word, swapped_words, lines_changed) * 2
TEXT += (*BINARY, recoded)


# Of documents in YAML or JSON.


def in_tree(random: Random, content: bytes) -> bytes:
    """A node of the document has another value, another key, or is gone."""
    document = yaml.safe_load(content)
    _spoil_node(random, document)
    return yaml.safe_dump(document, sort_keys=False, allow_unicode=True).encode()


def in_json(random: Random, content: bytes) -> bytes:
    """The same, as JSON."""
    document = json.loads(content)
    _spoil_node(random, document)
    return json.dumps(document).encode()


def _spoil_node(random: Random, document: Any) -> None:
    holders = [node for node in _nodes(document) if node]
    if not holders:
        return
    node = random.choice(holders)
    keys = list(node) if isinstance(node, dict) else list(range(len(node)))
    key = random.choice(keys)
    how = random.randrange(4)
    if how == 0:
        del node[key]
    elif how == 1 and isinstance(node, dict):
        node[oddities.word(random)] = node.pop(key)
    elif how == 2 and isinstance(node, list):
        node.append(node[key])
    else:
        node[key] = oddities.value(random)


def _nodes(document: Any) -> list[Any]:
    if isinstance(document, dict):
        below = [each for value in document.values() for each in _nodes(value)]
        return [document, *below]
    if isinstance(document, list):
        return [document, *(each for value in document for each in _nodes(value))]
    return []


YAML = (in_tree,) * 6 + TEXT
JSON = (in_json,) * 10 + TEXT


# Of recordings.

Columns = dict[str, list[Any]]


def in_csv(random: Random, content: bytes) -> bytes:
    """Columns and rows of a CSV file are changed as a laboratory changes them."""
    lines = [line.split(",") for line in content.decode().splitlines()]
    columns = {name: list(cells) for name, *cells in zip(*lines, strict=True)}
    changed = _columns_changed(random, columns)
    length = max(map(len, changed.values()), default=0)
    rows = [
        ",".join(str(cells[k]) if k < len(cells) else "" for cells in changed.values())
        for k in range(length)
    ]
    separator = random.choice(("\n",) * 8 + ("\r\n", "\r"))
    return separator.join([",".join(changed), *rows, ""]).encode()


def in_parquet(random: Random, content: bytes) -> bytes:
    """The same of a Parquet file, whose columns have types too."""
    table = pq.read_table(io.BytesIO(content))
    columns = {name: table[name].to_pylist() for name in table.column_names}
    changed = _columns_changed(random, columns)
    length = min(map(len, changed.values()), default=0)
    arrays = [_array(random, cells[:length]) for cells in changed.values()]
    written = io.BytesIO()
    compression = random.choice(("snappy", "gzip", "zstd", "none"))
    made = pa.Table.from_arrays(arrays, list(changed))
    pq.write_table(made, written, compression=compression)
    return written.getvalue()


def _array(random: Random, cells: list[Any]) -> pa.Array:
    kinds = ("float64",) * 20 + ("float32", "int64", "string", "bool", "list", "null")
    kind = random.choice(kinds)
    if kind == "list":
        return pa.array([[x] for x in cells], pa.list_(pa.float64()), safe=False)
    if kind == "null":
        return pa.nulls(len(cells))
    if kind == "string":
        return pa.array([str(x) for x in cells])
    numbers = pa.array([_float(x) for x in cells], pa.float64())
    if kind == "bool":
        return pa.array([x == x and x is not None for x in cells])
    return numbers.cast(kind, safe=False)


def _float(cell: Any) -> float | None:
    try:
        return None if cell is None else float(cell)
    except ValueError:
        return None


def _columns_changed(random: Random, columns: Columns) -> Columns:
    change = random.choice(COLUMN_CHANGES)
    name = random.choice([each for each in columns if each != "t"] + ["t"] * 3)
    return change(random, columns, name)


def _dropped(random: Random, columns: Columns, name: str) -> Columns:
    start = random.choice((name, name.partition(".")[0]))
    return {n: cells for n, cells in columns.items() if not n.startswith(start)}


def _renamed(random: Random, columns: Columns, name: str) -> Columns:
    new = random.choice((oddities.word(random), random.choice(list(columns))))
    new = re.sub(r"[\r\n,]", " ", new)
    return {(new if n == name else n): cells for n, cells in columns.items()}


def _one_cell(random: Random, columns: Columns, name: str) -> Columns:
    cells = list(columns[name])
    if cells:
        odd = oddities.number(random).replace(",", ";")
        cells[random.randrange(len(cells))] = odd
    return columns | {name: cells}


def _all_cells(random: Random, columns: Columns, name: str) -> Columns:
    return columns | {name: [oddities.number(random)] * len(columns[name])}


def _scaled(random: Random, columns: Columns, name: str) -> Columns:
    factor = random.choice((0.0, -1.0, 57.3, 1e-3, 1e9, 1e30, 1e154, 1e200, 1e-200))
    kind = name.partition(".")[0]
    return {
        n: [factor * (_float(x) or 0.0) for x in cells] if n.startswith(kind) else cells
        for n, cells in columns.items()
    }


def _noisy(random: Random, columns: Columns, name: str) -> Columns:
    size = 10 ** random.uniform(-6, 6)
    cells = [(_float(x) or 0.0) + random.gauss(0, size) for x in columns[name]]
    return columns | {name: cells}


def _rows(random: Random, columns: Columns, name: str) -> Columns:
    length = len(columns[name])
    kept = random.choice(
        (
            range(random.choice((0, 1, 2, 3, 5, 8, 13, 21))),
            range(length - 1, -1, -1),
            [0] * length,
            sorted(random.sample(range(length), max(1, length // 3))),
            random.sample(range(length), length),
            [*range(length), *range(length)],
        )
    )
    return {
        n: [cells[k] for k in kept if k < len(cells)] for n, cells in columns.items()
    }


def _gap(random: Random, columns: Columns, name: str) -> Columns:
    """A sensor that fails for a while, or that all rows of one time lack."""
    length = len(columns[name])
    start, end = sorted(random.randrange(length + 1) for _ in range(2))
    start_of_name = random.choice((name, name.partition(".")[0]))
    return {
        n: [*cells[:start], *["" if n != "t" else "0"] * (end - start), *cells[end:]]
        if n.startswith(start_of_name)
        else cells
        for n, cells in columns.items()
    }


def _held(random: Random, columns: Columns, name: str) -> Columns:
    """The value of another column."""
    return columns | {name: columns[random.choice(list(columns))]}


def _added(random: Random, columns: Columns, name: str) -> Columns:
    odd = ("gyro.w", "joint..position", "joint.joint1.effort", "truth.gyro.x", "T", "x")
    return columns | {random.choice(odd): columns[name]}


COLUMN_CHANGES = (
    (_dropped, _renamed, _added, _held)
    + (_one_cell, _all_cells, _scaled, _rows, _gap) * 2
    + (_noisy,)
)

CSV = (in_csv,) * 10 + TEXT
PARQUET = (in_parquet,) * 10 + BINARY
