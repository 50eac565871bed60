"""Packed samples that are worked out once and read again from a temporary file."""

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

    The first whole pass writes them to a file without a name, which is gone when the
    process is. Where there is no room for it, each pass works them out anew.
    """

    def __init__(self, pieces: Callable[[], Iterator[Piece]]) -> None:
        """`pieces` are worked out from the first one on each time."""
        self._pieces = pieces
        self._shapes: list[tuple[int, ...]] = []
        self._file: IO[bytes] | None = None

    def __call__(self) -> Iterator[Piece]:
        """All pieces, from the first one on."""
        return self._worked_out() if self._file is None else self._read(self._file)

    def _worked_out(self) -> Iterator[Piece]:
        file, shapes = _without_name(), list[tuple[int, ...]]()
        if file is not None:
            weakref.finalize(self, _close, file)
        for piece in self._pieces():
            try:
                if file is not None:
                    for table in piece:
                        file.write(np.ascontiguousarray(table).data)
                    file.flush()
            except OSError:
                _close(file)
                file = None
            shapes.append(piece.samples.shape)
            yield piece
            # Held no longer while the next one is worked out.
            del piece
        self._file, self._shapes = file, shapes

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


def _close(file: IO[bytes] | None) -> None:
    # What the disk refused before is refused here again.
    with suppress(OSError):
        if file is not None:
            file.close()
