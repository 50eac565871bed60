"""MATLAB's files up to -v7 (Level 5), by MathWorks' "MAT-File Format".

A file is a header of 128 bytes and elements: a tag (type, bytes), then data. A matrix
is an element of elements: flags, sizes, name, and its numbers or its fields. Every
length is checked against what is there; SciPy's reader, which is not meant for damaged
files, ends the process over some of them.

A compressed variable may be a thousand times as large as in the file. So numbers are
passed over, and those of one field are read when they are wanted.
"""

import math
import os
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import BinaryIO, Literal, NamedTuple

import numpy as np

from orbident.recordings.logs.group import OBJECT, LogField, Tree, field_of, unusable
from orbident.recordings.logs.hdf5_file import is_hdf5, read_hdf5
from orbident.recordings.logs.mat_objects import MOST, with_objects

_PIECE = 2**16
"""Bytes that are read, and given, at once."""


class MatStream:
    """Reads forwards only; however large the data, a piece of it is in memory."""

    def __init__(self, file: BinaryIO, begin: int, packed: int | None = None) -> None:
        """Begin to read so many packed bytes, or without any, plain ones to the end."""
        self.file, self.begin, self.packed = file, begin, packed
        self.size = os.fstat(file.fileno()).st_size - begin
        """Bytes up to the end of the file."""
        self.at = 0
        """Bytes that were read or passed over, as they are decompressed."""
        self._pieces = self._plain(self.size) if packed is None else self._inflated()
        self._ready = memoryview(b"")

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

    def skip_to(self, offset: int) -> None:
        """Pass over what comes before an offset.

        Raises:
            ValueError: It was passed already, or there are fewer bytes.
        """
        if offset < self.at:
            raise ValueError("an element is longer than what it is in")
        if self.packed is None and offset > self.at + len(self._ready):
            self._pieces, self._ready = self._plain(self.size, offset), memoryview(b"")
            self.at = offset
        while self.at < offset:
            self._next(offset - self.at)

    def check_rest(self) -> None:
        """Decompress what is left, which ends with a checksum.

        Raises:
            zlib.error: The checksum is another one.
        """
        for _ in self._pieces:
            pass

    def _next(self, count: int) -> memoryview:
        """At most so many of the bytes that come next, at least one."""
        if not self._ready:
            self._ready = memoryview(next(self._pieces, b""))
        if not self._ready:
            raise ValueError("it ends within a variable, so it is cut off or damaged")
        piece, self._ready = self._ready[:count], self._ready[count:]
        self.at += len(piece)
        return piece

    def _plain(self, end: int, start: int = 0) -> Iterator[bytes]:
        """The bytes of the file between two offsets, piece by piece."""
        for at in range(start, end, _PIECE):
            # Other streams read the same file in between.
            self.file.seek(self.begin + at)
            yield self.file.read(min(_PIECE, end - at))

    def _inflated(self) -> Iterator[bytes]:
        """What the packed bytes hold, piece by piece."""
        inflate = zlib.decompressobj()
        for packed in self._plain(self.packed or 0):
            while piece := inflate.decompress(packed, _PIECE):
                yield piece
                packed = inflate.unconsumed_tail
            if inflate.eof:
                return


_NUMBERS = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
"""The types of elements that are numbers, as NumPy names them."""
_MATRIX, _COMPRESSED = 14, 15
_CELL, _STRUCT, _CHAR = 1, 2, 4
_NUMERIC = range(6, 16)
_COMPLEX = 0x0800
"""The flag of an array with an imaginary part."""
_ORDERS: dict[str, Literal["little", "big"]] = {"<": "little", ">": "big"}
_HEADER = 128
"""Bytes before the first element."""
_LARGEST = 2**31
"""Bytes of a variable when it is decompressed: MATLAB writes no larger one."""
_LONGEST = 2**16
"""Bytes of sizes, and of the names of a struct's fields: a thousand names of 63."""


class _Element(NamedTuple):
    kind: int
    size: int
    end: int
    """Where the next one begins."""


def variables(file: BinaryIO) -> Tree:
    """The variables of a file by name, structs as trees.

    The file is open as long as values are to be read.

    Raises:
        ValueError: It is cut off, or does not keep to the format.
    """
    header = file.read(_HEADER)
    order = {b"IM": "<", b"MI": ">"}.get(header[126:])
    if order is None or header[124:126] not in {b"\0\1", b"\1\0"}:
        raise ValueError("its header is not of version 5; save it with -v7")
    found = {}
    whole = MatStream(file, _HEADER)
    parser = _Parser(order)
    while whole.at < whole.size:
        element = parser.element(whole, whole.size)
        stream, end = whole, element.end
        if element.kind == _COMPRESSED:
            stream = MatStream(file, _HEADER + whole.at, element.size)
            element = parser.element(stream, _LARGEST)
        if element.kind != _MATRIX:
            raise ValueError(f"element of type {element.kind} is no variable")
        name, field = parser.matrix(stream, element)
        # What has no name belongs to MATLAB's own objects.
        if name:
            found[name] = field
        if stream is not whole:
            stream.check_rest()
        whole.skip_to(end)
    return found


