"""Files of other tools with what those tools may write and no recorder does."""

import contextlib
import io
import sqlite3
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import h5py
import mutations
import numpy as np
from case import Case
from mutations import spoiled
from scipy.io import savemat
from seeds import LOG_MAP, MAP, Seeds

COUNT = 20
LARGE = 10_000_000
"""Numbers that pack to a thousandth."""


def archives(random: Random, seeds: Seeds) -> Case:
    """A table beside odd members, or a bag whose folder somebody has tidied."""
    if random.random() < 0.4:
        return _bag(random, seeds)
    suffix = random.choice(list(WRITERS))
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"log{suffix}"
        WRITERS[suffix](random, path)
        content = path.read_bytes()
    if random.random() < 0.1:
        content = spoiled(random, content, mutations.BINARY)
    files = {f"log{suffix}": content, "map.yaml": LOG_MAP.encode()}
    return _read(random, f"log{suffix}", files)


def _read(random: Random, name: str, files: dict[str, bytes]) -> Case:
    to = random.choice((["topics"], ["convert"]))
    rest = ["--map", "map.yaml", "-o", "r.csv"] if to == ["convert"] else []
    return Case("archives", (*to, name, *rest), files)


def _table() -> dict[str, Any]:
    t = np.arange(COUNT) * 1e4
    return {"timestamp": t, "q": t / 1e6, "w": np.ones((COUNT, 3))}


def _odd(random: Random) -> Any:
    """Values that a workspace may hold."""
    nested: Any = 1.0
    for _ in range(random.choice((3, 200))):
        nested = {"a": nested}
    cells = np.empty((2, 2), dtype=object)
    cells[:] = [["x", 1.0], [np.ones(3), None]]
    return random.choice(
        (
            *(np.array([]), np.zeros((0, 3)), np.float64(1), "text", "", 1j, True),
            *(np.ones((2, 3, COUNT)), np.full(COUNT, np.nan), np.array(["a", "bc"])),
            *(np.zeros(LARGE), np.zeros((1, 1, 1, 1, 5)), np.arange(COUNT, dtype="u8")),
            *(np.full(COUNT, 2**63, dtype="u8"), np.ones(COUNT, "f4"), nested),
            *(np.full(COUNT, 1e308), np.ones(COUNT, bool), np.ones(COUNT + 1)),
            [_table(), _table()],
            cells if random.random() < 0.5 else "cells",
        )
    )


def _mixed(random: Random) -> dict[str, Any]:
    members: dict[str, Any] = {"log": _table(), "other": _odd(random)}
    if random.random() < 0.5:
        members["log"][random.choice(("timestamp", "q", "w", "more"))] = _odd(random)
    return members


def _mat(random: Random, path: Path) -> None:
    members = {key: value for key, value in _mixed(random).items() if value is not None}
    try:
        savemat(path, members, do_compression=random.random() < 0.5, oned_as="column")
    # It writes neither everything that NumPy holds, nor deep structures.
    except (TypeError, ValueError, RecursionError):
        savemat(path, {"log": _table()})


