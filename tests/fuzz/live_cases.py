"""What `live` is sent: times of any zero and unit, any order, several senders, junk."""

import io
import json
import zipfile
from collections.abc import Callable
from random import Random

import mutations
import numpy as np
import oddities
from case import CLOSED, STDIN, Case
from mutations import spoiled
from seeds import Seeds

Rows = list[list[str]]
"""Cells of each sample, its time first."""

UNITS = (1e-300, 1e-12, 1e-7, 1e-3, 0.0, -1.0, 1e3, 1e6, 1e9, 1e300)
ZEROS = (-1e9, 1.0, 1e3, 1e9, 1.7e9, 1.7e18)
OFFSETS = (0.0, 1e-9, 0.01, -3.0, 3.0, 100.0, -1e9, 1e9)
"""From the times of one sender to those of another, s."""
JUNK = (
    *(b"{}", b"[]", b"null", b"1", b'"t"', b'{"t": 1}', b'{"t": NaN}', b'{"t": []}'),
    *(b'{"t": 1e999}', b"[" * 10_000, b'{"a":' * 10_000, b",,,,", b"t", b"t,t,gyro.x"),
    *(b"t,gyro.x,gyro.y,gyro.z", b"1," * 40_000, b"# comment", b"nan," * 30, b"\xff"),
)


def live(random: Random, seeds: Seeds) -> Case:
    """A stream that no recorder should send, and a state file that anybody wrote."""
    header, *lines = seeds.stream.decode().splitlines()
    rows = [line.split(",") for line in lines]
    for _ in range(random.choice((0, 1, 1, 2))):
        rows = random.choice(CHANGES)(random, rows)
    sent = [header.encode(), *(",".join(row).encode() for row in rows)]
    if random.random() < 0.3:
        names = header.split(",")
        sent = [_as_object(random, names, row) for row in rows]
    for _ in range(random.choice((0, 0, 1, 5, 50))):
        sent.insert(random.choice((0, random.randrange(len(sent) + 1))), _junk(random))
    files = {STDIN: b"\n".join(sent) + random.choice((b"", b"\n"))}
    if random.random() < 0.2:
        files[STDIN] = spoiled(random, files[STDIN], mutations.TEXT)
    arguments = ["live", random.choice(("paper-spatial",) * 9 + ("cepheus-like",))]
    arguments += ["--every", random.choice(("1", "0.01", "1e-9", "1e300"))]
    std = random.choice(("1e-3",) * 6 + ("1e-300", "1e9", "1e300"))
    arguments += random.choice(([], *(["--velocity-std", std],) * 3))
    if random.random() < 0.5:
        arguments += ["--state", "state"]
        if random.random() < 0.7:
            files["state"] = spoiled(random, seeds.state, STATE)
    setting = CLOSED if random.random() < 0.03 else ""
    return Case("live", tuple(arguments), files, setting)


def _as_object(random: Random, names: list[str], row: list[str]) -> bytes:
    values = (cell if cell in {"", "x"} else float(cell) for cell in row)
    cells = dict(zip(names, values, strict=True))
    if random.random() < 0.02:
        cells[random.choice(names)] = oddities.value(random)
    return json.dumps(cells).encode()


def _junk(random: Random) -> bytes:
    return random.choice((*JUNK, *oddities.BYTES))


def _timed(rows: Rows, scale: float, zero: float) -> Rows:

    def moved(cell: str) -> str:
        # It may have been spoiled already.
        try:
            return repr(scale * float(cell) + zero)
        except ValueError:
            return cell

    return [[moved(t), *cells] for t, *cells in rows]


def _other_times(random: Random, rows: Rows) -> Rows:
    scale = random.choice((1.0, random.choice(UNITS)))
    return _timed(rows, scale, random.choice((0.0, *ZEROS)))


def _stepped(random: Random, rows: Rows) -> Rows:
    """The clock is set anew, or counts in another unit from somewhere on."""
    k = random.randrange(len(rows) + 1)
    scale = random.choice((1.0, 1.0, random.choice(UNITS)))
    return rows[:k] + _timed(rows[k:], scale, random.choice(OFFSETS))