class _Parser:
    """Reads matrices, in the byte order of a file, and counts them."""

    def __init__(self, order: str) -> None:
        self.order = order
        self.count = 0

    def element(self, stream: MatStream, limit: int) -> _Element:
        """The tag that comes next; data of up to 4 bytes stand within it."""
        kind = self._whole(stream)
        if kind >> 16:
            kind, size = kind & 0xFFFF, kind >> 16
            end = stream.at + 4
        else:
            size = self._whole(stream)
            # To a multiple of 8 bytes, unless compressed; the last may go without.
            room = size if kind == _COMPRESSED else -(-size // 8) * 8
            end = min(stream.at + room, limit)
        if stream.at + size > min(end, limit):
            raise ValueError("it ends within a variable, so it is cut off or damaged")
        return _Element(kind, size, end)

    def matrix(self, stream: MatStream, whole: _Element) -> tuple[str, LogField | Tree]:
        """The name and the content of the matrix whose tag was read."""
        self.count += 1
        if self.count > MOST:
            raise ValueError(f"it holds more than {MOST} arrays; save fewer, or -v7.3")
        if not whole.size:
            return "", unusable("is empty")
        flags = int(self._numbers(stream, whole.end)[0])
        if flags & 0xFF > _NUMERIC[-1]:
            # Functions and objects have no sizes; their name comes first.
            found = self._text(stream, whole.end), unusable(OBJECT)
        else:
            sizes = tuple(map(int, self._numbers(stream, whole.end)))
            name = self._text(stream, whole.end)
            if min(sizes, default=0) < 0:
                raise ValueError("a size is negative")
            found = name, self._content(flags, sizes, stream, whole.end)
        stream.skip_to(whole.end)
        return found

    def _content(
        self, flags: int, sizes: tuple[int, ...], stream: MatStream, end: int
    ) -> LogField | Tree:
        """What stands behind the name of a matrix."""
        kind = flags & 0xFF
        if kind == _STRUCT:
            return self._struct(stream, sizes, end)
        if kind == _CELL:
            cells = list(self._matrices(stream, end))
            problems = [getattr(each, "problem", "") for each in cells]
            if cells and all(each.startswith("holds text") for each in problems):
                return cells[0]
            return {str(k): each for k, each in enumerate(cells)}
        if kind == _CHAR:
            text = self._text(stream, end).replace("\0", "")
            return unusable(f"holds text, {text[:40]!r}; write it as numbers")
        if kind not in _NUMERIC:
            return unusable(
                "is a sparse matrix; save it as full(x)" if kind == 5 else OBJECT
            )
        if flags & _COMPLEX:
            return unusable("holds complex numbers; write real numbers")
        return self._array(stream, sizes, end)

    def _array(
        self, stream: MatStream, sizes: tuple[int, ...], end: int
    ) -> LogField | Tree:
        """A matrix of numbers, which stay where they are."""
        element = self.element(stream, end)
        dtype = self._dtype(element)
        count = element.size // dtype.itemsize
        if count != math.prod(sizes):
            raise ValueError(f"{count} numbers are no matrix of {sizes}")
        at = stream.at

        def read() -> np.ndarray:
            again = MatStream(stream.file, stream.begin, stream.packed)
            again.skip_to(at)
            numbers = again.numbers(dtype, count)
            native = numbers.astype(dtype.newbyteorder("="), copy=False)
            return native.reshape(sizes, order="F")

        return field_of(sizes, dtype.newbyteorder("="), read)

    def _struct(self, stream: MatStream, sizes: tuple[int, ...], end: int) -> Tree:
        """One struct as its fields; of an array of them, each under its number."""
        length = int(self._numbers(stream, end)[0])
        texts = self._bytes(stream, self.element(stream, end))
        if length <= 0:
            raise ValueError("the length of the names of fields is not above zero")
        names = [
            texts[at : at + length].split(b"\0")[0].decode("ascii", "replace")
            for at in range(0, len(texts), length)
        ]
        fields = list(self._matrices(stream, end))
        if len(fields) != math.prod(sizes) * len(names):
            raise ValueError("a struct lacks fields")
        if len(fields) == len(names):
            return dict(zip(names, fields, strict=True))
        structs = range(0, len(fields), max(len(names), 1))
        return {
            str(number): dict(zip(names, fields[at : at + len(names)], strict=True))
            for number, at in enumerate(structs)
        }

    def _matrices(self, stream: MatStream, end: int) -> Iterator[LogField | Tree]:
        while stream.at < end:
            _, field = self.matrix(stream, self.element(stream, end))
            yield field

    def _whole(self, stream: MatStream) -> int:
        return int.from_bytes(stream.take(4), _ORDERS[self.order])

    def _dtype(self, element: _Element) -> np.dtype:
        kind = _NUMBERS.get(element.kind)
        if kind is None:
            raise ValueError(f"element of type {element.kind} where numbers should be")
        return np.dtype(self.order + kind)

    def _numbers(self, stream: MatStream, limit: int) -> np.ndarray:
        element = self.element(stream, limit)
        return np.frombuffer(self._bytes(stream, element), self._dtype(element))

    def _text(self, stream: MatStream, limit: int) -> str:
        element = self.element(stream, limit)
        return self._bytes(stream, element).decode("utf-8", "replace")

    def _bytes(self, stream: MatStream, element: _Element) -> bytes:
        """The data of an element that is short, as far as anybody looks at it."""
        data = stream.take(min(element.size, _LONGEST))
        stream.skip_to(element.end)
        return data


def read_mat(path: Path, stack: ExitStack) -> Tree:
    """Variables and structs; element k, from 0, of a struct array is `name.k`."""
    if is_hdf5(path):
        tree = read_hdf5(path, stack)
    else:
        tree = variables(stack.enter_context(path.open("rb")))
    return with_objects(tree, path, stack)
