"""Rows of float64 in a temporary file, read back in any order."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int


class RowFile:
    """Appended to, then gathered from. A memory map would count as memory used."""

    def __init__(self, path: Path, width: int) -> None:
        """An empty file.

        Args:
            path: of the file; it goes with its folder.
            width: numbers a row.
        """
        self._file = path.open("w+b")
        self._width = width

    def append(self, rows: Float[np.ndarray, "n width"]) -> None:
        """Adds rows at the end."""
        self._file.write(np.ascontiguousarray(rows).tobytes())

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
        self._file.close()
