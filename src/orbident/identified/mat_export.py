"""Parameters, covariances and signals of a result as a MATLAB file (version 5)."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from orbident.estimation.quantities import EstimatedSet
from orbident.estimation.result import Result
from orbident.files.replacing import replacing

LONGEST = 63
"""Characters of a name in MATLAB."""


def write_mat(result: Result, path: Path) -> None:
    """Write the structs `base`, `phi`, `pi`, `mass`, `signals` and what they are of.

    What is not determined is NaN. A signal has its own times, in s.

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
                "name": signal.name,
                "axes": _cells(signal.axes),
                "units": _cells(signal.units),
                "t": signal.t,
                "measured": signal.measured,
                "predicted": signal.predicted,
                "std": signal.std,
            }
            for name, signal in zip(names, signals, strict=True)
        },
    }
    with replacing(path) as target, target.open("wb") as file:
        savemat(
            file, content, long_field_names=True, do_compression=True, oned_as="column"
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
