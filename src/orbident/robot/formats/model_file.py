"""A robot's model in whatever format: its content shows which.

A xacro file is first expanded to the URDF that it stands for, by the package of ROS.
"""

import errno
import os
import re
import sys
import xml.etree.ElementTree as ET
from contextlib import suppress
from io import StringIO
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

from orbident.errors import InputError
from orbident.extras import extra, require_library
from orbident.files.confined import ConfinedError, confined
from orbident.files.names import one_line
from orbident.files.text import read_text
from orbident.robot.formats.mjcf import mjcf_as_urdf
from orbident.robot.formats.sdf import read_sdf
from orbident.robot.urdf import Urdf, urdf_text
from orbident.robot.urdf_reader import read_urdf

KINDS = "a URDF, xacro, MJCF or SDF file"
SUFFIXES = (".urdf", ".xacro", ".xml", ".sdf")
"""What such files are usually called."""

_MACROS = re.compile(r"<xacro:|\$[{(]")


def read_model(path: Path) -> tuple[Urdf, str]:
    """The links and joints of a robot, and a URDF that says the same.

    Of a URDF and a xacro file the text keeps what the robot looks like. Only xacro is
    also told by its suffix, since its expressions are run as a program.

    Raises:
        InputError: the file is no robot; see the readers.
        MissingLibraryError: the extra that this kind of file needs is not installed.
    """
    text, place = read_text(path), str(path)
    expanded = path.suffix.lower() == ".xacro"
    # The libraries of both formats read the file once more.
    if (expanded or _root(text) == "mujoco") and not path.is_file():
        raise InputError(f"{place}: is a pipe, which can be read once; give a file")
    if expanded:
        text = expanded_xacro(path)
    root = _root(text)
    if root == "sdf":
        return as_urdf(read_sdf(text, place))
    if root == "mujoco":
        text = mjcf_as_urdf(text, path)
    if not expanded and "xmlns:xacro" in text and _MACROS.search(text):
        raise InputError(
            f"{place}: this is xacro, whose expressions are run as a program; if you "
            f"trust the file, rename it to {path.stem}.xacro"
        )
    return read_urdf(text, place), text


def as_urdf(tree: Urdf) -> tuple[Urdf, str]:
    """Links and joints that another format gave, as the URDF that says the same.

    Raises:
        InputError: what no URDF may say either: see `read_urdf`.
    """
    text = urdf_text(tree)
    return read_urdf(text, tree.place), text


def _root(text: str) -> str:
    """The name of the root element; nothing where it is no XML."""
    with suppress(ET.ParseError, ValueError):
        for _, element in ET.iterparse(StringIO(text), events=("start",)):
            return element.tag
    return ""


_SECONDS, _MEGABYTES = 3, 500
"""Robots with two arms and hands take half a second and 50 MB."""

_PACKAGES = "AMENT_PREFIX_PATH"
"""The variable by which `$(find PACKAGE)` finds the packages of ROS."""

_ACTS = ("os.", "subprocess.", "socket.", "ctypes.", "shutil.")
"""What begins the names of events that reach out of a program."""

_OUTSIDE = "is outside of what a xacro file may read"


def expanded_xacro(path: Path) -> str:
    """The URDF's text, with the defaults of the file's arguments.

    The file's expressions are run as Python, in a child process with little time and
    memory. It may read what is below the file's own folder, or below the package of ROS
    that this folder is in, and in the packages that ROS knows; and no environment. What
    the file includes is looked for from its folder.

    Raises:
        InputError: the file does not expand: an argument without a default, a
            macro, a property or a file that is not there or not allowed, no XML, too
            much time or memory.
        MissingLibraryError: the extra `xacro` is not installed.
    """
    with extra("xacro", f"{path}: a xacro file"):
        require_library("xacro")
    try:
        return confined(expand_here, str(path), seconds=_SECONDS, megabytes=_MEGABYTES)
    except ConfinedError as error:
        raise InputError(
            f"{path}: xacro {error} with this file; correct its expressions"
        ) from None


def expand_here(place: str) -> str:
    """What `expanded_xacro` gives; it takes rights from this process.

    Raises:
        InputError: as `expanded_xacro`.
    """
    import xacro

    packages = os.environ.get(_PACKAGES, "")
    os.environ.clear()
    os.environ[_PACKAGES] = packages
    allowed = [_package(Path(place)), *filter(None, packages.split(os.pathsep))]
    # xacro imports modules when it needs them.
    sys.addaudithook(_Warden(*allowed, *filter(None, sys.path)))
    try:
        expanded: Any = xacro.process_file(place)
        return expanded.toxml()
    except ExpatError as error:
        raise InputError(f"{place}: malformed XML: {error}; repair the file") from None
    except RecursionError:
        raise InputError(
            f"{place}: xacro does not come to an end: a macro or a file contains "
            "itself; take out the circle"
        ) from None
    # A file's expressions may raise anything, which xacro wraps.
    except Exception as error:
        cause = getattr(error, "exc", error)
        if isinstance(cause, MemoryError):
            raise cause from None
        raise InputError(_refused(Path(place), error)) from None


def _package(path: Path) -> Path:
    """The folder of the package that a file is in, or the file's own."""
    folders = path.resolve().parents
    inside = (each for each in folders if (each / "package.xml").is_file())
    return next(inside, folders[0])


class _Warden:
    """Refuses other files than those in some folders, programs and the network."""

    def __init__(self, *folders: str | Path) -> None:
        self._folders = [os.path.realpath(folder) for folder in folders]

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and not isinstance(arguments[0], int):
            path, _, flags = arguments
            real = Path(os.path.realpath(os.fsdecode(path)))
            writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            if writes or not any(map(real.is_relative_to, self._folders)):
                raise PermissionError(errno.EACCES, _OUTSIDE, str(path))
        # What looks for modules lists folders.
        elif event.startswith(_ACTS) and event not in {"os.listdir", "os.scandir"}:
            raise PermissionError(errno.EACCES, _OUTSIDE, event)


def _refused(path: Path, error: Exception) -> str:
    said, cause = one_line(error), getattr(error, "exc", None)
    # xacro repeats what a file or an expression raised.
    if isinstance(cause, OSError):
        said = f"'{cause.filename}' {cause.strerror}"
    elif cause and said.count(one_line(cause)) > 1:
        said = one_line(cause)
    yourself = f"expand the file yourself: xacro {path.name} NAME:=VALUE > robot.urdf"
    if "Undefined substitution argument" in said:
        cure = (
            f'give it a default (<xacro:arg name="..." default="..."/>), or {yourself}'
        )
    elif "package" in said or "ament" in said:
        cure = "expand the file where ROS is: xacro FILE > robot.urdf"
    elif _OUTSIDE in said or "environment variable" in said:
        cure = f"if you trust it, {yourself}"
    else:
        cure = "correct the file"
    return f"{path}: xacro cannot expand it: {said}; {cure}"
