"""PX4's logs, ULog, by the library pyulog."""

import io
import struct
from contextlib import ExitStack, redirect_stdout
from pathlib import Path

from orbident.errors import InputError
from orbident.extras import extra
from orbident.recordings.logs.group import LogField, Tree, in_memory

MAGIC = b"ULog\x01\x12\x35"
_VERSIONS = (b"\x00", b"\x01")
_HEADER_BYTES = 16
"""Magic, version, and a time."""


def read_ulog(path: Path, stack: ExitStack) -> Tree:
    """Topics; the second instance of one is `name.1`, and `x[0]` is `x.0`.

    Raises:
        InputError: Another version, or damage in the middle.
        MissingLibraryError: pyulog is not installed.
    """
    del stack
    with extra("ulog", "reading a PX4 log"):
        from pyulog import ULog
    with path.open("rb") as file:
        version = file.read(_HEADER_BYTES)[7:8]
    if version not in _VERSIONS:
        raise InputError(
            f"{path}: is a ULog of version {version[0] if version else 'none'}, but "
            "only version 1 is known; record with PX4 1.4 or later"
        )
    # The library prints what it finds odd.
    with redirect_stdout(io.StringIO()):
        log = ULog(str(path))
    if log.file_corruption:
        raise InputError(f"{path}: is damaged; copy it again from the vehicle")
    return {_name(each): _fields(each.data) for each in log.data_list}


def _name(dataset: object) -> str:
    name, instance = vars(dataset)["name"], vars(dataset)["multi_id"]
    return f"{name}.{instance}" if instance else name


def _fields(data: dict) -> Tree:
    fields: dict[str, LogField | Tree] = {}
    for name, values in data.items():
        unit = "us" if name == "timestamp" else ""
        fields[name.replace("[", ".").replace("]", "")] = in_memory(values, unit)
    return fields


def cut_off(path: Path) -> tuple[str, ...]:
    """A warning if the file ends within a message, as it does when power is lost."""
    size, at = path.stat().st_size, _HEADER_BYTES
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
