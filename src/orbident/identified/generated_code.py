"""`H+` and `c+` of an identified robot as C or MATLAB that needs nothing of Orbident.

The numbers of `Result.dynamics()` are tables, and the code below them is that of
`template/equations_c.txt` and `template/equations_m.txt`, the same for every robot.
"""

import re
import textwrap
from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.model.core_robot import (
    lacking_rotors,
    rotors_of,
    theta_with_rotors,
    wheels_of,
)
from orbident.model.equations_of_motion import speeds
from orbident.model.reconstruction import Dynamics
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_matrix

MATLAB_KEYWORDS = (
    *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end"),
    *("for", "function", "global", "if", "otherwise", "parfor", "persistent"),
    *("return", "spmd", "switch", "try", "while"),
)
"""What `iskeyword` lists."""

WIDTH = 96
"""Characters of a comment."""


def equations_as_c(model: Dynamics) -> str:
    """Two functions in C99, `H_plus(q, H)` and `c_plus(q, v, c)`.

    Raises:
        InputError: a joint is passive.
    """
    robot = model.robot
    sizes = {
        "JOINTS": len(robot.joints),
        "WHEELS": len(robot.wheels),
        "PLANAR": int(robot.motion == "planar"),
        "BODIES": "(JOINTS + 1)",
        "MOTIONS": "(JOINTS + 3)",
        "SPEEDS": "(6 + JOINTS + WHEELS)",
    }
    n = speeds(robot)
    lines = [
        *_comments(model, "//"),
        "#include <math.h>",
        "",
        *(f"#define {name} {size}" for name, size in sizes.items()),
        "",
        f"void H_plus(const double q[], double H[{n}][{n}]);",
        "void c_plus(const double q[], const double v[], double c[]);",
        "",
        *(_c_table(name, table) for name, table in _tables(robot)),
    ]
    return "\n".join(lines) + "\n" + template_text("equations_c.txt")


def equations_as_matlab(model: Dynamics, name: str) -> str:
    """The function `[H, c] = name(q, v)` for MATLAB, without a toolbox.

    The name is that of its file, from which MATLAB takes it.

    Raises:
        InputError: a joint is passive, or MATLAB has no such names.
    """
    template = template_text("equations_m.txt")
    taken = {*MATLAB_KEYWORDS, *re.findall(r"function .*?(\w+)\(", template)}
    if name in taken or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name):
        raise InputError(
            f"{quoted(name)} cannot be the name of this function in MATLAB; begin the "
            "file's name with a letter, use letters, digits and '_' alone, and no word "
            "of MATLAB's"
        )
    robot = model.robot
    lines = [
        f"function [H, c] = {name}(q, v)",
        *_comments(model, "%"),
        f"planar = {str(robot.motion == 'planar').lower()};",
        *(_matlab_table(name, table) for name, table in _tables(robot)),
    ]
    return "\n".join(lines) + "\n" + template


def template_text(name: str) -> str:
    """A file of `template`, which is part of what is exported."""
    return files("orbident.identified").joinpath(f"template/{name}").read_text()


def _tables(robot: Robot) -> Iterator[tuple[str, np.ndarray]]:
    """The robot's numbers by name: one entry for each joint, body or wheel.

    Rotations are written column after column.

    Raises:
        InputError: a joint is passive.
    """
    require_measured(
        robot, "the exported code", "result.dynamics() in Python has its H+ and c+"
    )
    joints, theta, wheels = robot.joints, theta_with_rotors(robot), wheels_of(robot)
    yield "parent", np.array([each.parent for each in joints], dtype=int)
    yield "slides", np.array([each.kind == "prismatic" for each in joints], dtype=int)
    yield "axis", np.reshape([each.axis for each in joints], (-1, 3))
    yield "R_PJ", np.reshape([each.R_PJ.T for each in joints], (-1, 3, 3))
    yield "p_PJ", np.reshape([each.p_PJ for each in joints], (-1, 3))
    yield "armature", rotors_of(robot).armature
    yield "mass", theta[:, MASS]
    yield "first_moment", theta[:, FIRST_MOMENT]
    yield "inertia", np.array([inertia_matrix(each) for each in theta])
    yield "wheel_axis", wheels.axes.T
    yield "wheel_inertia", wheels.inertia


def _comments(model: Dynamics, sign: str) -> list[str]:
    robot = model.robot
    joints, wheels = map(_plain, (robot.joint_names, robot.wheel_names))
    name = _plain([robot.name])
    words = [
        f"H+ and c+ of {name} in H+ v' + c+ = Q, as Orbident {version('orbident')} "
        "identified them.",
        f"q: positions of the joints ({joints}), rad or m.",
        "v = [v_cm, w, qd, qd_rw]: velocity of the system's centre of mass and rate of "
        "the base, as inertial motions in base axes, m/s and rad/s; rates of the "
        f"joints; speeds of the wheels ({wheels}) relative to the base, rad/s.",
        "v' is the derivative of these components. Q: force and moment from outside, "
        "then the torques of the motors at joints and wheels, N m or N.",
    ]
    if robot.motion == "planar":
        words.append(
            "In the plane v_cm along z and w about x and y are zero, and entries of H+ "
            "and c+ that belong to these two rates are not known: NaN."
        )
    if model.moved:
        words.append(
            f"The parameters were moved by {model.moved:.2g} standard deviations, to "
            "those of bodies that can exist."
        )
    if lacks := lacking_rotors(robot):
        words.append(f"{_plain([lacks])}.")
    words.append("SPDX-License-Identifier: Apache-2.0")
    return [
        f"{sign} {line}"
        for paragraph in words
        for line in textwrap.wrap(paragraph, WIDTH)
    ]


def _plain(names: Any) -> str:
    """Names without what could end a comment or go on in the next line."""
    kept = " -_.,:;^'"
    plain = ("".join(c for c in name if c.isalnum() or c in kept) for name in names)
    return ", ".join(plain) or "none"


def _c_table(name: str, table: np.ndarray) -> str:
    # An array has at least one entry in C.
    rows = table if len(table) else np.zeros((1, *table.shape[1:]), table.dtype)
    kind = "int" if table.dtype == int else "double"
    size = "".join(f"[{n}]" for n in rows.shape[1:])
    text = (", " if rows.ndim == 1 else ",\n  ").join(map(_braced, rows.tolist()))
    return f"static const {kind} {name.upper()}[]{size} = {{{text}}};"


def _braced(entry: Any) -> str:
    if isinstance(entry, list):
        return f"{{{', '.join(map(_braced, entry))}}}"
    return repr(entry)


def _matlab_table(name: str, table: np.ndarray) -> str:
    rows = (map(repr, np.ravel(row).tolist()) for row in table)
    text = (", " if table.ndim == 1 else ", ...\n  ").join(map(", ".join, rows))
    size = ", ".join(map(str, (*table.shape[:0:-1], len(table))))
    size = f"1, {size}" if table.ndim == 1 else size
    return f"{name} = reshape([{text}], {size});"
