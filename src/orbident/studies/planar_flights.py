"""Section 5, flown: spin-up, exciting trajectory, burn and validation."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot
from orbident.simulation.control_laws import Hold, attitude_hold
from orbident.simulation.flight import FlyingState, FreeFlying, standing
from orbident.simulation.free_floating import BaseState, JointMotion
from orbident.simulation.free_flying import free_flying
from orbident.studies import paper_tables
from orbident.studies.planar import (
    FOLDED,
    FOLLOWING,
    LOCKED,
    MOTOR,
    WHEEL,
    burn_pulses,
    validation_command,
)
from orbident.trajectories.trajectory import Trajectory

SPIN_UP = 10.0
"""s: 0.335 N m s at 0.05 N m, and as much again for the wheel to settle."""

LEAD_IN = 1.0
"""s that the joints swing before the record of the validation begins: Eq. 47 starts
with a rate that joints at rest do not have."""

BURN_RECORD = 5.0
"""s."""

TOLERANCE = 1e-6
"""rad or m: a hundredth of what the sensors see. Momentum is kept to rounding."""


class Flights(NamedTuple):
    """What is recorded; each begins at zero of its own clock."""

    identification: FreeFlying
    burn: FreeFlying
    validation: FreeFlying


def fly_planar(robot: Robot, trajectory: Trajectory) -> Flights:
    """All flights of Section 5.

    Args:
        robot: `planar_robot`.
        trajectory: `planar_trajectory`.
    """
    swing = validation_command()
    leading = _times(-LEAD_IN, 0.0)
    q_d, _, _ = swing.at(leading[:1])
    ready = _spun_up(robot, np.zeros(len(robot.joints)), yaw=0.0)
    again = _spun_up(robot, q_d[0], yaw=1.0)
    led_in = _following(robot, leading, again, swing).state(-1)
    return Flights(
        identification=_following(
            robot, _times(0.0, trajectory.duration), ready, trajectory
        ),
        burn=_burn(robot),
        validation=_following(robot, _times(0.0, swing.period), led_in, swing),
    )


def _spun_up(robot: Robot, q: Float[np.ndarray, " joints"], yaw: float) -> FlyingState:
    """State after the wheel's spin-up from rest (Eq. 25): momentum is still zero."""
    start = standing(_at_rest(yaw), q)
    flight = free_flying(
        robot,
        _times(0.0, SPIN_UP),
        start,
        Hold(q),
        FOLLOWING,
        wheels=WHEEL,
        limits=MOTOR,
        tolerance=TOLERANCE,
    )
    return flight.state(-1)


def _following(
    robot: Robot,
    t: Float[np.ndarray, " n"],
    start: FlyingState,
    command: JointMotion,
) -> FreeFlying:
    return free_flying(
        robot,
        t,
        start,
        command,
        FOLLOWING,
        wheels=WHEEL,
        limits=MOTOR,
        tolerance=TOLERANCE,
    )


def _burn(robot: Robot) -> FreeFlying:
    base = _at_rest(yaw=0.0, drift=paper_tables.BURN_DRIFT)
    hold = attitude_hold(
        robot, paper_tables.HOLD_KP, paper_tables.HOLD_KD, base.attitude
    )
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
