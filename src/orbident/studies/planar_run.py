"""Section 5 for one seed: three recordings, two ways to read them, one burn."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.estimation.weigh import Weighing, weigh
from orbident.identified.validate import Validation, scored
from orbident.model.minimal_sets import minimal_sets
from orbident.model.paper_bases import PaperBasis, paper_basis, planar_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies import paper_tables
from orbident.studies.filters import Filters
from orbident.studies.flight_record import ideal_record, measured_record
from orbident.studies.mocap_method import from_mocap
from orbident.studies.paper_method import paper_method
from orbident.studies.planar_flights import Flights
from orbident.studies.slopes import mass_by_slopes

SCORED = ("gyro", "velocity")


class Records(NamedTuple):
    """What was recorded of each flight."""

    identification: Recording
    burn: Recording
    validation: Recording


class Table6(NamedTuple):
    """Table 6's parameters and M: how to get them from a result, and what they are."""

    basis: PaperBasis
    true: Float[np.ndarray, " parameters"]

    @classmethod
    def of(cls, robot: Robot) -> "Table6":
        """The table in the paper's planar basis, of the robot's nominal inertia."""
        sets = minimal_sets(robot)
        basis = paper_basis(sets, planar_columns(paper_tables.PLANAR_JOINT1))
        pi, phi = basis.pi(sets.pi(robot.theta)), basis.phi(sets.phi(robot.theta))
        return cls(basis, np.concatenate([pi, phi, [robot.mass]]))

    def found(self, result: Result) -> Float[np.ndarray, " parameters"]:
        """The result's; M is that of Eq. 32."""
        pi, phi = self.basis.pi(result.pi.values), self.basis.phi(result.phi.values)
        return np.concatenate([pi, phi, [result.mass.value]])

    def errors(
        self, found: Float[np.ndarray, " parameters"]
    ) -> Float[np.ndarray, " parameters"]:
        """Percent, signed."""
        return 100 * (found / self.true - 1)


class PlanarReading(NamedTuple):
    """What one way of signal processing comes to."""

    result: Result
    identification: Recording
    """As identification was given it."""
    validation: Recording
    """As prediction was given it."""
    scores: Validation | None
    """None where the result cannot predict."""

    def quantities(self, table: Table6) -> Float[np.ndarray, " quantities"]:
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

    def quantities(self, table: Table6) -> Float[np.ndarray, " quantities"]:
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
