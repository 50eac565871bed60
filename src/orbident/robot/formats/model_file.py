"""A robot's model in whatever format: its content shows which."""

import re
import xml.etree.ElementTree as ET
from contextlib import suppress
from io import StringIO
from pathlib import Path

from orbident.errors import InputError
from orbident.files.text import read_text
from orbident.robot.formats.expanded_xacro import expanded_xacro
from orbident.robot.formats.mjcf import mjcf_as_urdf
from orbident.robot.formats.sdf import read_sdf
from orbident.robot.formats.urdf_text import urdf_text
from orbident.robot.urdf import Urdf, read_urdf

KINDS = "a URDF, xacro, MJCF or SDF file"
SUFFIXES = (".urdf", ".xacro", ".xml", ".sdf")
"""What such files are usually called."""

_MACROS = re.compile(r"<xacro:|\$[{(]")


def read_model(path: Path) -> tuple[Urdf, str]:
    """The links and joints of a robot, and a URDF that says the same.

    Of a URDF and a xacro file the text keeps what the robot looks like.

    Args:
        path: of a URDF, xacro, MJCF or SDF file. Only xacro is also told by its
            suffix, since its expressions are run as a program.

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
