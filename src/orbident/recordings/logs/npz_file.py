"""NumPy's .npz files, as one saves what Basilisk's recorders hold; nothing pickled."""

import zipfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from orbident.recordings.logs.group import LogField, Tree, field_of, unusable

_PICKLED = (
    "holds Python objects, which are never loaded because loading may run a program; "
    "save an array of numbers: np.savez(..., x=np.asarray(x, dtype=float))"
)


def read_npz(path: Path, stack: ExitStack) -> Tree:
    """Arrays by name; dots and slashes in a name lead into groups."""
    stack.enter_context(zipfile.ZipFile(path))
    arrays = stack.enter_context(np.load(path, allow_pickle=False))
    tree: dict[str, Any] = {}
    for name in arrays.files:
        *groups, last = name.replace("/", ".").split(".")
        node = tree
        for each in groups:
            inner = node.setdefault(each, {})
            node = inner if isinstance(inner, dict) else tree
        node[last if last not in node else name] = _field(arrays, name)
    return tree


def _field(arrays: Any, name: str) -> LogField | Tree:
    with arrays.zip.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read = np.lib.format.read_array_header_2_0
        shape, _, dtype = read(file)
    if dtype.hasobject:
        return unusable(_PICKLED)
    # Basilisk's recorders count time in whole nanoseconds.
    unit = "ns" if name.endswith("times") and dtype.kind in "iu" else ""
    return field_of(shape, dtype, lambda: arrays[name], unit)
