"""Rows of float64 in a temporary file, read back in any order."""

import tempfile
from contextlib import suppress
from pathlib import Path
from typing import IO

import numpy as np
from jaxtyping import Float, Int

from orbident.files.writing import writing


class RowFile:
    """Appended to, then gathered from. A memory map would count as memory used."""

    def __init__(self, place: Path, width: int) -> None:
        """An empty file. It has no name, so it is gone when the process is.

        Args:
            place: what is being made, on the same disk.
            width: numbers a row.

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


def _without_name(folder: Path) -> IO[bytes]:
    return tempfile.TemporaryFile(dir=folder)
