"""A file of tables of any kind, open for reading.

NumPy's .npz files are such files too, as one saves what Basilisk's recorders hold;
nothing pickled is read.
"""

import io
import struct
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import one_line, quoted
from orbident.files.text import unreadable
from orbident.recordings.logs.arrow_file import (
    SUFFIXES,
    read_parquet_log,
    read_text_folder,
    read_text_table,
    text_tables_in,
)
from orbident.recordings.logs.group import (
    LogField,
    Tree,
    field_of,
    groups,
    in_memory,
    unusable,
)
from orbident.recordings.logs.hdf5_file import MAGIC as HDF5_MAGIC
from orbident.recordings.logs.hdf5_file import read_hdf5
from orbident.recordings.logs.mat5 import read_mat
from orbident.recordings.source import RawMessage, Source

_PICKLED = (
    "holds Python objects, which are never loaded because loading may run a program; "
    "save an array of numbers: np.savez(..., x=np.asarray(x, dtype=float))"
)


def read_npz(path: Path, stack: ExitStack) -> Tree:
    """Arrays by name; dots and slashes in a name lead into groups."""
    stack.enter_context(zipfile.ZipFile(path))
    arrays = stack.enter_context(np.load(path, allow_pickle=False))
    tree: dict[str, Any] = {}
    for name in arrays.files:
        *groups, last = name.replace("/", ".").split(".")
        node = tree
        for each in groups:
            inner = node.setdefault(each, {})
            node = inner if isinstance(inner, dict) else tree
        node[last if last not in node else name] = _field(arrays, name)
    return tree


def _field(arrays: Any, name: str) -> LogField | Tree:
    with arrays.zip.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read = np.lib.format.read_array_header_2_0
        shape, _, dtype = read(file)
    if dtype.hasobject:
        return unusable(_PICKLED)
    # Basilisk's recorders count time in whole nanoseconds.
    unit = "ns" if name.endswith("times") and dtype.kind in "iu" else ""
    return field_of(shape, dtype, lambda: arrays[name], unit)


_ULOG_MAGIC = b"ULog\x01\x12\x35"
_ULOG_VERSIONS = (b"\x00", b"\x01")
_ULOG_HEADER_BYTES = 16
"""Magic, version, and a time."""


def read_ulog(path: Path, stack: ExitStack) -> Tree:
    """Topics of a PX4 log; the second instance of one is `name.1`, `x[0]` is `x.0`.

    Raises:
        InputError: Another version, or damage in the middle.
        MissingLibraryError: pyulog is not installed.
    """
    with extra("ulog", "reading a PX4 log"):
        from pyulog import ULog
    with path.open("rb") as file:
        version = file.read(_ULOG_HEADER_BYTES)[7:8]
    if version not in _ULOG_VERSIONS:
        raise InputError(
            f"{path}: is a ULog of version {version[0] if version else 'none'}, but "
            "only version 1 is known; record with PX4 1.4 or later"
        )
    # The library prints what it finds odd.
    with redirect_stdout(io.StringIO()):
        log = ULog(str(path))
    if log.file_corruption:
        raise InputError(f"{path}: is damaged; copy it again from the vehicle")
    return {_topic(each): _of_topic(each.data) for each in log.data_list}


def _topic(dataset: object) -> str:
    name, instance = vars(dataset)["name"], vars(dataset)["multi_id"]
    return f"{name}.{instance}" if instance else name


def _of_topic(data: dict) -> Tree:
    units = {"timestamp": "us"}
    return {
        name.replace("[", ".").replace("]", ""): in_memory(values, units.get(name, ""))
        for name, values in data.items()
    }


def _cut_off(path: Path) -> tuple[str, ...]:
    """A warning if the file ends within a message, as it does when power is lost."""
    size, at = path.stat().st_size, _ULOG_HEADER_BYTES
    with path.open("rb") as file:
        # From message to message: each says its length.
        while at + 3 <= size:
            file.seek(at)
            at += 3 + struct.unpack("<H", file.read(2))[0]
    if at == size:
        return ()
    return (
        f"{path}: ends within a message, so it is cut off: what is before is used; "
        "copy it again from the vehicle, unless that lost power",
    )


