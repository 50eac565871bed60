"""HDF5 files, and MATLAB's of -v7.3, whose matrices are stored transposed."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from orbident.extras import extra
from orbident.recordings.logs.group import OBJECT, Tree, field_of, unusable

MAGIC = b"\x89HDF\r\n\x1a\n"


_ELSEWHERE = (
    "is kept in another file, which is not read; copy its numbers into this one"
)


def is_hdf5(path: Path) -> bool:
    """Whether it begins as HDF5 does, there or after MATLAB's 512 bytes."""
    with path.open("rb") as file:
        start = file.read(520)
    return start.startswith(MAGIC) or start[512:] == MAGIC


def read_hdf5(path: Path, stack: ExitStack) -> Tree:
    """Groups in groups; values are read when wanted, while the file is open.

    Raises:
        MissingLibraryError: h5py is not installed.
    """
    with extra("hdf5", "reading HDF5, which MATLAB's -v7.3 files are too,"):
        import h5py
    return _tree(h5py, stack.enter_context(h5py.File(path, "r")), set())


def leads_elsewhere(path: str) -> bool:
    """Whether anything in the file is kept in another, where MATLAB's objects are too.

    Raises:
        MissingLibraryError: h5py is not installed.
    """
    with extra("hdf5", "reading HDF5"):
        import h5py

    def leads(_: str, found: Any) -> bool | None:
        linked = isinstance(found, h5py.ExternalLink)
        return (
            linked or (isinstance(found, h5py.Dataset) and _is_elsewhere(found)) or None
        )

    with h5py.File(path) as file:
        return bool(file.visititems_links(leads) or file.visititems(leads))


def _is_elsewhere(dataset: Any) -> bool:
    return bool(dataset.external or dataset.is_virtual)


def _tree(library: Any, group: Any, above: set[Any]) -> Tree:
    # A group may contain itself.
    above = {*above, library.h5o.get_info(group.id).addr}
    tree = {}
    for name in group:
        link = group.get(name, getlink=True)
        if isinstance(link, library.ExternalLink):
            tree[name] = unusable(_ELSEWHERE)
        # Links by name within the file lead to what is listed anyway.
        if not isinstance(link, library.HardLink) or name.startswith("#"):
            continue
        each = group[name]
        if not isinstance(each, library.Group):
            tree[name] = _field(each)
        elif library.h5o.get_info(each.id).addr not in above:
            tree[name] = _tree(library, each, above)
    return tree


def _field(dataset: Any) -> Any:
    if not hasattr(dataset, "shape"):
        return unusable("is a type, not data")
    # A file that somebody sent would show what is in any other of this machine.
    if _is_elsewhere(dataset):
        return unusable(_ELSEWHERE)
    if "MATLAB_object_decode" in dataset.attrs:
        return unusable(OBJECT)
    kind = dataset.attrs.get("MATLAB_class", b"")
    if kind in {b"char", b"cell"} or dataset.dtype.kind in "OSU":
        return unusable("holds text or cells; write it as numbers")
    unit = dataset.attrs.get("units", dataset.attrs.get("unit", ""))
    text = unit.decode(errors="replace") if isinstance(unit, bytes) else str(unit)
    return field_of(dataset.shape or (), dataset.dtype, lambda: dataset[()], text)
