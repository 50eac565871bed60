"""Section 5 for one seed: the planar two-joint robot flies, and is read in two ways.

It flies spin-up, exciting trajectory, burn and validation. Recordings are what the
sensors saw, and how the thrusters fired.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.estimation.weigh import Weighing, weigh
from orbident.identified.validate import SCORED, Validation, scored
from orbident.model.kinematics import JointState
from orbident.recordings.columns import vector_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.flight import (
    AttitudeHold,
    FlyingState,
    FreeFlying,
    Hold,
    JointPD,
    WheelLimits,
    WheelSpeed,
    standing,
)
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import measure_truth, truth_of_flight
from orbident.simulation.outside import Pulse
from orbident.studies import paper_tables
from orbident.studies.paper_method import (
    Filters,
    PaperParameters,
    from_mocap,
    mass_by_slopes,
    paper_method,
)
from orbident.trajectories.trajectory import Trajectory

# The paper gives neither gains nor motors: what such a robot would have. The arm
# follows Table 5 to 0.03 rad, and locked it gives way by 0.002 rad.
FOLLOWING = JointPD(Kp=np.array([1.0, 0.4]), Kd=np.array([0.2, 0.04]))
LOCKED = JointPD(Kp=np.array([5.0, 5.0]), Kd=np.array([0.2, 0.2]))
WHEEL = WheelSpeed(
    k=np.array([0.05]), speed=np.array([float(paper_tables.PLANAR_WHEEL_SPEED)])
)
MOTOR = WheelLimits(torque=np.array([0.05]), speed=np.array([np.inf]))

FOLDED = np.array([2.5, -2.09])
"""Joints at those of Eq. 46's limits that fold the arm over the base, rad."""

THRUSTERS = ("t2", "t3", "t6")
"""The thrusters that push down the table, with no moment about S together."""


class Sines(NamedTuple):
    """Joints that always swing: `q = amplitude sin(2 pi t / period)` (Eq. 47)."""

    amplitudes: Float[np.ndarray, " joints"]
    """rad."""
    period: float
    """s."""

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at these times."""
        rate = 2 * np.pi / self.period
        sines = np.sin(rate * t)[:, None] * self.amplitudes
        cosines = np.cos(rate * t)[:, None] * self.amplitudes
        return sines, rate * cosines, -(rate**2) * sines


SWING = Sines(
    np.array(paper_tables.VALIDATION_AMPLITUDES), paper_tables.VALIDATION_DURATION
)
"""Eq. 47: how the joints swing in the validation."""


def burn_pulses(robot: Robot) -> tuple[Pulse, ...]:
    """Section 5.5's force from three thrusters, without a moment about S.

    About the CM a moment is left, which the wheel has to take.
    """
    by_name = {thruster.name: thruster for thruster in robot.thrusters}
    wrenches = []
    for name in THRUSTERS:
        arm = by_name[name].position - robot.feature_point
        unit = by_name[name].direction
        wrenches.append([*unit[:2], np.cross(arm, unit)[2]])
    forces = np.linalg.solve(np.transpose(wrenches), [*paper_tables.BURN_FORCE, 0.0])
    on, off = paper_tables.BURN_START, paper_tables.BURN_START + paper_tables.BURN_LASTS
    return tuple(
        Pulse(name, on, off, float(force))
        for name, force in zip(THRUSTERS, forces, strict=True)
    )


def ideal_record(robot: Robot, flight: FreeFlying) -> Recording:
    """As ideal sensors of everything would have recorded it."""
    columns = truth_of_flight(flight).columns(robot) | _thrust(flight)
    return Recording(flight.t, columns, source=f"flight of {robot.name}")


def measured_record(robot: Robot, flight: FreeFlying, seed: int) -> Recording:
    """As the sensors of the robot's file recorded it.

    The rows are at the flight's times, evenly spaced.

    Raises:
        InputError: a sensor cannot sample at these times.
    """
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), seed)
    columns = {**seen.columns, **_thrust(flight)}
    return Recording(flight.t, columns, source=f"flight of {robot.name}, seed {seed}")


def _thrust(flight: FreeFlying) -> dict[str, Float[np.ndarray, " n"]]:
    """What the valves were told: it is known, not measured."""
    names = *vector_columns("force"), *vector_columns("torque")
    return dict(zip(names, np.hstack([flight.force, flight.torque]).T, strict=True))


SPIN_UP = 10.0
"""s: 0.335 N m s at 0.05 N m, and as much again for the wheel to settle."""

LEAD_IN = 1.0
"""s that the joints swing before the record of the validation begins: Eq. 47 starts
with a rate that joints at rest do not have."""

BURN_RECORD = 5.0
"""s."""

TOLERANCE = 1e-6
"""rad or m: a hundredth of what the sensors see. Momentum is kept to rounding."""


_following = partial(
    free_flying, joints=FOLLOWING, wheels=WHEEL, limits=MOTOR, tolerance=TOLERANCE
)
"""Fly from a state while the joints follow a command."""


class Flights(NamedTuple):
    """What is recorded; each begins at zero of its own clock."""

    identification: FreeFlying
    burn: FreeFlying
    validation: FreeFlying


def fly_planar(robot: Robot, trajectory: Trajectory) -> Flights:
    """All flights of Section 5."""
    leading = _times(-LEAD_IN, 0.0)
    q_d, _, _ = SWING.at(leading[:1])
    ready = _spun_up(robot, np.zeros(len(robot.joints)), yaw=0.0)
    again = _spun_up(robot, q_d[0], yaw=1.0)
    led_in = _following(robot, leading, again, SWING).state(-1)
    return Flights(
        identification=_following(
            robot, _times(0.0, trajectory.duration), ready, trajectory
        ),
        burn=_burn(robot),
        validation=_following(robot, _times(0.0, SWING.period), led_in, SWING),
    )


def _spun_up(robot: Robot, q: Float[np.ndarray, " joints"], yaw: float) -> FlyingState:
    """State after the wheel's spin-up from rest (Eq. 25): momentum is still zero."""
    start = standing(_at_rest(yaw), q)
    return _following(robot, _times(0.0, SPIN_UP), start, Hold(q)).state(-1)


def _burn(robot: Robot) -> FreeFlying:
    base = _at_rest(yaw=0.0, drift=paper_tables.BURN_DRIFT)
    hold = AttitudeHold(paper_tables.HOLD_KP, paper_tables.HOLD_KD, base.attitude)
    return free_flying(
        robot,
        _times(0.0, BURN_RECORD),
        standing(base, FOLDED),
        Hold(FOLDED),
        LOCKED,
        wheels=hold,
        limits=MOTOR,
        pulses=burn_pulses(robot),
        tolerance=TOLERANCE,
    )


def _at_rest(yaw: float, drift: float = 0.0) -> BaseState:
    attitude = np.array([0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
    return BaseState(np.zeros(3), attitude, np.array([0.0, drift, 0.0]), np.zeros(1))


def _times(start: float, end: float) -> Float[np.ndarray, " n"]:
    first, last = (round(edge * paper_tables.PLANAR_RATE) for edge in (start, end))
    return np.arange(first, last + 1) / paper_tables.PLANAR_RATE


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

    The method is one of `identify`, which takes the recordings unfiltered.
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
