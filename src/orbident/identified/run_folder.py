"""The folder that keeps a result: `result.json`, the robot and its URDF, signals.

Measured and predicted signals are one compact file, a row a signal. Checksums say
whether the files are those that were written with the result.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.estimation.result import SCHEMA, Result
from orbident.estimation.signals import Signal, Signals
from orbident.files.bounds import LARGEST
from orbident.files.names import quoted
from orbident.files.replacing import (
    UNFINISHED,
    finish,
    is_committed,
    is_unfinished,
    replacing_files,
    write_text,
)
from orbident.files.schema_parts import validated
from orbident.files.text import refuse_pipe, sha256
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_written_robot, write_robot

SIGNAL_COLUMNS = pa.schema(
    [
        ("name", pa.string()),
        ("axes", pa.list_(pa.string())),
        ("units", pa.list_(pa.string())),
        ("t", pa.list_(pa.float64())),
        ("measured", pa.list_(pa.float32())),
        # Less predicted: beside large values float32 would lose it.
        ("error", pa.list_(pa.float32())),
        ("std", pa.float64()),
    ]
)


def write_signals(signals: Signals, path: Path) -> None:
    """Write them; an existing file is replaced."""
    rows = [
        {
            **signal._asdict(),
            "measured": signal.measured.astype(np.float32).ravel(),
            "error": (signal.measured - signal.predicted).astype(np.float32).ravel(),
        }
        for signal in signals
    ]
    table = pa.Table.from_pylist(rows, schema=SIGNAL_COLUMNS)
    # Bytes: as text Arrow takes no name that is not UTF-8.
    with pa.OSFile(os.fsencode(path), "wb") as file:
        parquet.write_table(
            table,
            file,
            compression="zstd",
            use_dictionary=False,
            # Neighbours share their upper bytes.
            use_byte_stream_split=[  # pyright: ignore[reportArgumentType]: stubs know bool
                f"{column}.list.element" for column in ("t", "measured", "error")
            ],
        )


def read_signals(path: Path) -> Signals:
    """Read them.

    Raises:
        InputError: it is not what `write_signals` writes.
    """
    try:
        with pa.OSFile(os.fsencode(path)) as file:
            table = parquet.read_table(file, schema=SIGNAL_COLUMNS)
        return tuple(_signal(table, k) for k in range(table.num_rows))
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"{path}: is not what 'orbident identify' wrote ({reason}); identify again"
        ) from error


def _signal(table: pa.Table, k: int) -> Signal:
    """The signal of a row.

    Raises:
        ValueError: its lists do not fit together.
    """
    name, axes, units, std = (
        table[column][k].as_py() for column in ("name", "axes", "units", "std")
    )
    lists = [table[column][k].values for column in ("t", "measured", "error")]
    if None in {name, std, *(axes or [None]), *(units or [None])} or any(
        each is None or each.null_count for each in lists
    ):
        raise ValueError("a value is missing")
    t, measured, error = (np.asarray(each).astype(np.float64) for each in lists)
    sizes = {measured.size, error.size, t.size * len(axes), t.size * len(units)}
    if len(sizes) > 1 or not np.all(np.abs(t) <= LARGEST):
        raise ValueError(f"the times, axes and values of {quoted(name)} do not fit")
    measured, error = (x.reshape(t.size, len(axes)) for x in (measured, error))
    return Signal(name, tuple(axes), tuple(units), t, measured, measured - error, std)


FILES, OWN = "files", "sha256"
"""Keys of `result.json`: the SHA-256 of every file, and of all else in itself."""


def with_checksums(
    document: Mapping[str, Any], folder: Path, names: Iterable[str]
) -> dict[str, Any]:
    """The content of `result.json`, with the checksums that its reader checks.

    The names are those of files that may be there.

    Raises:
        InputError: a file cannot be read.
    """
    there = [name for name in names if (folder / name).is_file()]
    whole = {**document, FILES: {name: sha256(folder / name) for name in there}}
    return {**whole, OWN: _digest(whole)}


def check_document(document: Mapping[str, Any], path: Path) -> None:
    """Refuse a `result.json` that is not as it was written.

    Raises:
        InputError: it has no checksums, or was altered.
    """
    schema = document.get("schema") if isinstance(document, Mapping) else None
    if schema != SCHEMA:
        raise InputError(
            f"{path}: schema: found {quoted(schema)}, expected '{SCHEMA}'; identify "
            "again"
        )
    if not {FILES, OWN} <= document.keys():
        raise InputError(
            f"{path}: has no checksums, so an earlier orbident wrote it, and whether "
            "it is complete cannot be known; identify again"
        )
    whole = {key: value for key, value in document.items() if key != OWN}
    if _digest(whole) != document[OWN]:
        raise InputError(_altered(path))


def check_files(files: Mapping[str, str], folder: Path, names: Iterable[str]) -> None:
    """Refuse files that are not as they were written.

    The files' checksums are by name; only those of `names` are looked at.

    Raises:
        InputError: a file is missing, cut off or altered, or belongs to no result.
    """
    for name in names:
        path = folder / name
        if name not in files and path.exists():
            raise InputError(f"{path}: does not belong to this result; move it away")
        if name in files and not path.is_file():
            raise InputError(f"{path}: is missing; identify again")
        if name in files and sha256(path) != files[name]:
            raise InputError(_altered(path))


def _digest(document: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _altered(path: Path) -> str:
    return (
        f"{path}: was altered or cut off after 'orbident identify' wrote it; "
        "identify again"
    )


RESULT, REPORT = "result.json", "report.html"
SIGNALS, HISTORY, REPLAY = "signals.parquet", "history.csv", "replay.json"
READ = ("robot.urdf", "robot.oem", "robot.yaml", SIGNALS, HISTORY, REPLAY)
"""What may be read again. The report is not, and can be made anew at any time."""
VALIDATION = "validation.json"
"""How the result predicted a recording that was not used, by the last `validate`."""
OURS = (*READ, VALIDATION, REPORT, RESULT)
"""All that a RUN folder has of ours; the result, which vouches for the rest, last."""


def save_result(result: Result, folder: str | Path, force: bool = False) -> None:
    """Write a RUN folder, without a report.

    Args:
        result: accepted or not.
        folder: that is made; one that is there already must be empty.
        force: replace the files of a RUN that is there.

    Raises:
        InputError: the folder exists and `force` is false, or cannot be written.
    """
    with saving(result, Path(folder), force):
        pass


@contextmanager
def saving(result: Result, folder: Path, force: bool = False) -> Iterator[Path]:
    """Write a RUN folder, and what the block adds to it, all at once or not at all.

    With `force` files of ours in an existing RUN are replaced, and no others.

    Yields:
        A folder with the files so far, for `replay.json` and `report.html`.

    Raises:
        InputError: the folder exists and `force` is false, or cannot be written.
    """
    check_absent(folder, force)
    # They may come from the folder that is replaced.
    signals = result.signals()
    with replacing_files(folder, OURS) as new:
        # Another process may have been faster.
        check_absent(folder, force)
        write_robot(result.robot, new)
        write_signals(signals, new / SIGNALS)
        if result.history is not None:
            _write_history(result, new / HISTORY)
        yield new
        document = with_checksums(result.to_json(), new, READ)
        write_text(new / RESULT, json.dumps(document, indent=1))


def _write_history(result: Result, path: Path) -> None:
    """A row a sample: estimates, deviations, and what the detector saw."""
    history = result.history
    assert history is not None
    names = result.base.names
    header = ["t", *names, *(f"{name}.std" for name in names)]
    header += ["innovation_squared", "degrees_of_freedom", "change_statistic"]
    parts = (history.nis, history.dof, history.statistic)
    table = np.column_stack([history.t, history.beta, history.std, *parts])
    np.savetxt(path, table, "%.10g", ",", header=",".join(header), comments="")


def check_absent(folder: Path, force: bool) -> None:
    """Refuse a RUN folder that exists; an empty folder is none.

    Raises:
        InputError: it exists and `force` is false, or is something else than a RUN.
    """
    if not folder.exists():
        _check_above(folder)
        return
    names = _names(folder)
    if names is None:
        raise InputError(
            f"{folder}: is not a RUN folder, so it is not overwritten; name another"
        )
    if not os.access(folder, os.W_OK):
        raise InputError(f"{folder}: cannot be written (Permission denied)")
    if not force and (names or is_committed(folder)):
        raise InputError(f"{folder}: exists already; name another, or use --force")


def _names(folder: Path) -> set[str] | None:
    """What a RUN folder holds, complete or not; None for what is none."""
    if not folder.is_dir():
        return None
    names = {path.name for path in folder.iterdir() if UNFINISHED not in path.name}
    # A result of any version, complete or cut off.
    result, family = folder / RESULT, SCHEMA.rpartition("/")[0].encode()
    ours = result.is_file() and family in result.read_bytes()
    if names <= set(OURS) or is_unfinished(folder) or ours:
        return names
    return None


def _check_above(folder: Path) -> None:
    if folder.is_symlink():
        raise InputError(f"{folder}: is a link to nowhere; name another, or remove it")
    above = next(above for above in folder.absolute().parents if above.exists())
    if not above.is_dir():
        raise InputError(f"{folder}: '{above}' is a file; name a place in a folder")
    if not os.access(above, os.W_OK):
        raise InputError(f"{folder}: cannot be written (Permission denied)")


def load_result(folder: str | Path) -> Result:
    """Read a RUN folder; every file is checked against its checksum.

    Args:
        folder: that `save_result` or `orbident identify -o` wrote.

    Raises:
        InputError: a file is missing or is not what `identify` wrote.
    """
    folder = Path(folder)
    finish(folder, OURS)
    path = folder / RESULT
    version = _version(path)
    text = _text(path)
    try:
        return _read(text, folder)
    except InputError:
        if not is_committed(folder) and _version(path) == version:
            raise
    # It was replaced meanwhile.
    return load_result(folder)


def _version(path: Path) -> tuple[int, int] | None:
    """Which file this is: the same result, written twice, is two files."""
    with suppress(OSError):
        found = path.stat()
        return found.st_ino, found.st_mtime_ns
    return None


def _text(path: Path) -> str:
    refuse_pipe(path, "the result")
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not JSON ({error}); identify again") from error
    except OSError as error:
        if is_unfinished(path.parent) and not path.exists():
            raise InputError(
                f"{path.parent}: is not complete, 'orbident identify' was ended before "
                "that or is still at work; wait, or identify again"
            ) from error
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); give the folder that "
            "'orbident identify -o' wrote"
        ) from error


def _read(text: str, folder: Path) -> Result:
    path = folder / RESULT
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: is not JSON, or was cut off: see line {error.lineno}, column "
            f"{error.colno}; identify again"
        ) from None
    except (ValueError, RecursionError):
        raise InputError(f"{path}: is not JSON; identify again") from None
    check_document(document, path)
    check_files(document[FILES], folder, READ)
    robot = load_written_robot(folder)
    signals = partial(_signals, folder, document[FILES])
    return replace(result_from(document, robot, path), signals=signals)


def result_from(document: dict[str, Any], robot: Robot, path: Path) -> Result:
    """The result that a document holds.

    Raises:
        InputError: the first thing that is wrong, and how many more there are.
    """
    try:
        return validated(Result, {**document, "robot": robot}, "")
    except InputError as error:
        raise InputError(
            f"{path}: is not what 'orbident identify' wrote: {error}; identify again"
        ) from None


def _signals(folder: Path, files: dict[str, str]) -> Signals:
    """Read when they are wanted: the folder may have been replaced by then."""
    check_files(files, folder, [SIGNALS])
    return read_signals(folder / SIGNALS)