@dataclass(frozen=True)
class FileKind:
    """A kind of file."""

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path, ExitStack], Tree]
    begins: tuple[bytes, ...] = ()
    """What its first bytes are; nothing where they may be any."""
    notes: Callable[[Path], tuple[str, ...]] = lambda path: ()
    """What a person should know of a file that can be read."""


KINDS = (
    FileKind("MATLAB", (".mat",), read_mat, (b"MATLAB",)),
    FileKind("HDF5", (".h5", ".hdf5", ".hdf", ".he5"), read_hdf5, (HDF5_MAGIC,)),
    FileKind("PX4 ULog", (".ulg", ".ulog"), read_ulog, (_ULOG_MAGIC,), _cut_off),
    FileKind("NumPy", (".npz",), read_npz, (b"PK\x03\x04",)),
    FileKind("Parquet", (".parquet",), read_parquet_log, (b"PAR1",)),
    FileKind("CSV", SUFFIXES, read_text_table),
)
_FOLDER = FileKind("text tables", (), read_text_folder)
_BY_SUFFIX = {suffix: kind for kind in KINDS for suffix in kind.suffixes}


def is_log(path: Path) -> bool:
    """Whether it is a file of tables by its suffix, or a folder of such text files."""
    if path.is_dir():
        return not (path / "metadata.yaml").exists() and bool(text_tables_in(path))
    return path.suffix.lower() in _BY_SUFFIX


@contextmanager
def open_log(path: Path) -> Iterator[Source]:
    """A file of tables that exists; its suffix says of which kind.

    Raises:
        InputError: It is of another kind, damaged or empty, or the
            library that reads it is not installed.
    """
    kind = _FOLDER if path.is_dir() else _BY_SUFFIX[path.suffix.lower()]
    with ExitStack() as stack:
        try:
            if kind is not _FOLDER:
                _check_start(path, kind)
            found = groups(kind.read(path, stack), str(path))
        except InputError:
            raise
        except RecursionError:
            raise InputError(
                f"{path}: has too many levels of groups or structs, one in another; "
                "write tables that are not nested"
            ) from None
        # What the libraries raise over damaged bytes is of any kind.
        except Exception as error:
            if isinstance(error, OSError) and error.errno:
                raise unreadable(path, error) from error
            raise InputError(
                f"{path}: is damaged or no {kind.name} file ({one_line(error)}); copy "
                "or write it again"
            ) from error
        if not any(group.count for group in found.values()):
            fields = (f for group in found.values() for f in group.fields.items())
            first = next((f": {quoted(name)} {f.problem}" for name, f in fields), "")
            raise InputError(
                f"{path}: holds no arrays of numbers over time{first}; record again, "
                "or save numbers"
            )
        yield Source(
            path,
            found,
            lambda names: (RawMessage(name, 0, found[name]) for name in names),
            kind.notes(path),
        )


_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
"""What text in UTF-16 begins with."""


def _check_start(path: Path, kind: FileKind) -> None:
    """Refuse what is not what its suffix says."""
    with path.open("rb") as file:
        start = file.read(16)
    if not start:
        raise InputError(f"{path}: is empty; record again")
    for other in KINDS:
        if other is not kind and start.startswith(other.begins or (b"\0" * 17,)):
            raise InputError(
                f"{path}: is by its content a file of {other.name}, not {kind.name}; "
                f"rename it to {path.stem}{other.suffixes[0]}"
            )
    if start.startswith(_UTF_16):
        raise InputError(
            f"{path}: is text in UTF-16, which is not read; save it as CSV in UTF-8"
        )
    # It begins with the type of a matrix, a number below 5000.
    first = int.from_bytes(start[:4], "little"), int.from_bytes(start[:4])
    if kind.name == "MATLAB" and min(first) < 5000:
        raise InputError(
            f"{path}: is a MATLAB file of version 4, which is not read; load it in "
            "MATLAB and save it again with 'save -v7'"
        )
    if kind.begins and not start.startswith(kind.begins):
        raise InputError(
            f"{path}: does not begin as a {kind.name} file does; write it again"
            + (", with 'save -v7'" if kind.name == "MATLAB" else "")
        )
