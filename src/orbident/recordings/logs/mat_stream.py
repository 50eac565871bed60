"""The bytes of a MATLAB variable, one after the other, decompressed on the way."""

import os
import zlib
from typing import BinaryIO

import numpy as np

_PIECE = 2**16
"""Bytes that are read, and given, at once."""


class MatStream:
    """Reads forwards only; however large the data, a piece of it is in memory."""

    def __init__(self, file: BinaryIO, begin: int, packed: int | None = None) -> None:
        """Begin to read.

        Args:
            file: that can be sought in; other streams may read it too.
            begin: where in the file.
            packed: bytes of compressed data there; None for plain ones to the end of
                the file.
        """
        self.file, self.begin, self.packed = file, begin, packed
        self.size = os.fstat(file.fileno()).st_size - begin
        """Bytes up to the end of the file."""
        self.at = 0
        """Bytes that were read or passed over, as they are decompressed."""
        self._inflate = zlib.decompressobj()
        self._read, self._packed, self._ready = 0, b"", memoryview(b"")

    def again(self) -> "MatStream":
        """The same from its beginning."""
        return MatStream(self.file, self.begin, self.packed)

    def ended(self) -> bool:
        """Whether plain data were read to the end of the file."""
        return self.at >= self.size

    def take(self, count: int) -> bytes:
        """So many bytes, which are few.

        Raises:
            ValueError: There are fewer.
        """
        found = b""
        while len(found) < count:
            found += self._next(count - len(found))
        return found

    def numbers(self, dtype: np.dtype, count: int) -> np.ndarray:
        """So many numbers.

        Raises:
            ValueError: There are fewer.
        """
        array = np.empty(count, dtype)
        into, filled = array.view(np.uint8), 0
        while filled < into.size:
            piece = self._next(into.size - filled)
            into[filled : filled + len(piece)] = piece
            filled += len(piece)
        return array

    def skip_to(self, place: int) -> None:
        """Pass over what comes before a place.

        Raises:
            ValueError: It was passed already, or there are fewer bytes.
        """
        if place < self.at:
            raise ValueError("an element is longer than what it is in")
        if self.packed is None and place > self.at + len(self._ready):
            self._read = self.at = place
            self._ready = memoryview(b"")
        while self.at < place:
            self._next(place - self.at)

    def check_rest(self) -> None:
        """Decompress what is left, which ends with a checksum.

        Raises:
            zlib.error: The checksum is another one.
        """
        while self._ready or self._filled():
            self._ready = memoryview(b"")

    def _next(self, count: int) -> memoryview:
        """At most so many of the bytes that come next, at least one."""
        if not (self._ready or self._filled()):
            raise ValueError("it ends within a variable, so it is cut off or damaged")
        piece, self._ready = self._ready[:count], self._ready[count:]
        self.at += len(piece)
        return piece

    def _filled(self) -> bool:
        """Make the next piece ready, if there is one."""
        if self.packed is None:
            self._ready = memoryview(self._from_file(self.size))
            return bool(self._ready)
        while not (self._inflate.eof or self._ready):
            packed = self._packed or self._from_file(self.packed)
            self._ready = memoryview(self._inflate.decompress(packed, _PIECE))
            self._packed = self._inflate.unconsumed_tail
            if not packed:
                break
        return bool(self._ready)

    def _from_file(self, size: int) -> bytes:
        self.file.seek(self.begin + self._read)
        found = self.file.read(max(min(_PIECE, size - self._read), 0))
        self._read += len(found)
        return found
