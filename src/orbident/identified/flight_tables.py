"""A robot's filter as a constant table in C: `robot.h` of a flight build."""

import zlib
from collections.abc import Iterable, Sequence

import numpy as np

from orbident import _core
from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.prior import GaussianPrior
from orbident.model.formulas import formulas_of
from orbident.robot.description import Joint, Robot, Wheel

SPARSE = (
    "theta_of_linear",
    "theta_of_sigma",
    "theta_of_beta",
    "pi_of_shown",
    "pi_of_products",
)
PER_LINE = 6
"""Numbers."""

Floats = Sequence[float] | np.ndarray


def robot_header(
    robot: Robot,
    kalman: Extended,
    prior: GaussianPrior,
    change: np.ndarray,
    detector: Detector,
) -> str:
    """The text of `robot.h`; every number is written to its last bit.

    Args:
        robot: whose filter it is.
        kalman: the filter, with its noise.
        prior: what is believed of `beta` beforehand.
        change: `L` of the covariance `L L^T` that a change of the robot adds.
        detector: of changes.
    """
    tables = _core.flight_tables(kalman.core)
    memory, state = _core.flight_memory(kalman.core, detector.window)
    sets, own = kalman.sets, kalman.sets.regressors
    sigmas, iotas = sets.base.sigmas, sets.iotas
    joints, wheels = len(robot.joints), len(robot.wheels)
    arrays = [
        *(_sparse_parts(name, tables[name]) for name in SPARSE),
        _whole("PRODUCT", tables["product"]),
        _whole("PAIR", tables["pair"]),
        reals("BETA", prior.beta),
        reals("ROOT", prior.root),
        reals("OPENING", change),
    ]
    if joints:
        arrays.append(_list("orbident_joint", "JOINT", map(_joint, robot.joints)))
    if wheels:
        arrays.append(_list("orbident_wheel", "WHEEL", map(_wheel, robot.wheels)))
    body = "\n".join(arrays)
    sparse = {name: _sparse(name, tables) for name in SPARSE}
    fields = [
        f"{_mark(robot, body)}L, {joints}, {wheels}",
        f"{'ROBOT_JOINT' if joints else '0'}, {'ROBOT_WHEEL' if wheels else '0'}",
        f"{sparse['theta_of_linear']}, {sparse['theta_of_sigma']}",
        f"ROBOT_PRODUCT, {len(tables['product']) // 2}, {sparse['theta_of_beta']}",
        f"{_axes(own.momentum_axes)}, {_axes(own.velocity_axes)}",
        f"{{{_reals(kalman.noise[:11])}}}, {int(kalman.noise.accelerometer)}",
        f"{sparse['pi_of_shown']}, {sparse['pi_of_products']}",
        f"ROBOT_PAIR, {len(sets.pi_of_beta)}, {sigmas}, {iotas}",
        "ROBOT_BETA, ROBOT_ROOT, ROBOT_OPENING",
        f"{detector.window}, {_real(detector.threshold)}",
    ]
    return _TEMPLATE.format(
        memory=memory,
        state=state,
        measured=2 * joints + wheels + 16,
        betas=1 + sigmas + iotas,
        meaning="\n".join(_meaning(robot, kalman)),
        body=body,
        fields=",\n    ".join(fields),
    )


_TEMPLATE = """\
/* The constant table of a robot and its filter: see orbident/flight.h. */
#ifndef ORBIDENT_ROBOT_H
#define ORBIDENT_ROBOT_H

#include "orbident/flight.h"

#define ROBOT_MEMORY {memory} /* numbers of a filter, */
#define ROBOT_STATE {state} /* those to keep to go on later, */
#define ROBOT_MEASURED {measured} /* of a sample, */
#define ROBOT_BETAS {betas} /* of the estimate: */
{meaning}

#define R(x) ((orbident_real)(x))

{body}
ORBIDENT_CONSTANT orbident_robot ROBOT = {{
    {fields}}};

#undef R

#endif
"""


def reals(name: str, values: Floats) -> str:
    """A constant array of the filter's scalar, named after the robot."""
    return _list("orbident_real", name, map(_real, np.ravel(values)))


def hexadecimal(value: float) -> str:
    """A number to its last bit, as C and C++ read it."""
    # Hexadecimal floats have no name for what is not a number.
    return float(value).hex() if np.isfinite(value) else "(double)NAN"


def _meaning(robot: Robot, kalman: Extended) -> list[str]:
    base = formulas_of(robot, kalman.sets).base
    pairs = zip(base.names, base.formulas, strict=True)
    lines = (" = ".join(dict.fromkeys(pair)) for pair in pairs)
    # No name of a body may end the comment.
    return [f"/*   {line.replace('*/', '* /')} */" for line in lines]


def _mark(robot: Robot, body: str) -> int:
    """A number of this table, at least 1, that a float holds exactly."""
    return 1 + zlib.crc32(f"{robot.name}\n{body}".encode()) % (2**24 - 1)


def _joint(joint: Joint) -> str:
    turns = int(joint.kind == "revolute")
    parts = (joint.axis, joint.R_PJ, joint.p_PJ)
    numbers = ", ".join(f"{{{_reals(part)}}}" for part in parts)
    return f"{{{joint.parent}, {turns}, {numbers}}}"


def _wheel(wheel: Wheel) -> str:
    return f"{{{{{_reals(wheel.axis)}}}, {_real(wheel.inertia)}}}"


def _axes(axes: tuple[int, ...]) -> str:
    three = [*axes, 0, 0][:3]
    return f"{{{', '.join(map(str, three))}}}, {len(axes)}"


def _sparse_parts(name: str, table: tuple[np.ndarray, ...]) -> str:
    first, row, value = table
    name = name.upper()
    parts = [_whole(f"{name}_FIRST", first), _whole(f"{name}_ROW", row)]
    return "\n".join([*parts, reals(f"{name}_VALUE", value)])


def _sparse(name: str, tables: dict) -> str:
    parts = ", ".join(
        f"ROBOT_{name.upper()}_{part}" for part in ("FIRST", "ROW", "VALUE")
    )
    return f"{{{parts}, {len(tables[name][0]) - 1}}}"


def _whole(name: str, values: np.ndarray) -> str:
    return _list("int", name, (str(int(value)) for value in values))


def _list(kind: str, name: str, items: Iterable[str]) -> str:
    # An array has at least one entry in C.
    every = list(items) or ["0"]
    rows = [", ".join(every[k : k + PER_LINE]) for k in range(0, len(every), PER_LINE)]
    inside = ",\n    ".join(rows)
    return f"ORBIDENT_CONSTANT {kind} ROBOT_{name}[] = {{\n    {inside}}};"


def _reals(values: Floats) -> str:
    return ", ".join(map(_real, np.ravel(values)))


def _real(value: float) -> str:
    return f"R({hexadecimal(value)})"
