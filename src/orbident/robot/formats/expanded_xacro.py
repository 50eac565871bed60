"""A xacro file to the URDF that it stands for, by the `xacro` package of ROS."""

import io
from contextlib import redirect_stderr
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import one_line


def expanded_xacro(path: Path) -> str:
    """The URDF's text, with the defaults of the file's arguments.

    The file's expressions are run as Python: `xacro` bars names that are not meant
    for them, but this is no protection against somebody who means harm.

    Args:
        path: of the xacro file; what it includes is looked for from its folder.

    Raises:
        InputError: the file does not expand: an argument without a default, a
            macro, a property or a file that is not there, no XML.
        MissingLibraryError: the extra `xacro` is not installed.
    """
    with extra("xacro", f"{path}: a xacro file"):
        import xacro
    # What xacro finds odd it prints; whether the URDF is right is seen below.
    try:
        with redirect_stderr(io.StringIO()):
            expanded: Any = xacro.process_file(str(path))
    except ExpatError as error:
        raise InputError(f"{path}: malformed XML: {error}; repair the file") from None
    except RecursionError:
        raise InputError(
            f"{path}: xacro does not come to an end: a macro or a file contains "
            "itself; take out the circle"
        ) from None
    # A file's expressions may raise anything.
    except Exception as error:
        raise InputError(_refused(path, error)) from error
    return expanded.toxml()


def _refused(path: Path, error: Exception) -> str:
    said = one_line(error)
    if "Undefined substitution argument" in said:
        cure = (
            'give it a default (<xacro:arg name="..." default="..."/>), or expand the '
            f"file yourself: xacro {path.name} NAME:=VALUE > robot.urdf"
        )
    elif "package" in said or "ament" in said:
        cure = "expand the file where ROS is: xacro FILE > robot.urdf"
    else:
        cure = "correct the file"
    return f"{path}: xacro cannot expand it: {said}; {cure}"
