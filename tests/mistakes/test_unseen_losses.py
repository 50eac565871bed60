"""Wheels that lose speed unseen are no torque, though it looks nearly the same."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from random_flights import flight
from recordings import ROBOTS, SPACE, TABLE, Clean, clean
from wrong_motions import spun_down

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.may_act import may_act

slow = partial(pytest.param, marks=pytest.mark.slow)
BEYOND = 5.0
"""Deviations that no accepted parameter is off by."""


def flown(name: str) -> Clean:
    """The motion without a loss, of a bundled robot or of a random one."""
    return clean(name) if name in ROBOTS else flight(name)


def identified(name: str, part: float, *said: str, measured: bool = True) -> Result:
    """The result where the wheels of this robot lost a part of their speed.

    Without anything said the robot's world says what may act.

    Args:
        name: of the robot.
        part: of the speed.
        said: what acts.
        measured: whether the robot file says that speeds of wheels are measured.
    """
    spoiled = spun_down(part)(flown(name))
    sensors = spoiled.robot.sensors
    if not measured:
        sensors = sensors.model_copy(update={"wheels": None})
    return identify(
        replace(spoiled.robot, sensors=sensors, disturbances=may_act(said or None)),
        spoiled.recording,
        initial_momentum=spoiled.initial_momentum,
    )


def farthest(name: str, result: Result) -> float:
    """The largest error of a base parameter in its deviations."""
    robot = flown(name).robot
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    return float(np.abs(off / result.base.std).max())


@pytest.mark.parametrize(
    ("name", "part"),
    [
        slow(SPACE, 0.0005),
        slow(SPACE, 0.003),
        slow(SPACE, 0.007),
        ("space 4", 0.001),
        slow("space 6", 0.003),
        slow("space 6", 0.006),
    ],
)
def test_in_space_losses_are_found_or_in_the_deviations(name: str, part: float):
    """Those that are small look like the slow torque that may act in space."""
    result = identified(name, part)
    assert result.status == "ok"
    assert farthest(name, result) < BEYOND
    if part >= 0.003:
        assert {fit.group for fit in result.disturbances.values()} == {"wheel_loss"}
        assert any("wheels lose momentum" in words for words in result.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.0005, 0.001])
@pytest.mark.parametrize("name", [SPACE, "space 6"])
def test_losses_too_faint_to_be_found_are_held_where_wheels_are_not_measured(
    name: str, part: float
):
    """Who says that speeds are measured has no such losses."""
    result = identified(name, part, measured=False)
    assert result.status == "ok"
    assert farthest(name, result) < BEYOND
    assert "wheel_loss" in result.allowed


@pytest.mark.parametrize("part", [0.0005, slow(0.0006), slow(0.001)])
def test_on_a_table_nothing_accepted_is_wrong(part: float):
    """A clock and a slow torque, both wrong, would explain a loss of 0.05 %."""
    result = identified(TABLE, part)
    assert result.status == "rejected" or farthest(TABLE, result) < BEYOND


@pytest.mark.slow
def test_what_is_said_to_act_leaves_deviations_narrow():
    unsaid, said = (identified(SPACE, 0.0005, *acts) for acts in ((), ("wheel_loss",)))
    assert said.status == "ok"
    assert farthest(SPACE, said) < BEYOND
    assert said.base.std[0] < unsaid.base.std[0] / 2
