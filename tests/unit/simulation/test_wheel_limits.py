"""What a motor gives of the torque that is asked for, as a flight shows it."""

from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_robot

from orbident.robot.description import Wheel
from orbident.simulation.flight import Hold, OpenLoop, WheelLimits, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying

TAPER = 0.02
"""Last part of the top speed, over which the torque falls to zero."""
LIMITS = WheelLimits(torque=np.array([0.1]), speed=np.array([100.0]))
NONE = WheelLimits(torque=np.array([np.inf]), speed=np.array([np.inf]))
WHEEL = Wheel("rw", np.array([0.0, 0.0, 1.0]), 0.05)
ROBOT = replace(random_robot(1, ()), wheels=(WHEEL,))
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def given(limits: WheelLimits, asked: float, speed: float) -> float:
    """The torque on the rotor at the start of a flight."""
    base = BaseState(np.zeros(3), LEVEL, np.zeros(3), np.array([speed]))
    run = free_flying(
        ROBOT,
        np.zeros(1),
        standing(base, np.zeros(0)),
        Hold(np.zeros(0)),
        OpenLoop(lambda t: np.zeros((t.size, 0))),
        OpenLoop(lambda t: np.full((t.size, 1), asked)),
        limits,
    )
    return float(run.tau_rw[0, 0])


@pytest.mark.parametrize(
    ("asked", "speed", "expected"),
    [
        (0.05, 0.0, 0.05),
        (0.5, 0.0, 0.1),
        (-0.5, 0.0, -0.1),
        (0.5, 99.9, 0.1 * 0.001 / TAPER),
        (0.5, 100.0, 0.0),
        (0.5, 120.0, 0.0),
        (-0.5, 120.0, -0.1),
        (-0.5, -99.9, -0.1 * 0.001 / TAPER),
        (-0.5, -120.0, 0.0),
        (0.5, -120.0, 0.1),
        (0.0, 120.0, 0.0),
    ],
)
def test_torque_that_the_motor_gives(asked, speed, expected):
    # 1 - 0.999 has lost three digits; it is shown as `I_rw (a.w_dot + qdd_rw)`, sums of
    # the order of 0.1 that cancel.
    assert given(LIMITS, asked, speed) == pytest.approx(expected, rel=1e-12, abs=1e-16)


@pytest.mark.parametrize("asked", [0.0, 3.0, -3.0])
def test_no_limits(asked):
    assert given(NONE, asked, 500.0) == pytest.approx(asked, rel=1e-14)
