"""A recording that is read in stretches: it need not fit into memory."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from orbident import _core
from orbident.recordings.columns import is_known
from orbident.recordings.recording import Recording, check_cut, within

SPANS = 5
"""An odd number: one is in the middle."""

SPAN = 2**14
"""Rows of each."""

LARGE = SPANS * SPAN
"""Rows from which a recording is read in stretches."""

AT_ONCE = 3 * 2**18
"""Numbers that are worked on at once: what is derived of them takes 100 MB."""

FEWEST = 2**12
"""Rows that are read beside them first,"""

FARTHEST = 2**16
"""and at most, however long a sensor has no samples."""

Columns = Mapping[str, np.ndarray]


def spare_memory(rows: int) -> None:
    """Give what is no longer used back to the system, where there are many rows."""
    if rows >= LARGE:
        _core.give_back_memory()


class Stretch(NamedTuple):
    """Consecutive rows, and some more at either end."""

    recording: Recording
    own: slice
    """The rows that are no other stretch's."""


@dataclass(frozen=True, eq=False)
class LongRecording:
    """A table that is read again and again, a batch of rows at a time."""

    source: str
    """Where it came from, for messages."""
    rows: int
    batches: Callable[[], Iterator[Columns]]
    """Begins at the first row each time; every batch has `t`."""
    read: Callable[[], Recording]
    """All of it into memory."""

    @classmethod
    def of(cls, recording: Recording) -> "LongRecording":
        """One that is in memory already."""
        columns = {name: x for name, x in recording.columns.items() if is_known(name)}
        columns["t"] = recording.t

        def batches() -> Iterator[Columns]:
            for start in range(0, recording.t.size, SPAN):
                rows = slice(start, start + SPAN)
                yield {name: x[rows] for name, x in columns.items()}

        return cls(recording.source, recording.t.size, batches, lambda: recording)

    @property
    def stretch(self) -> int:
        """Rows that are worked on at once: fewer where there are more columns."""
        return AT_ONCE // (1 + len(self.digest.columns))

    def between(
        self, start: float = -math.inf, end: float = math.inf
    ) -> "Recording | LongRecording":
        """The rows whose times are from `start` to `end`, s; few are held in memory.

        Raises:
            InputError: There are fewer than two such rows.
        """

        def batches() -> Iterator[Columns]:
            for batch in self.batches():
                rows = within(batch["t"], start, end)
                if rows.any():
                    yield {name: x[rows] for name, x in batch.items()}

        rows, first, last = 0, math.inf, -math.inf
        for batch in self.batches():
            t = batch["t"]
            rows += int(within(t, start, end).sum())
            first, last = min(first, t.min()), max(last, t.max())
        check_cut(self.source, start, end, rows, first, last)
        if rows < LARGE:
            return _recording(self.source, _joined(list(batches())))
        return LongRecording(
            self.source, rows, batches, lambda: self.read().between(start, end)
        )

    @cached_property
    def digest(self) -> Recording:
        """Spans of rows, evenly spread from the first row to the last.

        What the whole of a recording decides, such as how smooth a joint moves, is
        found from these rows, however the recording is read.

        Raises:
            InputError: As `Recording`.
        """
        starts = np.linspace(0, self.rows - SPAN, SPANS).astype(int)
        parts: list[Columns] = []
        row = 0
        for batch in self.batches():
            for start in (starts - row).tolist():
                own = slice(max(start, 0), max(start + SPAN, 0))
                part = {name: x[own].copy() for name, x in batch.items()}
                if part["t"].size > 1:
                    # What is wrong in a row is said with the row's own number.
                    _recording(self._from(row + own.start), part)
                if part["t"].size:
                    parts.append(part)
            row += batch["t"].size
        return _recording(self.source, _joined(parts))

    def stretches(self, beside: Callable[[str], int], size: int) -> Iterator[Stretch]:
        """All rows, each once its stretch's own.

        So many samples of a column must stand at either end of a stretch's own rows as
        `beside` says, as far as there are any within `FARTHEST` rows.

        Raises:
            InputError: As `Recording`.
        """
        held, first, own = _Held(self.batches()), 0, 0
        while (table := held.filled(own + 1))["t"].size > own:
            end, further = own + size, FEWEST
            while True:
                table = held.filled(end + further)
                after = _reach(table, slice(end, None), beside)
                if after or held.ended or further >= FARTHEST:
                    break
                further *= 2
            end = min(end, table["t"].size)
            stop = end + (after or FARTHEST)
            rows = {name: x[:stop] for name, x in table.items()}
            recording = _recording(self._from(first), rows)
            yield Stretch(recording, slice(own, end))
            before = _reach(table, slice(end - 1, None, -1), beside) or FARTHEST
            dropped = max(end - before, 0)
            held.drop(dropped)
            # Held no longer while the next one is read.
            del table, rows, recording
            first, own = first + dropped, end - dropped

    def _from(self, first: int) -> str:
        """What rows from this one on are called in messages, which count from them."""
        return f"{self.source}, from row {first + 1} on" if first else self.source


class _Held:
    """Rows that were read and are still needed."""

    def __init__(self, batches: Iterator[Columns]) -> None:
        self._batches = batches
        self._parts: list[Columns] = []
        self.ended = False

    def filled(self, rows: int) -> Columns:
        """Return at least so many rows, as far as there are any."""
        count = sum(part["t"].size for part in self._parts)
        while count < rows and not self.ended:
            batch = next(self._batches, None)
            self.ended = batch is None
            if batch is not None:
                self._parts.append(batch)
                count += batch["t"].size
        self._parts = [_joined(self._parts)]
        return self._parts[0]

    def drop(self, rows: int) -> None:
        """Forget the first rows; a copy, so that their memory is free again."""
        table = self._parts[0]
        self._parts = [{name: x[rows:].copy() for name, x in table.items()}]


def _reach(table: Columns, rows: slice, beside: Callable[[str], int]) -> int:
    """How many rows hold enough samples of all columns; 0 if no `FARTHEST` rows do."""
    reach = 0
    for name, x in table.items():
        seen = np.flatnonzero(~np.isnan(x[rows][:FARTHEST]))
        wanted = beside(name)
        if seen.size < wanted:
            return 0
        reach = max(reach, int(seen[wanted - 1]) + 1)
    return reach


def _joined(parts: list[Columns]) -> Columns:
    if len(parts) == 1:
        return parts[0]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _recording(source: str, table: Columns) -> Recording:
    columns = {name: x for name, x in table.items() if name != "t"}
    return Recording(table["t"], columns, source)
