"""The least deviations along a motion, which torques at joints lower."""

from dataclasses import replace

import pytest
from clean_recordings import RATE, SENSORS
from random_motions import random_motion

import orbident as oi
from orbident.excitation.bound import bound_of
from orbident.robot.sensor_schema import declared_sensors


@pytest.mark.parametrize("torques", [{}, {"torques": {"std": "0.1 N m"}}])
def test_without_wheels_torques_give_the_scale(torques):
    """Momentum alone shows ratios of parameters; a torque shows how large all are."""
    robot = replace(
        oi.load_robot("paper-spatial"),
        wheels=(),
        sensors=declared_sensors({"rate": RATE, **SENSORS, **torques}),
    )
    motion = random_motion(robot, 1, 60.0, start="turning")
    found = bound_of(robot, motion).parameters.base
    assert found.determined.all() == bool(torques)
    assert found.determined.any() == bool(torques)
