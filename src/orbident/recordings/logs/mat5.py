"""MATLAB's files up to -v7 (Level 5), by MathWorks' "MAT-File Format".

A file is a header of 128 bytes and elements: a tag (type, bytes), then data. A matrix
is an element of elements: flags, sizes, name, and its numbers or its fields. Every
length is checked against what is there; SciPy's reader, which is not meant for damaged
files, ends the process over some of them.
"""

import math
import zlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from orbident.recordings.logs.group import LogField, Tree, field_of, unusable

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
_HEADER = 128
_LARGEST = 2**31
"""Bytes of a variable when it is decompressed."""
_OBJECT = (
    "is a MATLAB object, such as a timeseries or a table; save it as a struct: "
    "s = struct('time', x.Time, 'data', x.Data)"
)


class _Element(NamedTuple):
    kind: int
    data: memoryview


class _Matrix(NamedTuple):
    name: str
    field: LogField | Tree


def variables(content: bytes) -> Tree:
    """The variables of a file by name, structs as trees.

    Args:
        content: of the whole file.

    Raises:
        ValueError: It is cut off, or does not keep to the format.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:_HEADER])
    if order is None or content[124:126] not in {b"\0\1", b"\1\0"}:
        raise ValueError("its header is not of version 5; save it with -v7")
    found = {}
    for each in _elements(memoryview(content)[_HEADER:], order):
        element = each
        if element.kind == _COMPRESSED:
            data = zlib.decompressobj().decompress(element.data, _LARGEST)
            element = next(_elements(memoryview(data), order))
        if element.kind != _MATRIX:
            raise ValueError(f"element of type {element.kind} is no variable")
        name, field = _matrix(element.data, order)
        # What has no name belongs to MATLAB's own objects.
        if name:
            found[name] = field
    return found


def _elements(data: memoryview, order: str) -> Iterator[_Element]:
    """One after the other; data of up to 4 bytes stand within the tag."""
    at = 0
    while at < len(data):
        if at + 8 > len(data):
            raise ValueError("it ends within a tag")
        kind, size = (int(each) for each in np.frombuffer(data[at:], order + "u4", 2))
        start = at + 8
        if kind >> 16:
            kind, size, start = kind & 0xFFFF, kind >> 16, at + 4
            end = at + 8
        else:
            # To a multiple of 8 bytes, unless compressed; the last may go without.
            end = start + size if kind == _COMPRESSED else start + -(-size // 8) * 8
        if start + size > len(data) or (start == at + 4 and size > 4):
            raise ValueError("it ends within a variable, so it is cut off or damaged")
        yield _Element(kind, data[start : start + size])
        at = end


def _matrix(data: memoryview, order: str) -> _Matrix:
    if not data:
        return _Matrix("", unusable("is empty"))
    parts = _elements(data, order)
    flags = int(_numbers(next(parts), order)[0])
    if flags & 0xFF > _NUMERIC[-1]:
        # Functions and objects have no sizes; their name comes first.
        return _Matrix(_text(next(parts)), unusable(_OBJECT))
    sizes = tuple(int(size) for size in _numbers(next(parts), order))
    name = _text(next(parts))
    if min(sizes, default=0) < 0:
        raise ValueError("a size is negative")
    return _Matrix(name, _content(flags, sizes, parts, order))


def _content(
    flags: int, sizes: tuple[int, ...], parts: Iterator[_Element], order: str
) -> LogField | Tree:
    """What stands behind the name of a matrix."""
    kind = flags & 0xFF
    if kind == _STRUCT:
        return _struct(parts, sizes, order)
    if kind == _CELL:
        cells = [_matrix(each.data, order).field for each in parts]
        if cells and all(map(_is_text, cells)):
            return cells[0]
        return {str(k): each for k, each in enumerate(cells)}
    if kind not in _NUMERIC:
        return unusable(_problem(kind, parts))
    if flags & _COMPLEX:
        return unusable("holds complex numbers; write real numbers")
    numbers = _numbers(next(parts), order)
    if numbers.size != math.prod(sizes):
        raise ValueError(f"{numbers.size} numbers are no matrix of {sizes}")
    matrix = numbers.reshape(sizes, order="F")
    return field_of(matrix.shape, matrix.dtype, lambda: matrix)


def _is_text(field: LogField | Tree) -> bool:
    return isinstance(field, LogField) and field.problem.startswith("holds text")


def _struct(parts: Iterator[_Element], sizes: tuple[int, ...], order: str) -> Tree:
    """One struct as its fields; of an array of them, each under its number from 0."""
    length = int(_numbers(next(parts), order)[0])
    texts = bytes(next(parts).data)
    if length <= 0:
        raise ValueError("the length of the names of fields is not above zero")
    names = [
        texts[at : at + length].split(b"\0")[0].decode("ascii", "replace")
        for at in range(0, len(texts), length)
    ]
    fields = [_matrix(each.data, order).field for each in parts]
    if len(fields) != math.prod(sizes) * len(names):
        raise ValueError("a struct lacks fields")
    if len(fields) == len(names):
        return dict(zip(names, fields, strict=True))
    structs = range(0, len(fields), max(len(names), 1))
    return {
        str(number): dict(zip(names, fields[at : at + len(names)], strict=True))
        for number, at in enumerate(structs)
    }


def _problem(kind: int, parts: Iterator[_Element]) -> str:
    if kind == _CHAR:
        text = _text(next(parts)).replace("\0", "")
        return f"holds text, {text[:40]!r}; write it as numbers"
    return "is a sparse matrix; save it as full(x)" if kind == 5 else _OBJECT


def _numbers(element: _Element, order: str) -> np.ndarray:
    kind = _NUMBERS.get(element.kind)
    if kind is None:
        raise ValueError(f"element of type {element.kind} where numbers should be")
    numbers = np.frombuffer(element.data, order + kind)
    return numbers.astype(numbers.dtype.newbyteorder("="), copy=False)


def _text(element: _Element) -> str:
    return bytes(element.data).decode("utf-8", "replace")