def _shuffled(random: Random, rows: Rows) -> Rows:
    size = random.choice((2, 5, 50, len(rows) or 1))
    blocks = [rows[k : k + size] for k in range(0, len(rows), size)]
    for block in blocks:
        random.shuffle(block)
    return [row for block in blocks for row in block]


def _reversed(_: Random, rows: Rows) -> Rows:
    return rows[::-1]


def _two_senders(random: Random, rows: Rows) -> Rows:
    copies = _timed(rows, random.choice((1.0, 1.0, -1.0, 1e3)), random.choice(OFFSETS))
    every = random.choice((1, 1, 2, 10))
    return [
        row
        for k, pair in enumerate(zip(rows, copies, strict=True))
        for row in (pair if k % every == 0 else pair[:1])
    ]


def _lost(random: Random, rows: Rows) -> Rows:
    kept = min(random.choice((0, 1, 2, 49, 51, len(rows) // 3)), len(rows))
    return [rows[k] for k in sorted(random.sample(range(len(rows)), kept))]


def _odd_cells(random: Random, rows: Rows) -> Rows:
    rows = [list(row) for row in rows]
    column = random.randrange(len(rows[0])) if rows else 0
    share = random.choice((0.01, 0.3, 1.0))
    size = random.choice(("nan", "", "1e300", "-9999", "0", "1e-300", "x"))
    for row in rows:
        if random.random() < share:
            row[column] = size
    return rows


Change = Callable[[Random, Rows], Rows]
CHANGES: tuple[Change, ...] = (_other_times, _stepped, _shuffled, _two_senders) * 2
CHANGES += (_reversed, _lost, _odd_cells)


# State files.


def in_archive(random: Random, content: bytes) -> bytes:
    """An array of an NPZ file has other numbers, another shape or type, or is gone."""
    with np.load(io.BytesIO(content)) as file:
        arrays = {name: file[name] for name in file.files}
    name = random.choice(list(arrays))
    arrays[name] = random.choice(ARRAY_CHANGES)(random, arrays[name])
    if random.random() < 0.1:
        del arrays[name]
    if random.random() < 0.1:
        arrays[random.choice(list(arrays) or ["x"])] = np.array(oddities.word(random))
    written = io.BytesIO()
    np.savez(written, **arrays)  # pyright: ignore[reportArgumentType]
    return written.getvalue()


def _one_number(random: Random, array: np.ndarray) -> np.ndarray:
    array = array.astype(float)
    odd = (np.nan, np.inf, -1.0, 0.0, 1e308, 1e-320, 1e9, 2.5)
    array.reshape(-1)[random.randrange(array.size)] = random.choice(odd)
    return array


def _other_shape(random: Random, array: np.ndarray) -> np.ndarray:
    shapes = (array[..., :0], array.reshape(-1), array[None], array.reshape(-1)[:1])
    return random.choice(shapes)


def _other_type(random: Random, array: np.ndarray) -> np.ndarray:
    return array.astype(random.choice(("f4", "i8", "c16", "?", "U", "S", "O")))


def _other_array(random: Random, _: np.ndarray) -> np.ndarray:
    value = random.choice((5, "5", "{}", '{"a": []}', "[" * 10_000, None))
    return np.array(value)


ARRAY_CHANGES = (_one_number,) * 4 + (_other_shape, _other_type, _other_array)


def bomb(_: Random, content: bytes) -> bytes:
    """A member that is a thousand times as large as the file."""
    written = io.BytesIO(content)
    with zipfile.ZipFile(written, "a", zipfile.ZIP_DEFLATED) as archive:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            head, {"descr": "<f8", "fortran_order": False, "shape": (12_500_000,)}
        )
        archive.writestr("more.npy", head.getvalue() + bytes(100_000_000))
    return written.getvalue()


STATE = (in_archive,) * 8 + mutations.BINARY + (bomb,)