def _npz(random: Random, path: Path) -> None:
    arrays = {f"log.{name}": values for name, values in _table().items()}
    arrays[random.choice(("log.more", "log.q", "/x", "../x", "", "a" * 300))] = (
        np.asarray(_odd(random))
    )
    write = random.choice((np.savez, np.savez_compressed))
    write(path, **arrays)
    if random.random() < 0.3:
        shape = random.choice(((10**15,), (2**62, 2**62), (-1,), (3,), ()))
        kind = random.choice(("<f8", "|O", "<U9", "|V8", [("a", "<f8")], "<M8[ns]"))
        head = io.BytesIO()
        header = {"descr": kind, "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(head, header)
        with zipfile.ZipFile(path, "a") as archive:
            archive.writestr(random.choice(("log.z.npy", "z")), head.getvalue())


def _hdf5(random: Random, path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, values in _table().items():
            file[f"log/{name}"] = values
        for _ in range(random.choice((1, 2))):
            # A name may be there already.
            with contextlib.suppress(
                KeyError, TypeError, ValueError, OSError, RuntimeError
            ):
                random.choice(HDF5)(file["log"], random.choice(("more", "x/y")))


def _external(group: Any, name: str) -> None:
    outside = [("/etc/passwd", 0, 8 * COUNT)]
    group.create_dataset(name, (COUNT,), "<f8", external=outside)


def _virtual(group: Any, name: str) -> None:
    layout = h5py.VirtualLayout((COUNT,), "f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", (COUNT,))
    group.create_virtual_dataset(name, layout)


def _endless(group: Any, name: str) -> None:
    group[name] = group


def _references(group: Any, name: str) -> None:
    group.create_dataset(name, data=np.array([group.ref] * COUNT, h5py.ref_dtype))


def _texts(group: Any, name: str) -> None:
    group.create_dataset(name, data=["a"] * COUNT, dtype=h5py.string_dtype())


def _sequences(group: Any, name: str) -> None:
    made = group.create_dataset(name, (COUNT,), h5py.vlen_dtype("f8"))
    made[0] = [1, 2, 3]


HDF5: tuple[Callable[[Any, str], Any], ...] = (
    *(_external, _virtual, _endless, _references, _texts, _sequences),
    lambda group, name: group.create_dataset(name, (10**12,), "f8", chunks=(1000,)),
    lambda group, name: group.create_dataset(
        name, data=np.zeros(LARGE), compression="gzip"
    ),
    lambda group, name: group.create_dataset(name, data=h5py.Empty("f8")),
    lambda group, name: group.create_dataset(name, data=np.zeros((COUNT, 0, 3))),
    lambda group, name: group.create_dataset(name, data=np.zeros(COUNT, "c16")),
    lambda group, name: group.create_dataset(name, data=np.zeros(COUNT, "S3")),
    lambda group, name: group.create_dataset(
        name, data=np.zeros(COUNT, [("a", "f8"), ("b", "f8", 3)])
    ),
    lambda group, name: group.create_dataset(
        name, data=np.zeros(COUNT, h5py.enum_dtype({"A": 0}))
    ),
    lambda group, name: group.__setitem__(name, h5py.ExternalLink("/etc/passwd", "/")),
    lambda group, name: group.__setitem__(name, h5py.ExternalLink("log.h5", "/log")),
    lambda group, name: group.__setitem__(name, h5py.SoftLink("/log/more")),
    lambda group, name: group.__setitem__(name, h5py.SoftLink("/none")),
    lambda group, name: group.__setitem__(name, np.dtype("f8")),
    lambda group, name: group.create_dataset(b"\xff\xfe", data=np.zeros(COUNT)),
    lambda group, name: group.attrs.__setitem__("MATLAB_class", np.bytes_("cell")),
)
WRITERS: dict[str, Callable[[Random, Path], None]] = {
    ".mat": _mat,
    ".npz": _npz,
    ".h5": _hdf5,
}


# Bags.


def _bag(random: Random, seeds: Seeds) -> Case:
    kind = random.choice(list(seeds.bags))
    files = dict(seeds.bags[kind])
    bag = next(iter(files)).split("/")[0]
    for name in list(files):
        if name.endswith(".db3"):
            files[name] = _in_database(random, files[name])
        elif name.endswith("metadata.yaml"):
            if random.random() < 0.5:
                del files[name]
        elif random.random() < 0.6:
            # A recorder that was killed; or the index is gone.
            content = files[name]
            files[name] = content[: random.randrange(len(content))]
    if random.random() < 0.2:
        renamed = random.choice(("\udcff", "bag", "x", "a b"))
        files = {name.replace("bag", renamed): c for name, c in files.items()}
        bag = bag.replace("bag", renamed)
    if random.random() < 0.2:
        more = f"bag_1.{random.choice(('db3', 'mcap', 'db3-wal'))}"
        beside = Path(next(iter(files), "bag/x")).with_name(more)
        files[str(beside)] = random.choice((b"", *seeds.bags["ros1"].values()))
    files["map.yaml"] = MAP.encode()
    return _read(random, bag, files)


def _in_database(random: Random, content: bytes) -> bytes:
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "bag.db3"
        path.write_bytes(content)
        with contextlib.closing(sqlite3.connect(path)) as database:
            statement = random.choice(STATEMENTS)
            with contextlib.suppress(sqlite3.Error):
                database.execute(statement)
                database.commit()
        content = path.read_bytes()
    return (
        spoiled(random, content, mutations.BINARY) if random.random() < 0.3 else content
    )


STATEMENTS = (
    "DROP TABLE messages",
    "DROP TABLE topics",
    "DELETE FROM topics",
    "DELETE FROM messages",
    "UPDATE topics SET type = 'none'",
    "UPDATE topics SET name = NULL",
    "UPDATE topics SET name = X'FF'",
    "UPDATE topics SET id = 1",
    "UPDATE topics SET serialization_format = 'json'",
    "UPDATE messages SET data = 'text'",
    "UPDATE messages SET data = NULL",
    "UPDATE messages SET data = X''",
    "UPDATE messages SET data = zeroblob(100000)",
    "UPDATE messages SET timestamp = 'now'",
    "UPDATE messages SET timestamp = 1e300",
    "UPDATE messages SET timestamp = -9223372036854775808",
    "UPDATE messages SET topic_id = 99",
    "ALTER TABLE messages RENAME COLUMN data TO bytes",
    "CREATE VIEW more AS SELECT * FROM messages",
)
