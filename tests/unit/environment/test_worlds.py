"""What may act on a robot where its file says nothing, and where it does."""

import math
from dataclasses import replace

import numpy as np
import pytest
from small_problems import small_robot, small_robot_in_space

from orbident.environment.worlds import (
    DRAG_COEFFICIENT,
    FROM,
    LOST,
    PART,
    SHORTEST,
    SLOPE,
    STOPS_IN,
    UNEVEN,
    Scale,
    radius_of_gyration,
    scale_of,
    what_may_act,
    world_of,
)
from orbident.model.kinematics import inertia_at
from orbident.orbits.earth import MU, R_E
from orbident.orbits.orbit import Elements, Orbit
from orbident.robot.description import MomentumWalk, Robot
from orbident.robot.may_act import MayAct, may_act
from orbident.robot.sensor_schema import declared_sensors

TABLE, SPACE = (
    replace(robot, sensors=declared_sensors({"wheels": {"position": 1e-4}}))
    for robot in (small_robot(), small_robot_in_space())
)
LOW = replace(SPACE, orbit=Orbit(Elements(R_E + 400e3, 0.9)))
"""Where the density of the air is in the table."""

SCALE = Scale(0.0, 80.0, 12.0, 0.2)


def sizes(robot: Robot, scale: Scale = SCALE) -> dict[str, float]:
    return {name: each.size for name, each in what_may_act(robot, scale).items()}


def heavier(robot: Robot, times: float) -> Robot:
    return replace(robot, theta=times * robot.theta)


def test_the_world_is_what_the_file_says():
    assert [world_of(each) for each in (TABLE, LOW, SPACE)] == [
        "table",
        "orbit",
        "space",
    ]


def test_the_radius_of_gyration():
    """About S, of a base and arm whose joints are at zero."""
    D = inertia_at(SPACE, np.zeros(len(SPACE.joints))).D
    expected = math.sqrt(np.trace(D) / 2 / SPACE.mass)
    assert radius_of_gyration(SPACE) == pytest.approx(expected)
    assert radius_of_gyration(heavier(SPACE, 3.0)) == pytest.approx(expected)


def test_a_table():
    """Its torque is what the slope does at arms' length."""
    M, L = TABLE.mass, radius_of_gyration(TABLE)
    assert sizes(TABLE) == pytest.approx(
        {
            "slow_torque": M * SLOPE * L,
            "pull": SLOPE,
            "uneven": UNEVEN,
            "drag": M / STOPS_IN,
        }
    )
    twice = sizes(heavier(TABLE, 2.0))
    assert twice["slow_torque"] == pytest.approx(2 * M * SLOPE * L)
    assert twice["pull"] == SLOPE


def test_a_film_of_which_nothing_is_known_may_be_anything():
    padded = replace(TABLE, pads={TABLE.bodies[0]: np.zeros(3)})
    assert sizes(padded)["drag"] == TABLE.mass / STOPS_IN
    assert sizes(replace(padded, disturbances={})) == {"drag": np.inf}
    said = replace(padded, disturbances=may_act({"drag": 0.01}))
    assert sizes(said) == {"drag": 0.01}


def test_an_orbit():
    """The gravity gradient and the drag of the air; the tide from where it is seen."""
    R, M, L = R_E + 400e3, LOW.mass, radius_of_gyration(LOW)
    found = sizes(LOW)
    assert {*found} == {"slow_torque", "pull"}
    assert found["pull"] == pytest.approx(3 * MU / R**3 * FROM)
    flow = 3.7e-12 * DRAG_COEFFICIENT * MU / R / 2
    torque = 1.5 * MU / R**3 * 2 * M * L**2 + flow * (2 * L) ** 2 * L
    assert found["slow_torque"] == pytest.approx(torque)


def test_space():
    """What moves the momenta by one per cent in the recording."""
    found = sizes(SPACE)
    assert found["slow_torque"] * SCALE.duration == pytest.approx(PART * SCALE.h)
    assert found["pull"] * SCALE.duration == pytest.approx(PART * SCALE.v)
    unseen = sizes(SPACE, SCALE._replace(v=np.nan))
    assert unseen == {"slow_torque": found["slow_torque"]}


def test_wheels_that_nobody_measures_may_lose_speed():
    commanded = sizes(replace(SPACE, sensors=declared_sensors({})))
    assert commanded["wheel_loss"] == pytest.approx(LOST * commanded["slow_torque"])
    # About the vertical of a table a loss and a torque are the same.
    assert "wheel_loss" not in sizes(replace(TABLE, sensors=declared_sensors({})))


@pytest.mark.parametrize("robot", [TABLE, SPACE])
def test_the_file_stands_for_the_world(robot):
    assert what_may_act(replace(robot, disturbances={}), SCALE) == {}
    said = may_act({"slow_torque": {"size": 1e-3, "shortest": 3.0}, "pull": "free"})
    shortest = SHORTEST[world_of(robot)]
    assert what_may_act(replace(robot, disturbances=said), SCALE) == {
        "slow_torque": MayAct(1e-3, 3.0),
        "pull": MayAct(np.inf, shortest),
    }


def test_a_walk_that_is_declared_stands_for_a_slow_torque():
    walking = replace(SPACE, momentum_walk=MomentumWalk(torque=2e-3))
    assert {*sizes(walking)} == {"pull", "torque_walk"}
    assert sizes(walking)["torque_walk"] == 2e-3
    pushed = replace(SPACE, momentum_walk=MomentumWalk(force=1e-3))
    assert {*sizes(pushed)} == {"slow_torque", "pull", "force_walk"}


def test_the_scale_of_a_motion():
    """Its wheels hold some momentum, and its base turns; both are root mean squares."""
    (wheel, *others), t = SPACE.wheels, np.linspace(3.0, 13.0, 101)
    speeds = np.zeros((t.size, 1 + len(others)))
    speeds[:, 0] = 50.0 * np.sqrt(2) * np.sin(2 * np.pi * np.arange(t.size) / 101)
    w, v = np.tile([0.0, 0.03, 0.04], (7, 1)), np.tile([0.1, 0.0, 0.0], (5, 1))
    scale = scale_of(SPACE, t, speeds, w, v)
    base = SPACE.mass * radius_of_gyration(SPACE) ** 2 * 0.05
    assert scale == pytest.approx(
        (3.0, 10.0, math.hypot(50.0 * wheel.inertia, base), 0.1)
    )
    assert math.isnan(scale_of(SPACE, t, speeds, w, None).v)
