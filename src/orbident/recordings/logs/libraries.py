"""The optional libraries that read files of other tools; nothing else imports them."""

from types import ModuleType
from typing import Any

from orbident.extras import extra


def hdf5() -> ModuleType:
    """The library h5py.

    Raises:
        MissingLibraryError: it is not installed.
    """
    with extra("hdf5", "reading HDF5, which MATLAB's -v7.3 files are too,"):
        import h5py
    return h5py


def ulog_reader() -> Any:
    """The class of the library pyulog that reads a log.

    Raises:
        MissingLibraryError: it is not installed.
    """
    with extra("ulog", "reading a PX4 log"):
        from pyulog import ULog
    return ULog
