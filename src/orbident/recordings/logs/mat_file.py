"""MATLAB files: up to -v7 by SciPy, -v7.3 as the HDF5 that it is."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from orbident.recordings.logs.group import Tree, in_memory, unusable
from orbident.recordings.logs.hdf5_file import is_hdf5, read_hdf5

_OBJECT = (
    "is a MATLAB object, such as a timeseries or a table; save it as a struct: "
    "s = struct('time', x.Time, 'data', x.Data)"
)


def read_mat(path: Path, stack: ExitStack) -> Tree:
    """Variables and structs; element k, from 0, of a struct array is `name.k`."""
    if is_hdf5(path):
        return read_hdf5(path, stack)
    from scipy.io import loadmat

    variables = loadmat(path, simplify_cells=True)
    return _tree({k: v for k, v in variables.items() if not k.startswith("__")})


def _tree(node: Mapping[str, Any]) -> Tree:
    return {name: _branch(each) for name, each in node.items()}


def _branch(value: Any) -> Any:
    from scipy.io.matlab import MatlabFunction, MatlabObject, MatlabOpaque

    if isinstance(value, MatlabFunction | MatlabObject | MatlabOpaque):
        return unusable(_OBJECT)
    if isinstance(value, dict):
        return _tree(value)
    parts = value if isinstance(value, list) else _structs(value)
    if parts and all(isinstance(each, dict) for each in parts):
        return _tree({str(k): each for k, each in enumerate(parts)})
    return in_memory(value) if not isinstance(value, list) else _cell()


def _structs(value: Any) -> list[Any]:
    if isinstance(value, np.ndarray) and value.dtype.kind == "O":
        return list(value.flat)
    return []


def _cell() -> Any:
    return unusable("is a cell array; save its numbers as a matrix")
