"""The data of the paper's Figs. 6 to 13, as columns with units."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_trapezoid

from orbident.estimation.result import Result
from orbident.identified.prediction import predict
from orbident.recordings.recording import Recording
from orbident.recordings.table_writer import write_blocks
from orbident.robot.description import Robot
from orbident.studies.mocap_method import yaw_of

Column = Float[np.ndarray, " n"]


class Figure(NamedTuple):
    """What one figure of the paper shows."""

    title: str
    columns: Mapping[str, Column]
    """Columns by name with unit; time comes first."""


class Measured(NamedTuple):
    """A recording as the sensors gave it, and what was made of it."""

    raw: Recording
    ready: Recording
    """The recording with rates of joints and base, and the velocity of S."""


def planar_figures(
    robot: Robot,
    identification: Measured,
    burn: Recording,
    validation: Measured,
    result: Result,
) -> dict[str, Figure]:
    """The figures by name, `fig06` to `fig13`.

    Args:
        robot: the robot that flew.
        identification: what was measured on Table 5's trajectory.
        burn: the recording of Section 5.5's burn.
        validation: what was measured on Eq. 47's trajectory.
        result: the result of the identification, which predicts the validation.
    """
    predicted = _predicted(result, validation)
    return {
        "fig06": Figure(
            "Measured joint angles and rates", _joints(robot, identification)
        ),
        "fig07": Figure("Measured base angle and rate", _base(identification)),
        "fig08": Figure("Measured position and velocity of S", _point(identification)),
        "fig09": Figure("Translation of S in the burn", _burn(burn)),
        "fig10": Figure(
            "Validation: joint angles and rates", _joints(robot, validation)
        ),
        "fig11": Figure(
            "Validation: base angle, and rate with its prediction",
            _base(validation) | _named(predicted, "base rate z predicted (rad/s)"),
        ),
        "fig12": Figure(
            "Validation: position of S with its prediction",
            _position(validation.raw)
            | _named(predicted, *(f"S {k} predicted (m)" for k in "xy")),
        ),
        "fig13": Figure(
            "Validation: velocity of S with its prediction",
            _velocity(validation.ready)
            | _named(predicted, *(f"S velocity {k} predicted (m/s)" for k in "xy")),
        ),
    }


def write_figures(figures: Mapping[str, Figure], folder: Path) -> None:
    """Each as a CSV file, one column a curve.

    Args:
        figures: by name.
        folder: that exists.

    Raises:
        InputError: no permission.
    """
    for name, figure in figures.items():
        table = np.column_stack(list(figure.columns.values()))
        write_blocks(folder / f"{name}.csv", list(figure.columns), [table])


def _joints(robot: Robot, seen: Measured) -> dict[str, Column]:
    columns = {"t (s)": seen.raw.t}
    for name in robot.joint_names:
        columns[f"{name} angle (rad)"] = seen.raw.column(f"joint.{name}.position")
    for name in robot.joint_names:
        columns[f"{name} rate (rad/s)"] = seen.ready.column(f"joint.{name}.velocity")
    return columns


def _base(seen: Measured) -> dict[str, Column]:
    return {
        "t (s)": seen.raw.t,
        "base angle z (rad)": yaw_of(seen.raw.vector("attitude", "xyzw")),
        "base rate z (rad/s)": seen.ready.column("gyro.z"),
    }


def _point(seen: Measured) -> dict[str, Column]:
    return _position(seen.raw) | _velocity(seen.ready)


def _position(raw: Recording) -> dict[str, Column]:
    position = {f"S {k} (m)": raw.column(f"position.{k}") for k in "xy"}
    return {"t (s)": raw.t, **position}


def _velocity(ready: Recording) -> dict[str, Column]:
    rate = {f"S velocity {k} (m/s)": ready.column(f"velocity.{k}") for k in "xy"}
    return {"t (s)": ready.t, **rate}


def _burn(burn: Recording) -> dict[str, Column]:
    thrust = {f"force {k} (N)": burn.column(f"force.{k}") for k in "xy"}
    return _position(burn) | thrust


def _predicted(result: Result, seen: Measured) -> dict[str, Column]:
    """Base rate, position and velocity of S; where S is on average is not predicted."""
    prediction = predict(result, seen.ready)
    v_S = prediction.v_S[:, :2]
    r_S = cumulative_trapezoid(v_S, prediction.t, axis=0, initial=0)
    r_S += np.mean(seen.raw.vector("position")[:, :2] - r_S, axis=0)
    columns = {"base rate z predicted (rad/s)": prediction.w[:, 2]}
    for k, axis in enumerate("xy"):
        columns[f"S {axis} predicted (m)"] = r_S[:, k]
        columns[f"S velocity {axis} predicted (m/s)"] = v_S[:, k]
    return columns


def _named(columns: Mapping[str, Column], *names: str) -> dict[str, Column]:
    return {name: columns[name] for name in names}
