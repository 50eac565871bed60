"""An identified robot in files of numbers, for other programs.

Parameters are CSV, LaTeX or MATLAB's version 5, with their covariances; `H+` and the
Jacobians in one configuration are JSON.
"""

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from orbident.errors import InputError
from orbident.estimation.quantities import EstimatedSet
from orbident.estimation.result import Result
from orbident.files.json_parts import nulled
from orbident.files.names import listed, quoted
from orbident.files.replacing import replacing
from orbident.model.core_robot import lacking_rotors

COLUMNS = ("set", "parameter", "estimate", "std", "nominal", "unit", "formula")
"""The columns of the CSV file, in SI; numbers that are not determined are empty."""

SETS = ("base", "phi", "pi")
"""The sets of a result, in the order of its tables."""


def parameters_as_csv(result: Result) -> str:
    """All parameters with their standard deviations, to the last digit.

    Raises:
        InputError: the result is rejected.
    """
    result.check_accepted()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for name in SETS:
        for parameter, numbers, unit, formula in _parameters(getattr(result, name)):
            cells = ["" if math.isnan(x) else repr(x) for x in numbers]
            writer.writerow((name, parameter, *cells, unit, formula))
    return text.getvalue()


def parameters_as_latex(result: Result) -> str:
    """A `tabular` that needs no package, rounded to two digits of the deviation.

    Raises:
        InputError: the result is rejected.
    """
    result.check_accepted()
    # A name may hold a line's end, and what follows would be no comment.
    name = " ".join(result.robot.name.split())
    lines = [
        rf"% {name}, {result.method}",
        r"\begin{tabular}{lrrrl}",
        r"\hline",
        r"parameter & estimate & std & nominal & unit \\",
    ]
    for name in SETS:
        lines.append(r"\hline")
        for parameter, numbers, unit, _ in _parameters(getattr(result, name)):
            cells = [_rounded(x, numbers[1]) for x in numbers]
            unit = unit.replace(" ", r"\,").replace("^2", "$^2$")
            lines.append(" & ".join([_symbol(parameter), *cells, unit]) + r" \\")
    return "\n".join([*lines, r"\hline", r"\end{tabular}", ""])


def _parameters(
    found: EstimatedSet,
) -> Iterator[tuple[str, tuple[float, ...], str, str]]:
    """Name, estimate with deviation and nominal value, unit and formula of each."""
    numbers = np.column_stack([found.values, found.std, found.nominal]).tolist()
    return zip(
        found.names, map(tuple, numbers), found.units, found.formulas, strict=True
    )


def _rounded(x: float, std: float) -> str:
    """The number to two digits of its deviation; a dash for NaN."""
    if math.isnan(x):
        return "--"
    known = math.isfinite(std) and std > 0
    decimals = max(0, 1 - math.floor(math.log10(std))) if known else 6
    return f"${x:.{decimals}f}$"


def _symbol(parameter: str) -> str:
    r"""`sigma_1` as `\sigma_{1}`; the mass `M` has no number."""
    letter, _, number = parameter.partition("_")
    return rf"$\{letter}_{{{number}}}$" if number else f"${letter}$"


SCHEMA = "orbident/matrices/1"


def matrices_at(result: Result, q: Sequence[float]) -> dict[str, Any]:
    """`H+`, its standard deviations, and the Jacobian of each body's origin.

    Joint positions `q` are in rad or m.

    Raises:
        InputError: the result is rejected or not complete, or `q` is not a finite
            number for each joint.
    """
    robot, at = result.robot, np.array(q, dtype=float)
    if at.shape != (len(robot.joints),) or not np.isfinite(at).all():
        raise InputError(
            f"--q: found {quoted(list(q))}, expected {len(robot.joints)} finite "
            f"numbers, of {listed(robot.joint_names)}"
        )
    model = result.dynamics()
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "q": dict(zip(robot.joint_names, at.tolist(), strict=True)),
        "speeds": [
            *(f"v_cm.{k}" for k in "xyz"),
            *(f"w.{k}" for k in "xyz"),
            *robot.joint_names,
            *robot.wheel_names,
        ],
        "lacks": lacking_rotors(robot),
        "H_plus": nulled(model.H_plus(at)),
        "H_plus_std": nulled(model.H_plus_std(at)),
        "jacobians": {
            body: nulled(model.jacobian(at, body, np.zeros(3))) for body in robot.bodies
        },
    }


LONGEST = 63
"""Characters of a name in MATLAB."""


def write_mat(result: Result, path: Path) -> None:
    """Write the struct `identified`, with `base`, `phi`, `pi`, `mass` and `signals`.

    As fields these hide nothing of MATLAB's, which has a `pi` of its own. What is not
    determined is NaN. A signal has its own times, in s.

    Raises:
        InputError: the result is rejected, or the file cannot be written.
    """
    result.check_accepted()
    signals = result.signals()
    names = field_names(signal.name for signal in signals)
    content = {
        "robot": result.robot.name,
        "method": result.method,
        "level": result.level,
        "warnings": _cells(result.warnings),
        "mass": {"value": result.mass.value, "std": result.mass.std, "unit": "kg"},
        "base": {**_set(result.base), "covariance": result.base_covariance},
        "phi": _set(result.phi),
        "pi": _set(result.pi),
        "covariance_of_pi_and_phi": result.covariance,
        "signals": {
            name: {
                **signal._asdict(),
                "axes": _cells(signal.axes),
                "units": _cells(signal.units),
            }
            for name, signal in zip(names, signals, strict=True)
        },
    }
    with replacing(path) as target, target.open("wb") as file:
        savemat(
            file,
            {"identified": content},
            long_field_names=True,
            do_compression=True,
            oned_as="column",
        )


def _set(found: EstimatedSet) -> dict[str, Any]:
    return {
        "names": _cells(found.names),
        "formulas": _cells(found.formulas),
        "units": _cells(found.units),
        "values": found.values,
        "std": found.std,
        "nominal": found.nominal,
    }


def _cells(texts: Iterable[str]) -> np.ndarray:
    """A column of texts, a cell array in MATLAB."""
    texts = tuple(texts)
    cells = np.empty((len(texts), 1), dtype=object)
    cells[:, 0] = texts
    return cells


def field_names(names: Iterable[str]) -> list[str]:
    """Names that MATLAB takes for fields, all different: `second_flight_gyro`."""
    found: list[str] = []
    for k, name in enumerate(names):
        plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
        if not plain[:1].isalpha():
            plain = f"signal_{plain}"
        plain = plain[:LONGEST]
        if plain in found:
            number = f"_{k + 1}"
            plain = plain[: LONGEST - len(number)] + number
        found.append(plain)
    return found
