"""MATLAB's objects by the library mat-io: timeseries, tables and timetables.

Their format is not published, and the library is not meant for damaged files. So it
reads in a child process with limits, which writes arrays of numbers into a folder.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.confined import ConfinedError, confined
from orbident.recordings.logs.group import OBJECT, LogField, Tree, field_of, unusable
from orbident.recordings.logs.hdf5_file import is_hdf5, leads_elsewhere

MOST = 2**17
"""Arrays in a file, empty ones and cells too: each takes 40 us and 2 kB."""
_STRUCT = "save it as a struct: s = struct('time', x.Time, 'data', x.Data)"
_SECONDS, _MEGABYTES = 40, 1500
"""The limits of the project's fuzzer, a minute and 2 GB, less what Python needs."""
_LARGEST = 2**30
"""Bytes of all arrays: a hundred columns of a million rows."""
_DEEPEST = 20
"""Objects in objects. Simulink's logs have five levels; some refer to themselves."""


def is_object(node: LogField | Tree) -> bool:
    """Whether it is an object that was not read, or holds one."""
    if isinstance(node, LogField):
        return node.problem == OBJECT
    return any(map(is_object, node.values()))


def with_objects(tree: Tree, path: Path, stack: ExitStack) -> Tree:
    """The variables of a file, those with objects read again by the library.

    The stack keeps the arrays as long as values are to be read.
    """
    names = [name for name, node in tree.items() if is_object(node)]
    if not names:
        return tree
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="orbident-")))
    try:
        found = confined(
            write_objects,
            *(str(path), names, str(folder)),
            seconds=_SECONDS,
            megabytes=_MEGABYTES,
        )
    except (InputError, RuntimeError) as error:
        known = isinstance(error, InputError | ConfinedError)
        why = str(error) if known else "it cannot be read"
        return {**tree, **{name: _unread(tree[name], why) for name in names}}
    return {**tree, **{name: _kept(node, folder) for name, node in found.items()}}


def _unread(node: LogField | Tree, why: str) -> LogField | Tree:
    if not isinstance(node, LogField):
        return {name: _unread(each, why) for name, each in node.items()}
    return unusable(f"{OBJECT} ({why}); {_STRUCT}") if is_object(node) else node


def _kept(node: Any, folder: Path) -> LogField | Tree:
    """What the child wrote: a field, or fields by name."""
    if "fields" in node:
        return {name: _kept(each, folder) for name, each in node["fields"].items()}
    if "problem" in node:
        return unusable(node["problem"])

    def read() -> np.ndarray:
        return np.load(folder / node["file"], mmap_mode="r", allow_pickle=False)

    array = read()
    return field_of(array.shape, array.dtype, read, node["unit"])


def write_objects(path: str, names: Sequence[str], folder: str) -> dict[str, Any]:
    """In the child: read variables and write their arrays; of each what `_kept` reads.

    Raises:
        InputError: The arrays are too large, the file refers to others, or the library
            is not installed.
    """
    with extra("matlab", "reading one"):
        from matio import load_from_mat
    if is_hdf5(Path(path)) and leads_elsewhere(path):
        raise InputError("its file refers to other files, which are not read")
    writer = _Writer(Path(folder))
    with warnings.catch_warnings():
        # Of zones and formats of dates, which do not matter here.
        warnings.simplefilter("ignore")
        found = load_from_mat(path, variable_names=list(names), add_table_attrs=True)
        return {name: writer.variable(found[name]) for name in names if name in found}


class _Writer:
    """Writes arrays and describes what they are of."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.nodes = self.files = self.bytes = 0

    def variable(self, value: Any) -> dict[str, Any]:
        """Describe a variable, whatever the library makes of it."""
        try:
            return self._node(value)
        except InputError:
            raise
        except Exception:
            return {"problem": f"{OBJECT} of a kind that is not known; {_STRUCT}"}

    def _node(self, value: Any, unit: str = "", depth: int = 0) -> dict[str, Any]:
        """Describe numbers, a table, an object, a struct or a cell."""
        self.nodes += 1
        if self.nodes > MOST:
            raise InputError("its objects have too many parts")
        if depth > _DEEPEST:
            return {"problem": f"{OBJECT} with too many levels; {_STRUCT}"}
        properties = getattr(value, "properties", None)
        if hasattr(value, "columns"):
            parts = _table(value)
        elif isinstance(properties, dict):
            named = ((name, each, "") for name, each in properties.items())
            parts = _timeseries(properties) if "Data_" in properties else named
        else:
            array = np.asarray(value)
            if array.dtype.kind not in "OV" or array.ndim == 0:
                return self._numbers(array, unit)
            parts = _elements(array)
        return {
            "fields": {
                name: self._node(each, unit, depth + 1) for name, each, unit in parts
            }
        }

    def _numbers(self, array: np.ndarray, unit: str) -> dict[str, Any]:
        if array.dtype.kind == "m":
            array, unit = array.astype("m8[ns]") / np.timedelta64(1, "s"), "s"
        if array.dtype.kind not in "biufM":
            return {"problem": "holds text or no real numbers; write real numbers"}
        self.bytes += array.nbytes
        if self.bytes > _LARGEST:
            raise InputError(f"the objects have more than {_LARGEST // 2**30} GiB")
        self.files += 1
        name = f"{self.files}.npy"
        np.save(self.folder / name, array, allow_pickle=False)
        return {"file": name, "unit": unit}


Part = tuple[str, Any, str]
"""A name, a value of the library, and its unit."""


def _table(frame: Any) -> Iterator[Part]:
    """The columns; of a timetable also the time of its rows."""
    if frame.index.dtype.kind in "mM":
        yield "time", frame.index.to_numpy(), ""
    units = frame.attrs.get("VariableUnits", [])
    if len(units) != len(frame.columns):
        units = [""] * len(frame.columns)
    for name, unit in zip(frame.columns, units, strict=True):
        column = frame[name].to_numpy()
        yield str(name), "" if column.dtype.kind == "O" else column, unit


def _timeseries(properties: dict[str, Any]) -> Iterator[Part]:
    """The time and the data."""
    about = getattr(properties["TimeInfo"], "properties", {})
    unit = str(np.squeeze(about.get("Units", "")))
    stored = (properties.get("Time_"), about.get("Time_"), properties.get("Time"))
    time = next((x for x in stored if x is not None and np.size(x) > 1), None)
    if time is None:
        # Where steps are equal only these are stored.
        start, step, length = (
            float(np.squeeze(about.get(f"{name}_", about.get(name, np.nan))))
            for name in ("Start", "Increment", "Length")
        )
        time = start + step * np.arange(int(length))
    yield "time", time, {"seconds": "s", "milliseconds": "ms"}.get(unit, unit)
    yield "data", properties["Data_"], ""


def _elements(array: np.ndarray) -> Iterator[Part]:
    """The fields of a struct, or the elements of a cell or an array of structs."""
    if array.size == 1:
        (one,) = array.reshape(1)
        if array.dtype.names:
            for name in array.dtype.names:
                yield name, one[name], ""
            return
    for k, each in enumerate(array.flat):
        # Simulink's signals in a Dataset have names, which may be alike.
        properties = getattr(each, "properties", None)
        named = properties.get("Name") if isinstance(properties, dict) else None
        name = np.ravel(named if named is not None else 0)
        yield f"{k}_{name[0]}" if name.dtype.kind == "U" else str(k), each, ""
