"""Files of other tools, by those tools' own writers; ULog by its specification."""

import struct
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
from scipy.io import savemat

Tables = Mapping[str, Mapping[str, np.ndarray]]
"""Columns by the name of their table."""

KINDS = ("mat", "mat-7", "mat-7.3", "hdf5", "npz", "ulog", "csv", "parquet")


def write_log(kind: str, folder: Path, tables: Tables) -> Path:
    """A file with these tables; one of CSV or Parquet is flat, and has the first."""
    return _WRITERS[kind](folder / f"log{_SUFFIXES.get(kind, '.' + kind)}", tables)


def _mat(path: Path, tables: Tables) -> Path:
    savemat(path, {name: dict(table) for name, table in tables.items()})
    return path


def _mat_7(path: Path, tables: Tables) -> Path:
    whole = {name: dict(table) for name, table in tables.items()}
    savemat(path, whole, do_compression=True)
    return path


def _hdf5(path: Path, tables: Tables) -> Path:
    with h5py.File(path, "w") as file:
        for name, table in tables.items():
            for field, values in table.items():
                file[f"{name}/{field}"] = values
    return path


def _npz(path: Path, tables: Tables) -> Path:
    arrays = {
        f"{name}.{field}": values
        for name, table in tables.items()
        for field, values in table.items()
    }
    np.savez(path, **arrays)  # pyright: ignore[reportArgumentType]
    return path


def _csv(path: Path, tables: Tables) -> Path:
    columns = _flat(tables)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def _parquet(path: Path, tables: Tables) -> Path:
    parquet.write_table(pa.table(_flat(tables)), path)
    return path


def _flat(tables: Tables) -> dict[str, np.ndarray]:
    return {
        f"{name}.{k}" if values.ndim > 1 else name: column
        for name, values in next(iter(tables.values())).items()
        for k, column in enumerate(np.atleast_2d(values.T))
    }


def write_mat_73(path: Path, tables: Tables) -> Path:
    """As MATLAB's `save -v7.3` does: HDF5 after 512 bytes, matrices transposed."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, table in tables.items():
            group = file.create_group(name)
            group.attrs["MATLAB_class"] = np.bytes_("struct")
            for field, values in table.items():
                matrix = values.reshape(len(values), -1)
                group[field] = matrix.T
                group[field].attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as file:
        file.write(head)
    return path


def write_ulog(path: Path, tables: Tables, version: int = 1) -> Path:
    """Write a PX4 log of flags, formats, subscriptions and data (messages B, F, A, D).

    The format is at https://docs.px4.io/main/en/dev_log/ulog_file_format.

    The first column is the time in microseconds, named timestamp. A table `x.1` is the
    second instance of `x`.
    """
    content = b"ULog\x01\x12\x35" + bytes([version]) + struct.pack("<Q", 0)
    content += _message("B", bytes(40))
    for table in {name.split(".")[0]: t for name, t in tables.items()}.items():
        content += _message("F", _format(*table).encode())
    rows = []
    for number, (name, table) in enumerate(tables.items()):
        topic, _, instance = name.partition(".")
        subscribed = struct.pack("<BH", int(instance or 0), number) + topic.encode()
        content += _message("A", subscribed)
        columns = [c for v in table.values() for c in np.atleast_2d(v.T)]
        for row in zip(*columns, strict=True):
            body = struct.pack(f"<HQ{len(row) - 1}d", number, int(row[0]), *row[1:])
            rows.append((int(row[0]), _message("D", body)))
    content += b"".join(data for _, data in sorted(rows, key=lambda row: row[0]))
    path.write_bytes(content)
    return path


def _format(name: str, table: Mapping[str, np.ndarray]) -> str:
    fields = [
        f"double[{values.shape[1]}] {field}" if values.ndim > 1 else f"double {field}"
        for field, values in list(table.items())[1:]
    ]
    return f"{name}:" + ";".join(["uint64_t timestamp", *fields]) + ";"


def _message(kind: str, body: bytes) -> bytes:
    return struct.pack("<H", len(body)) + kind.encode() + body


_SUFFIXES = {"mat-7": ".mat", "mat-7.3": ".mat", "hdf5": ".h5", "ulog": ".ulg"}
_WRITERS = {
    "mat": _mat,
    "mat-7": _mat_7,
    "mat-7.3": write_mat_73,
    "hdf5": _hdf5,
    "npz": _npz,
    "ulog": write_ulog,
    "csv": _csv,
    "parquet": _parquet,
}
