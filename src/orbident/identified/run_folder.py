"""The folder that keeps a result: `result.json`, the robot and its URDF, signals."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.quantities import (
    EstimatedSet,
    Identified,
    MassRoutes,
    Parameters,
    Quantity,
)
from orbident.estimation.result import SCHEMA, Result
from orbident.estimation.sensitivity_table import SensitivityTable
from orbident.estimation.signals import Signals
from orbident.estimation.solution import Step
from orbident.estimation.unknowns import CalibrationFit, DisturbanceFit
from orbident.files.folder_replacing import (
    finish,
    is_committed,
    is_unfinished,
    replacing_files,
)
from orbident.files.pipes import refuse_pipe
from orbident.files.replacing import UNFINISHED
from orbident.files.text import write_text
from orbident.identified.checksums import (
    FILES,
    check_document,
    check_files,
    with_checksums,
)
from orbident.identified.result_document import check_content
from orbident.identified.signals_file import read_signals, write_signals
from orbident.preprocessing.delays import Delay
from orbident.robot.robot_file import load_written_robot, write_robot

RESULT, REPORT = "result.json", "report.html"
SIGNALS, HISTORY, REPLAY = "signals.parquet", "history.csv", "replay.json"
READ = ("robot.urdf", "robot.oem", "robot.yaml", SIGNALS, HISTORY, REPLAY)
"""What may be read again. The report is not, and can be made anew at any time."""
VALIDATION = "validation.json"
"""How the result predicted a recording that was not used, by the last `validate`."""
OURS = (*READ, VALIDATION, REPORT, RESULT)
"""All that a RUN folder has of ours; the result, which vouches for the rest, last."""


def save_result(result: Result, folder: str | Path, force: bool = False) -> None:
    """Write a RUN folder, without a report.

    Args:
        result: accepted or not.
        folder: that is made; one that is there already must be empty.
        force: replace the files of a RUN that is there.

    Raises:
        InputError: the folder exists and `force` is false, or cannot be written.
    """
    with saving(result, Path(folder), force):
        pass


@contextmanager
def saving(result: Result, folder: Path, force: bool = False) -> Iterator[Path]:
    """Write a RUN folder, and what the block adds to it, all at once or not at all.

    With `force` files of ours in an existing RUN are replaced, and no others.

    Yields:
        A folder with the files so far, for `replay.json` and `report.html`.

    Raises:
        InputError: the folder exists and `force` is false, or cannot be written.
    """
    check_absent(folder, force)
    # They may come from the folder that is replaced.
    signals = result.signals()
    with replacing_files(folder, OURS) as new:
        # Another process may have been faster.
        check_absent(folder, force)
        write_robot(result.robot, new)
        write_signals(signals, new / SIGNALS)
        if result.history is not None:
            _write_history(result, new / HISTORY)
        yield new
        document = with_checksums(result.to_json(), new, READ)
        write_text(new / RESULT, json.dumps(document, indent=1))


def _write_history(result: Result, path: Path) -> None:
    """A row a sample: estimates, deviations, and what the detector saw."""
    history = result.history
    assert history is not None
    names = result.base.names
    header = ["t", *names, *(f"{name}.std" for name in names)]
    header += ["innovation_squared", "degrees_of_freedom", "change_statistic"]
    parts = (history.nis, history.dof, history.statistic)
    table = np.column_stack([history.t, history.beta, history.std, *parts])
    np.savetxt(path, table, "%.10g", ",", header=",".join(header), comments="")


def check_absent(folder: Path, force: bool) -> None:
    """Refuse a RUN folder that exists; an empty folder is none.

    Raises:
        InputError: it exists and `force` is false, or is something else than a RUN.
    """
    if not folder.exists():
        _check_above(folder)
        return
    names = _names(folder)
    if names is None:
        raise InputError(
            f"{folder}: is not a RUN folder, so it is not overwritten; name another"
        )
    if not os.access(folder, os.W_OK):
        raise InputError(f"{folder}: cannot be written (Permission denied)")
    if not force and (names or is_committed(folder)):
        raise InputError(f"{folder}: exists already; name another, or use --force")


def _names(folder: Path) -> set[str] | None:
    """What a RUN folder holds, complete or not; None for what is none."""
    if not folder.is_dir():
        return None
    names = {path.name for path in folder.iterdir() if UNFINISHED not in path.name}
    if names <= set(OURS) or is_unfinished(folder) or _is_result(folder / RESULT):
        return names
    return None


def _is_result(path: Path) -> bool:
    """Whether a file is a result of ours, of any version, complete or cut off."""
    family = SCHEMA.rpartition("/")[0].encode()
    return path.is_file() and family in path.read_bytes()


def _check_above(folder: Path) -> None:
    if folder.is_symlink():
        raise InputError(f"{folder}: is a link to nowhere; name another, or remove it")
    above = next(above for above in folder.absolute().parents if above.exists())
    if not above.is_dir():
        raise InputError(f"{folder}: '{above}' is a file; name a place in a folder")
    if not os.access(above, os.W_OK):
        raise InputError(f"{folder}: cannot be written (Permission denied)")


def load_result(folder: str | Path) -> Result:
    """Read a RUN folder; every file is checked against its checksum.

    Args:
        folder: that `save_result` or `orbident identify -o` wrote.

    Raises:
        InputError: a file is missing or is not what `identify` wrote.
    """
    folder = Path(folder)
    finish(folder, OURS)
    path = folder / RESULT
    version = _version(path)
    text = _text(path)
    try:
        return _read(text, folder)
    except InputError:
        if not is_committed(folder) and _version(path) == version:
            raise
    # It was replaced meanwhile.
    return load_result(folder)


def _version(path: Path) -> tuple[int, int] | None:
    """Which file this is: the same result, written twice, is two files."""
    with suppress(OSError):
        found = path.stat()
        return found.st_ino, found.st_mtime_ns
    return None


def _text(path: Path) -> str:
    refuse_pipe(path, "the result")
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not JSON ({error}); identify again") from error
    except OSError as error:
        if is_unfinished(path.parent) and not path.exists():
            raise InputError(
                f"{path.parent}: is not complete, 'orbident identify' was ended before "
                "that or is still at work; wait, or identify again"
            ) from error
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); give the folder that "
            "'orbident identify -o' wrote"
        ) from error


def _read(text: str, folder: Path) -> Result:
    path = folder / RESULT
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: is not JSON, or was cut off: see line {error.lineno}, column "
            f"{error.colno}; identify again"
        ) from None
    except (ValueError, RecursionError):
        raise InputError(f"{path}: is not JSON; identify again") from None
    check_document(document, path)
    check_files(document[FILES], folder, READ)
    robot = load_written_robot(folder)
    check_content(document, robot.joint_names, path)
    refused = document["diagnostics"]
    return Result(
        robot=robot,
        method=document["method"],
        initial_momentum=document["initial_momentum"],
        checks=tuple(_check(check) for check in document["checks"]),
        notes=tuple(document["notes"]),
        **vars(_identified(document)),
        diagnostics=None if refused is None else _identified(refused),
        condition_number={
            name: _number(value) for name, value in document["condition_number"].items()
        },
        residual=document["residual"],
        convergence=tuple(_step(step) for step in document.get("convergence", [])),
        biases=document["biases"],
        calibration={
            name: CalibrationFit(**fit) for name, fit in document["calibration"].items()
        },
        disturbances={
            name: DisturbanceFit(**fit)
            for name, fit in document.get("disturbances", {}).items()
        },
        sensitivity=partial(_sensitivity, document["sensitivity"]),
        clocks={
            sensor: Delay(_number(d["late"]), _number(d["std"]), d["corrected"])
            for sensor, d in document["clocks"].items()
        },
        rejected=document["rejected"],
        origins=document["origins"],
        samples=document["samples"],
        motion=document.get("motion", {}),
        input=document.get("input", {}),
        signals=partial(_signals, folder, document[FILES]),
        elapsed_s=document["elapsed_s"],
        versions=document["versions"],
    )


def _signals(folder: Path, files: dict[str, str]) -> Signals:
    """Read when they are wanted: the folder may have been replaced by then."""
    check_files(files, folder, [SIGNALS])
    return read_signals(folder / SIGNALS)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _table(rows: list[list[float | None]]) -> np.ndarray:
    table = np.array([[_number(value) for value in row] for row in rows])
    return table.reshape(len(rows), -1)


def _sensitivity(document: dict[str, Any] | None) -> SensitivityTable | None:
    if document is None:
        return None
    return SensitivityTable(
        parameters=tuple(document["parameters"]),
        errors=tuple(document["errors"]),
        units=tuple(document["units"]),
        shifts=_table(document["in_deviations"]),
    )


def _step(document: dict[str, Any]) -> Step:
    cost, size = (_number(document[key]) for key in ("cost", "size"))
    return Step(cost, size, document["round"])


def _check(document: dict[str, Any]) -> Check:
    numbers = {key: _number(document[key]) for key in ("statistic", "limit")}
    return Check(**{**document, **numbers})


def _identified(document: dict[str, Any]) -> Identified:
    mass = document["mass"]
    return Identified(
        mass=Quantity(_number(mass["value"]), _number(mass["std"])),
        mass_forms=_routes(mass["forms"]),
        pi=_set(document["pi"]),
        phi=_set(document["phi"]),
        base=_set(document["base"]),
        base_covariance=_table(document["base"]["covariance"]),
        covariance=_symmetric(document["covariance"]),
    )


def _symmetric(lower: list[list[float | None]]) -> np.ndarray:
    """A symmetric matrix, from rows that end at its diagonal."""
    matrix = np.zeros((len(lower), len(lower)))
    for k, row in enumerate(lower):
        matrix[k, : k + 1] = matrix[: k + 1, k] = [_number(value) for value in row]
    return matrix


def _set(document: dict[str, Any]) -> EstimatedSet:
    nominal = _numbers(document["nominal"])
    return EstimatedSet(**vars(_parameters(document)), nominal=nominal)


def _routes(document: dict[str, Any]) -> MassRoutes:
    return MassRoutes(
        **vars(_parameters(document)),
        sigmas=_numbers(document["sigmas"]),
        left_out=document["left_out"],
    )


def _parameters(document: dict[str, Any]) -> Parameters:
    return Parameters(
        names=tuple(document["names"]),
        formulas=tuple(document["formulas"]),
        values=_numbers(document["values"]),
        std=_numbers(document["std"]),
    )


def _numbers(values: list[float | None]) -> np.ndarray:
    return np.array([_number(value) for value in values])
