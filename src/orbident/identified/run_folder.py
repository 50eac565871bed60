"""The folder that keeps a result: `result.json`, the robot and its URDF, signals."""

import json
import os
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.result import Estimate, Estimates, Result
from orbident.identified.result_document import check_content
from orbident.identified.signals_file import read_signals, write_signals
from orbident.robot.robot_file import load_robot, write_robot
from orbident.signals.delays import Delay

SIGNALS, HISTORY = "signals.parquet", "history.csv"


def save_result(result: Result, folder: Path, force: bool = False) -> None:
    """Write a RUN folder.

    Raises:
        InputError: the folder exists and `force` is false, or cannot be written.
    """
    check_absent(folder, force)
    # They may come from the folder that is replaced.
    signals = result.signals()
    try:
        if folder.is_dir():
            shutil.rmtree(folder)
        folder.mkdir(parents=True)
        write_robot(result.robot, folder)
        text = json.dumps(result.to_json(), indent=1)
        (folder / "result.json").write_text(text, encoding="utf-8")
        write_signals(signals, folder / SIGNALS)
        if result.history is not None:
            _write_history(result, folder / HISTORY)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{folder}: cannot be written ({reason})") from error


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
    """Refuse a RUN folder that exists.

    Raises:
        InputError: it exists and `force` is false, or is something else than a RUN.
    """
    if not folder.exists():
        _check_above(folder)
        return
    if not force:
        raise InputError(f"{folder}: exists already; name another, or use --force")
    if not (folder / "result.json").is_file():
        raise InputError(f"{folder}: is not a RUN folder, so it is not overwritten")


def _check_above(folder: Path) -> None:
    above = next(above for above in folder.absolute().parents if above.exists())
    if not above.is_dir():
        raise InputError(f"{folder}: '{above}' is a file; name a place in a folder")
    if not os.access(above, os.W_OK):
        raise InputError(f"{folder}: cannot be written (Permission denied)")


def load_result(folder: Path) -> Result:
    """Read a RUN folder.

    Raises:
        InputError: a file is missing or is not what `identify` writes.
    """
    path = folder / "result.json"
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); give the folder that "
            "'orbident identify -o' wrote"
        ) from error
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: is not JSON, or was cut off: see line {error.lineno}, column "
            f"{error.colno}; identify again"
        ) from None
    except (ValueError, RecursionError):
        raise InputError(f"{path}: is not JSON; identify again") from None
    robot = load_robot(folder / "robot.yaml")
    check_content(document, robot.joint_names, path)
    mass = document["mass"]
    return Result(
        robot=robot,
        method=document["method"],
        initial_momentum=document["initial_momentum"],
        status=document["status"],
        warnings=tuple(document["warnings"]),
        mass=Estimate(_number(mass["value"]), _number(mass["std"])),
        mass_forms=_estimates(mass["forms"]),
        pi=_estimates(document["pi"]),
        phi=_estimates(document["phi"]),
        base=_estimates(document["base"]),
        base_covariance=_table(document["base"]["covariance"]),
        condition_number={
            name: _number(value) for name, value in document["condition_number"].items()
        },
        residual=document["residual"],
        biases=document["biases"],
        clocks={
            sensor: Delay(_number(d["late"]), _number(d["std"]), d["corrected"])
            for sensor, d in document["clocks"].items()
        },
        rejected=document["rejected"],
        origins=document["signals"],
        samples=document["samples"],
        motion=document.get("motion", {}),
        input=document.get("input", {}),
        signals=partial(read_signals, folder / SIGNALS),
        elapsed_s=document["elapsed_s"],
        versions=document["versions"],
    )


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _table(rows: list[list[float | None]]) -> np.ndarray:
    table = np.array([[_number(value) for value in row] for row in rows])
    return table.reshape(len(rows), -1)


def _estimates(document: dict[str, Any]) -> Estimates:
    return Estimates(
        names=tuple(document["names"]),
        formulas=tuple(document["formulas"]),
        values=np.array([_number(value) for value in document["values"]]),
        std=np.array([_number(value) for value in document["std"]]),
    )
