"""Section 5 for one seed: three recordings, two ways to read them, one burn.

The data of the paper's Figs. 6 to 13, as columns with units.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_trapezoid

from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.estimation.weigh import Weighing, weigh
from orbident.identified.prediction import predict
from orbident.identified.validate import SCORED, Validation, scored
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_blocks
from orbident.robot.description import Robot
from orbident.studies.paper_method import (
    Filters,
    PaperParameters,
    from_mocap,
    mass_by_slopes,
    paper_method,
    yaw_of,
)
from orbident.studies.planar import Flights, ideal_record, measured_record


class Records(NamedTuple):
    """What was recorded of each flight."""

    identification: Recording
    burn: Recording
    validation: Recording


class PlanarReading(NamedTuple):
    """What one way of signal processing comes to."""

    result: Result
    identification: Recording
    """As identification was given it."""
    validation: Recording
    """As prediction was given it."""
    scores: Validation | None
    """None where the result cannot predict."""

    def quantities(self, table: PaperParameters) -> Float[np.ndarray, " quantities"]:
        """Errors of Table 6's parameters in percent, and both NRMSE."""
        nrmse = [np.nan] * len(SCORED)
        if self.scores is not None:
            nrmse = [self.scores.nrmse[name] for name in SCORED]
        return np.concatenate([table.errors(table.found(self.result)), nrmse])


class PlanarRun(NamedTuple):
    """One seed."""

    records: Records
    readings: dict[str, PlanarReading]
    """Readings by method, the paper's first."""
    weighing: Weighing
    by_slopes: float
    """M from two slopes, kg."""

    def quantities(self, table: PaperParameters) -> Float[np.ndarray, " quantities"]:
        """Quantities of each reading, and the errors of M from the burn, percent."""
        M = np.array([self.weighing.mass.value, self.by_slopes])
        readings = [reading.quantities(table) for reading in self.readings.values()]
        return np.concatenate([*readings, 100 * (M / table.true[-1] - 1)])


class PaperFilters(NamedTuple):
    """The filters of the two recordings that are differentiated: what moves differs."""

    identification: Filters
    validation: Filters


def run_ideal(robot: Robot, flights: Flights, method: Method) -> PlanarRun:
    """Run with ideal sensors of everything: there is nothing to be filtered."""
    records = Records(*(ideal_record(robot, flight) for flight in flights))
    result = identify(robot, records.identification, method, "at-rest")
    reading = _read(result, records.identification, records.validation)
    return _run(robot, records, {method: reading})


def run_noisy(
    robot: Robot, flights: Flights, filters: PaperFilters, seed: int, method: Method
) -> PlanarRun:
    """Run with the sensors of the robot's file; each recording has a noise of its own.

    Args:
        robot: the robot that flew.
        flights: all flights of Section 5.
        filters: the filters of the paper's method.
        seed: the seed of the three recordings' noise.
        method: the method of `identify`, which takes the recordings unfiltered.
    """
    seeds = (len(flights) * seed + k for k in range(len(flights)))
    records = Records(
        *(
            measured_record(robot, flight, own)
            for flight, own in zip(flights, seeds, strict=True)
        )
    )
    raw = records.identification, records.validation
    filtered = [
        from_mocap(robot, recording, own)
        for recording, own in zip(raw, filters, strict=True)
    ]
    readings = {
        "paper": _read(paper_method(robot, filtered[0], "at-rest"), *filtered),
        method: _read(identify(robot, raw[0], method, "at-rest"), *raw),
    }
    return _run(robot, records, readings)


def _run(
    robot: Robot, records: Records, readings: dict[str, PlanarReading]
) -> PlanarRun:
    burn = records.burn
    return PlanarRun(records, readings, weigh(robot, burn), mass_by_slopes(burn))


def _read(
    result: Result, identification: Recording, validation: Recording
) -> PlanarReading:
    complete = np.isfinite([*result.pi.values, *result.phi.values]).all()
    scores = scored(result, validation) if complete else None
    return PlanarReading(result, identification, validation, scores)


Column = Float[np.ndarray, " n"]


class PaperFigure(NamedTuple):
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
) -> dict[str, PaperFigure]:
    """The figures by name, `fig06` to `fig13`.

    Args:
        robot: the robot that flew.
        identification: what was measured on Table 5's trajectory.
        burn: the recording of Section 5.5's burn.
        validation: what was measured on Eq. 47's trajectory.
        result: the result of the identification, which predicts the validation.
    """
    predicted = _predicted(result, validation)
    place = _position(identification.raw)
    thrust = {f"force {k} (N)": burn.column(f"force.{k}") for k in "xy"}
    return {
        "fig06": PaperFigure(
            "Measured joint angles and rates", _joints(robot, identification)
        ),
        "fig07": PaperFigure("Measured base angle and rate", _base(identification)),
        "fig08": PaperFigure(
            "Measured position and velocity of S",
            place | _velocity(identification.ready),
        ),
        "fig09": PaperFigure("Translation of S in the burn", _position(burn) | thrust),
        "fig10": PaperFigure(
            "Validation: joint angles and rates", _joints(robot, validation)
        ),
        "fig11": PaperFigure(
            "Validation: base angle, and rate with its prediction",
            _base(validation) | _named(predicted, "base rate z predicted (rad/s)"),
        ),
        "fig12": PaperFigure(
            "Validation: position of S with its prediction",
            _position(validation.raw)
            | _named(predicted, *(f"S {k} predicted (m)" for k in "xy")),
        ),
        "fig13": PaperFigure(
            "Validation: velocity of S with its prediction",
            _velocity(validation.ready)
            | _named(predicted, *(f"S velocity {k} predicted (m/s)" for k in "xy")),
        ),
    }


def write_figures(figures: Mapping[str, PaperFigure], folder: Path) -> None:
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


def _position(raw: Recording) -> dict[str, Column]:
    position = {f"S {k} (m)": raw.column(f"position.{k}") for k in "xy"}
    return {"t (s)": raw.t, **position}


def _velocity(ready: Recording) -> dict[str, Column]:
    rate = {f"S velocity {k} (m/s)": ready.column(f"velocity.{k}") for k in "xy"}
    return {"t (s)": ready.t, **rate}


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
