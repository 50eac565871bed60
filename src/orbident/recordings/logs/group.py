"""What every file of tables is read as: groups of fields over one time."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.files.names import one_line, suggestion
from orbident.recordings.columns import split_name, written_unit

TIME_NAMES = ("t", "time", "times", "timestamp", "stamp", "tout", "time_s", "sec")
"""Names of fields that hold the time, wherever they stand; capitals do not matter."""

_LONGEST = 2**28
"""Numbers of a field: 2 GB. A declared size may be any."""


OBJECT = "is a MATLAB object"
"""The problem of a field that another reader may solve."""


@dataclass(frozen=True)
class LogField:
    """One field, read when it is wanted."""

    sizes: tuple[int, ...]
    """Along each axis, those of one left out: of at most two axes if it can be used."""
    read: Callable[[], np.ndarray]
    """What gives the array."""
    unit: str = ""
    """As the file has it; empty if it says none."""
    problem: str = ""
    """Why it cannot be used: a part of a sentence, "holds text". Empty if it can be."""
    transposed: bool = False
    """Whether the second axis is time."""

    @property
    def count(self) -> int:
        """Samples."""
        return self.sizes[self.transposed] if self.sizes else 1

    @property
    def width(self) -> int:
        """Numbers a sample; 0 for one number that is no array."""
        return self.sizes[not self.transposed] if len(self.sizes) == 2 else 0

    def values(self) -> np.ndarray:
        """The array, time first; dates as nanoseconds."""
        array = np.squeeze(np.asarray(self.read()))
        if array.dtype.kind == "M":
            array = array.astype("datetime64[ns]").astype(np.int64)
        return array.T if self.transposed else array

    def along(self, samples: int) -> "LogField":
        """Itself, with the axis of so many samples as time; else the longer one."""
        if len(self.sizes) != 2:
            return self
        first, second = self.sizes
        transposed = second == samples if samples in self.sizes else second > first
        return replace(self, transposed=transposed and first != samples)


Tree = Mapping[str, Any]
"""Fields, and in structs or groups more such."""


def field_of(
    shape: tuple[int, ...],
    dtype: np.dtype[Any],
    read: Callable[[], Any],
    unit: str = "",
) -> LogField | Tree:
    """An array, which `read` gives, as a field; records are structs."""
    if dtype.names:
        return {
            name: field_of(
                shape, dtype[name], lambda name=name: np.asarray(read())[name], unit
            )
            for name in dtype.names
        }
    sizes = [size for size in shape if size != 1]
    numbers = int(np.prod(shape, dtype=object))
    problem = ""
    if dtype.kind not in "biufM":
        what = {"c": "complex numbers", "S": "text", "U": "text"}
        problem = f"holds {what.get(dtype.kind, 'no numbers')}; write real numbers"
    elif len(sizes) > 2:
        problem = f"has shape {shape}, but is to have a row for each time"
    elif numbers > _LONGEST:
        problem = f"has {numbers} numbers; write at most {_LONGEST} of them"
    elif numbers < 2:
        problem = "is a single number, not one for each time" if numbers else "is empty"
    return LogField(tuple(sizes), read, "ns" if dtype.kind == "M" else unit, problem)


def in_memory(array: np.ndarray, unit: str = "") -> LogField | Tree:
    """An array that is read already."""
    return field_of(array.shape, array.dtype, lambda: array, unit)


def unusable(problem: str) -> LogField:
    """A field that is there, and why it cannot be used."""
    return LogField((0,), lambda: np.empty(0), problem=problem)


@dataclass(frozen=True)
class Group:
    """Fields that belong together: a topic of the map."""

    name: str
    fields: Mapping[str, LogField]
    place: str
    """The file, for messages."""

    type = "table"

    @property
    def count(self) -> int:
        """Samples of its time, or of its longest field."""
        time = self.time
        if time:
            return self.fields[time].count
        return max((f.count for f in self.fields.values() if not f.problem), default=0)

    def along_its_time(self) -> "Group":
        """Itself, with the samples of every field along the axis that its time has."""
        samples = self.fields[self.time].count if self.time else 0
        fields = {name: each.along(samples) for name, each in self.fields.items()}
        return replace(self, fields=fields)

    def decoder(self, place: str) -> Callable[[Any], Any]:
        """A table is taken as it is."""
        return lambda table: table

    @property
    def time(self) -> str | None:
        """The field that is its time by its name."""
        return next(filter(_is_time, self.usable), None)

    @property
    def usable(self) -> Iterator[str]:
        """The names of the fields that can be taken."""
        return (name for name, each in self.fields.items() if not each.problem)

    def unit(self, name: str) -> str:
        """The unit of a field, as `UNITS` names it; empty if the file tells none."""
        found = self._named(name)
        return written_unit(found.unit) if found else ""

    def has(self, name: str) -> bool:
        """Whether there is such a field, or the one of which it is a column."""
        return self._named(name) is not None

    def _named(self, name: str) -> LogField | None:
        return self.fields.get(name, self.fields.get(name.rpartition(".")[0]))

    def column(self, name: str) -> np.ndarray:
        """One number a sample; `name.k` is column k, from 0, of a field with several.

        Raises:
            InputError: it is missing, holds no numbers, is damaged, or has columns
                although none is named.
        """
        found, part = self._field(name)
        values = self._values(name, found)
        return values if part is None else values[:, part]

    def extent(self, name: str) -> tuple[float, float] | None:
        """The least and the largest number of a field, of all its columns together.

        None where it has no finite one, or cannot be read.
        """
        values = np.empty(0)
        with suppress(InputError):
            values = self._values(name, self.fields[name])
        finite = values[np.isfinite(values)]
        return (float(finite.min()), float(finite.max())) if finite.size else None

    def _values(self, name: str, found: LogField) -> np.ndarray:
        try:
            return found.values()
        # What the libraries raise over damaged bytes is of any kind.
        except Exception as error:
            raise InputError(
                f"{self.place}: topic '{self.name}': field '{name}' cannot be read "
                f"({one_line(error)}); copy or write the file again"
            ) from error

    def samples(self, name: str) -> int:
        """How many `column` would read.

        Raises:
            InputError: as `column`, but for damage.
        """
        found, _ = self._field(name)
        return found.count

    def _field(self, name: str) -> tuple[LogField, int | None]:
        """A field, and the number of its column if one is named."""
        where = f"{self.place}: topic '{self.name}'"
        owner, _, last = name.rpartition(".")
        part = None
        if name not in self.fields and owner in self.fields and last.isdecimal():
            name, part = owner, int(last)
        found = self.fields.get(name)
        if found is None:
            raise InputError(
                f"{where} has no field '{name}'; "
                + suggestion(name, self.fields, "fields")
            )
        if found.problem:
            raise InputError(f"{where}: field '{name}' {found.problem}")
        if part is None and found.width:
            raise InputError(
                f"{where}: field '{name}' has {found.width} numbers a row; name one of "
                f"them, '{name}.0' to '{name}.{found.width - 1}'"
            )
        if part is not None and part >= found.width:
            has = f"columns 0 to {found.width - 1}" if found.width else "one number"
            raise InputError(f"{where}: field '{name}' has {has} a row, not {part}")
        return found, part


def _is_time(name: str) -> bool:
    return split_name(name)[0].lower() in TIME_NAMES


def groups(tree: Tree, place: str) -> dict[str, Group]:
    """Groups by name: `/` and every struct that holds a time of its own.

    The fields of a struct without a time belong to the group that it is in, under
    their path: `arm.q1`.
    """
    found: dict[str, dict[str, LogField]] = {"/": {}}

    def visit(node: Tree, path: tuple[str, ...], home: str, depth: int) -> None:
        if any(_is_time(n) for n, each in node.items() if isinstance(each, LogField)):
            home, depth = "/" + "/".join(path), len(path)
            found.setdefault(home, {})
        for name, each in node.items():
            if isinstance(each, LogField):
                found[home][".".join((*path[depth:], name))] = each
            else:
                visit(each, (*path, name), home, depth)

    visit(tree, (), "/", 0)
    every = (Group(name, fields, place) for name, fields in found.items() if fields)
    return {group.name: group.along_its_time() for group in every}


def listed_fields(group: Group) -> Iterator[str]:
    """Each field as a map names it: `x`, or `x.0 to .2`."""
    for name in group.usable:
        width = group.fields[name].width
        yield f"{name}.0 to .{width - 1}" if width else name
