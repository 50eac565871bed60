"""What one entry of the map takes from a bag, in the order in which it comes.

It is kept as rows of float64 in a temporary file, and read back in any order.
"""

import tempfile
from array import array
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from jaxtyping import Float, Int

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.replacing import writing
from orbident.recordings.column_checks import QUATERNION_TOLERANCE
from orbident.recordings.topics.entry import Entry
from orbident.recordings.topics.fields import Table

_BATCH_ROWS = 8192

Stamps = Int[np.ndarray, " _"]


def _without_name(folder: Path) -> IO[bytes]:
    return tempfile.TemporaryFile(dir=folder)


class RowFile:
    """Appended to, then gathered from. A memory map would count as memory used."""

    def __init__(self, place: Path, width: int) -> None:
        """An empty file. It has no name, so it is gone when the process is.

        It is on the disk of `place`, which is being made; a row has `width` numbers.

        Raises:
            InputError: there can be no file.
        """
        self._place, self._width = place, width
        with writing(place):
            self._file = _without_name(place.parent)

    def append(self, rows: Float[np.ndarray, "n width"]) -> None:
        """Adds rows at the end.

        Raises:
            InputError: the disk is full.
        """
        with writing(self._place):
            self._file.write(np.ascontiguousarray(rows).tobytes())
            # Now, so that a later seek has nothing left to write.
            self._file.flush()

    def gather(self, index: Int[np.ndarray, " n"]) -> Float[np.ndarray, "n width"]:
        """Rows by number, counted from 0; neighbours are read at once."""
        rows = np.empty((index.size, self._width))
        if not index.size:
            return rows
        order = np.argsort(index, kind="stable")
        sought = index[order]
        starts = np.flatnonzero(np.diff(sought, prepend=sought[0] - 2) != 1)
        for start, stop in zip(starts, [*starts[1:], index.size], strict=True):
            self._file.seek(int(sought[start]) * self._width * 8)
            run = self._file.read(int(stop - start) * self._width * 8)
            rows[order[start:stop]] = np.frombuffer(run).reshape(-1, self._width)
        return rows

    def close(self) -> None:
        """Nothing can be read any more."""
        # What was refused before is refused here again.
        with suppress(OSError):
            self._file.close()


