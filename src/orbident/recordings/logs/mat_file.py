"""MATLAB files: up to -v7 by their own format, -v7.3 as the HDF5 that it is."""

from contextlib import ExitStack
from pathlib import Path

from orbident.recordings.logs.group import Tree
from orbident.recordings.logs.hdf5_file import is_hdf5, read_hdf5
from orbident.recordings.logs.mat5 import variables
from orbident.recordings.logs.mat_objects import with_objects


def read_mat(path: Path, stack: ExitStack) -> Tree:
    """Variables and structs; element k, from 0, of a struct array is `name.k`."""
    if is_hdf5(path):
        tree = read_hdf5(path, stack)
    else:
        tree = variables(stack.enter_context(path.open("rb")))
    return with_objects(tree, path, stack)
