"""Packed samples that are read again from a temporary file."""

import tempfile
import weakref
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import IO, NamedTuple

import numpy as np
from jaxtyping import Float


class Piece(NamedTuple):
    """Consecutive samples."""

    t: Float[np.ndarray, " n"]
    """s."""
    samples: Float[np.ndarray, "n all"]
    """Packed, one a row."""


class KeptPieces:
    """Pieces of a long recording, one after another, again and again.

    They are kept in a file without a name, which is gone when the process is. Where
    there is no room for it, each pass works them out anew.
    """

    def __init__(self, anew: Callable[[], Iterator[Piece]]) -> None:
        """`anew` works all pieces out, from the first one on."""
        self._anew = anew
        self._shapes: list[tuple[int, ...]] = []
        self._file = _without_name()
        if self._file is not None:
            weakref.finalize(self, _close, self._file)

    def keep(self, piece: Piece) -> None:
        """Keep one more, which comes after the others."""
        if self._file is None:
            return
        try:
            for table in piece:
                self._file.write(np.ascontiguousarray(table).data)
            self._file.flush()
            self._shapes.append(piece.samples.shape)
        except OSError:
            _close(self._file)
            self._file = None

    def __call__(self) -> Iterator[Piece]:
        """All pieces, from the first one on."""
        return self._anew() if self._file is None else self._read(self._file)

    def _read(self, file: IO[bytes]) -> Iterator[Piece]:
        file.seek(0)
        for n, width in self._shapes:
            t = np.frombuffer(file.read(8 * n))
            samples = np.frombuffer(file.read(8 * n * width))
            yield Piece(t, samples.reshape(n, width))


def _without_name() -> IO[bytes] | None:
    with suppress(OSError):
        return tempfile.TemporaryFile()
    return None


def _close(file: IO[bytes]) -> None:
    # What the disk refused before is refused here again.
    with suppress(OSError):
        file.close()