class Track:
    """Collects the samples of one entry, in a file in the order in which they come."""

    def __init__(self, entry: Entry, out: Path) -> None:
        """Nothing yet; rows are kept beside `out`, which is being made."""
        self.entry = entry
        self.rows = RowFile(out, len(entry.columns))
        """Columns in SI; NaN where a message has no finite number."""
        self.undecodable = 0
        """Messages whose bytes are not of their type."""
        self.incomplete = 0
        """Messages without a joint or transform that the entry wants."""
        self.not_finite = 0
        """Samples with a NaN, an infinity or no number where there should be one."""
        self.zeros = 0
        """Samples whose quaternion is zeros: a tracker that sees nothing."""
        self._stamps, self._received = array("q"), array("q")
        self._waiting: list[Any] = []
        self._last: Any = None
        self._labels: Counter[tuple[str, ...]] = Counter()
        self._with_gaps = self._bad = 0
        self._first_bad = ""
        self._ever = np.zeros(len(entry.columns), dtype=bool)

    def add(self, received: int, message: Any) -> None:
        """Takes what the entry wants from a message, or all rows of a table.

        A message was received then, in ns, and is None if its bytes are not of its
        type; a table has its own times.
        """
        if message is None:
            self.undecodable += 1
            return
        if isinstance(self.entry, Table):
            times, raw = self.entry.rows(message)
            self._labels[()] += len(raw)
            for start in range(0, len(raw), _BATCH_ROWS):
                rows = slice(start, start + _BATCH_ROWS)
                self._stamps.frombytes(bytes(times[rows].nbytes))
                self._received.frombytes(times[rows].tobytes())
                self._keep(raw[rows].copy())
            return
        self._last = message
        self._labels[self.entry.labels(message)] += 1
        for stamp, values in self.entry.samples(message):
            self._stamps.append(stamp)
            self._received.append(received)
            self._waiting.append(values)
            if len(self._waiting) == _BATCH_ROWS:
                self._flush()

    @property
    def messages(self) -> int:
        """How many messages came, or rows of a table."""
        return self._labels.total() + self.undecodable

    def finished(self, place: str) -> tuple[Stamps, Stamps]:
        """Samples' times; to be called once, when all have come.

        They are the stamps of headers, 0 where there is none, and when samples were
        recorded, ns. In messages the topic is called `place`.

        Raises:
            InputError: Nothing came, a label never occurs, a column never has a
                number, or a quaternion is not of length one.
        """
        self._flush()
        decoded = self._labels.total()
        if not decoded:
            raise InputError(
                f"{place}: none of its {self.undecodable} messages can be decoded as "
                f"{self.entry.type}; record again"
            )
        self._check_labels(place)
        if 0 < self.zeros == len(self._stamps):
            raise InputError(
                f"{place}: all {self.zeros} quaternions are zero, as of a tracker "
                "that sees nothing; take nothing from it that needs its attitude"
            )
        if self._bad:
            raise InputError(
                f"{place}: {self._bad} of {len(self._stamps)} quaternions are not of "
                f"length one within 1 %, first {self._first_bad}; correct the sender, "
                "or take from this topic nothing that needs its attitude"
            )
        if not self._ever.all():
            never = self.entry.columns[int(np.argmin(self._ever))]
            lacked = self.entry.lacked(self._last, never)
            raise InputError(
                f"{place}: column '{never}' never has a finite number; "
                + (lacked or "leave it out, or give what has it an entry of its own")
            )
        self.incomplete = sum(
            count
            for labels, count in self._labels.items()
            if not self.entry.wanted.issubset(labels)
        )
        # A transform that is not in a message is no sample, so it leaves no gap.
        gaps = self.incomplete if len(self._stamps) == decoded else 0
        self.not_finite = max(self._with_gaps - gaps - self.zeros, 0)
        times = self._stamps, self._received
        # Times are sorted once, and then these are no longer needed.
        self._stamps, self._received = array("q"), array("q")
        stamps, received = (np.frombuffer(each, np.int64) for each in times)
        return stamps, received

    def _check_labels(self, place: str) -> None:
        seen = sorted({label for labels in self._labels for label in labels})
        for label in sorted(self.entry.wanted.difference(seen)):
            raise InputError(
                f"{place}: '{label}' never occurs in its messages; "
                + suggestion(label, seen, "names")
            )

    def _flush(self) -> None:
        if self._waiting:
            self._keep(np.array(self._waiting, dtype=np.float64))
            self._waiting.clear()

    def _keep(self, raw: Float[np.ndarray, "n K"]) -> None:
        where, lost = self.entry.quaternion, np.zeros(len(raw), dtype=bool)
        if where is not None:
            lost = ~raw[:, where].any(axis=1)
            raw[:, where] = self._of_length_one(raw[:, where])
        rows = self.entry.table(raw)
        # A tracker that sees no attitude sees no position either.
        rows[lost] = np.where(
            np.char.startswith(self.entry.columns, "position."), np.nan, rows[lost]
        )
        finite = np.isfinite(rows)
        self._with_gaps += int(np.sum(~finite.all(axis=1)))
        self._ever |= finite.any(axis=0)
        self.rows.append(np.where(finite, rows, np.nan))

    def _of_length_one(self, x: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
        norm = np.linalg.norm(x, axis=1)
        off = np.abs(norm - 1) > QUATERNION_TOLERANCE
        self.zeros += int((norm == 0).sum())
        bad = np.flatnonzero(off & (norm > 0))
        if bad.size and not self._bad:
            number = len(self._stamps) - norm.size + int(bad[0])
            ns = self._stamps[number] or self._received[number]
            self._first_bad = f"at {ns / 1e9:.3f} s with norm {norm[bad[0]]:.4g}"
        self._bad += bad.size
        norm[off] = np.nan
        return x / norm[:, None]
