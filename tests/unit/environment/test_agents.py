"""Every agent: flown along a short recording, and identified from it."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from random_motions import random_motion
from scipy.interpolate import CubicSpline
from small_problems import (
    NOISE,
    SPIN,
    at_rest,
    noisy,
    noisy_in_space,
    small_robot,
    small_robot_in_space,
)

from orbident.choices import DisturbanceGroup
from orbident.environment.agent import Agent, Disturbance, World
from orbident.environment.agents import AGENTS, WALKS
from orbident.environment.motion import Load, RobotMotion
from orbident.environment.torques_and_forces import slow_shapes
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.may_act import MayAct, may_act
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.simulate import simulate
from orbident.trajectories.environment import Environment

FAR = 5.0
"""Deviations: of some 150 numbers none is so far off by chance."""

SHORT = 10.0
"""s: a recording in space."""

SWING = 5.0
"""s: what changes slowly in it does so twice."""

TORQUE = np.array([3e-3, -2e-3, 4e-3])
PUSHING = np.array([0.03, 0.02, -0.05])
"""N."""

LOSS = 1e-3
"""N m, as are the torques."""

CENTRE = np.array([0.4, -0.3, 0.2])
"""m from S: where air and light act."""

LIGHT = 4.54e-6 * 1.3 * 400
"""N: pressure, coefficient and area."""

MAGNET = np.array([6.0, -8.0, 10.0])
"""A m^2."""

ORBIT = {
    "orbit": {"altitude": "400 km", "inclination": "0.9 rad"},
    "gravity_gradient": True,
}

DRAG = 0.5 * 3e-12 * 2.2 * 30 * 7371.5**2
"""N: the orbit's 7669 m/s, and the air turns with the Earth."""


def equipped(robot: Robot) -> Robot:
    """With sensors as noisy as the small problems' ones."""
    sensors = {
        "gyro": {"angle_random_walk": NOISE["gyro"] / np.sqrt(20)},
        "attitude": {"angle": NOISE["attitude"]},
        "position": {"std": NOISE["position"]},
    }
    return replace(robot, sensors=declared_sensors(sensors))


TABLE, SPACE = equipped(small_robot()), equipped(small_robot_in_space())
BASE, WHEEL = TABLE.bodies[0], SPACE.wheels[0]
TABLE = replace(TABLE, pads={BASE: np.array([0.05, -0.1, 0.0])})
AT_CENTRE = {"centre": [*(CENTRE + SPACE.feature_point)]}


class ByHand(Agent):
    """A torque that no file gives, by a formula of its own; inertial axes, N m."""

    group = "by hand"

    def __init__(self, moment: Callable[[RobotMotion], np.ndarray]) -> None:
        self.moment = moment

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        yield motion.load(moment=self.moment(motion))


class Case(NamedTuple):
    """What acts, and the numbers of its group that are not zero then."""

    robot: Robot
    given: dict[str, Any]
    true: dict[str, float]
    by_hand: Callable[[RobotMotion], np.ndarray] | None = None


def shape(motion: RobotMotion, group: str, m: int) -> np.ndarray:
    """One of those of which a fit makes what changes slowly; the first is 1."""
    t = np.linspace(0.0, SHORT, 201)
    allowed = {group: MayAct(np.inf, SWING)}
    shapes = slow_shapes(at_rest(motion.robot, t, allowed), group)
    return CubicSpline(t, shapes[:, m - 1])(motion.t)[:, None]


def lost(motion: RobotMotion) -> np.ndarray:
    """What a wheel loses, `a l` with `l = LOSS t`, the rest of the robot gains."""
    t = motion.t[:, None]
    in_base = WHEEL.axis + np.cross(motion.w, WHEEL.axis * t)
    return LOSS * np.einsum("nij,nj->ni", motion.R_WB, in_base)


def xyz(group: str, sizes: np.ndarray, more: str = "") -> dict[str, float]:
    axes = zip("xyz", sizes, strict=True)
    return {f"{group}.{axis}{more}": float(size) for axis, size in axes}


TESTED = [group for group, each in AGENTS.items() if each.words]
"""What is tested for, or may be asked for."""

CASES = {
    "torque": Case(TABLE, {"torque": [0, 0, 1e-3]}, {"torque.z": 1e-3}),
    "slow_torque": Case(
        SPACE,
        {},
        xyz("slow_torque", TORQUE, ".2"),
        lambda m: TORQUE * shape(m, "slow_torque", 2),
    ),
    "base_torque": Case(
        SPACE, {}, xyz("base_torque", TORQUE), lambda m: m.R_WB @ TORQUE
    ),
    "slow_base_torque": Case(
        SPACE,
        {},
        xyz("slow_base_torque", TORQUE, ".3"),
        lambda m: m.R_WB @ TORQUE * shape(m, "slow_base_torque", 3),
    ),
    "wheel_loss": Case(SPACE, {}, {f"wheel_loss.{WHEEL.name}.0": LOSS}, lost),
    "leak": Case(
        SPACE,
        {"bursts": [{"start": 0, "duration": SHORT, "force": [*PUSHING]}]},
        xyz("leak.force", PUSHING) | xyz("leak.moment", TORQUE),
        lambda m: m.R_WB @ TORQUE,
    ),
    "pull": Case(TABLE, {"tilt": [4e-5, 0]}, {"pull.x": 4e-5 * 9.80665}),
    "uneven": Case(
        # A bowl: any other table has a moment about the CM too, which no fit knows.
        replace(TABLE, pads={}),
        {"uneven": {"xx": -3e-3, "yy": -3e-3}},
        {"uneven.xx": -3e-3, "uneven.yy": -3e-3},
    ),
    "drag": Case(
        TABLE,
        {"film_drag": {BASE: {"c": 0.02, "c_r": 0.002}}},
        {f"drag.{BASE}": 0.02, f"drag.{BASE}.turning": 0.002},
    ),
    "hose": Case(TABLE, {"hose": 0.03}, {"hose.stiffness": 0.03}),
    "air": Case(
        SPACE,
        {**ORBIT, "air_drag": {"density": 3e-12, "area": 30, **AT_CENTRE}},
        {"air.force": DRAG, **xyz("air", DRAG * CENTRE)},
    ),
    "sunlight": Case(
        SPACE,
        {"solar_pressure": {"sun": [1, 2, -2], "area": 400, **AT_CENTRE}},
        {"sunlight.force": LIGHT, **xyz("sunlight", LIGHT * CENTRE)},
    ),
    "dipole": Case(SPACE, {**ORBIT, "dipole": [*MAGNET]}, xyz("dipole", MAGNET)),
}


def flown(robot: Robot, given: dict[str, Any]) -> Recording:
    """From rest, by sensors that are noisy."""
    planar = robot.motion == "planar"
    duration, spin = (20.0, SPIN) if planar else (SHORT, 50.0)
    trajectory = replace(
        random_motion(robot, 1, duration, spin, "spun up"),
        environment=Environment.model_validate(given),
    )
    return (noisy if planar else noisy_in_space)(simulate(robot, trajectory), 0)


def identified(robot: Robot, recording: Recording) -> Result:
    """A result whose base parameters are right."""
    result = identify(robot, recording, "maximum-likelihood", "at-rest")
    assert result.status == "ok", result.warnings
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    assert np.nanmax(np.abs(off / result.base.std)) < FAR
    return result


@pytest.mark.parametrize("group", CASES)
def test_what_acts_is_identified(group: str, monkeypatch: pytest.MonkeyPatch):
    robot, given, true, by_hand = CASES[group]
    with monkeypatch.context() as acting:
        if by_hand:
            acting.setitem(AGENTS, ByHand.group, ByHand(by_hand))
        recording = flown(robot, given)
    # The place where an uneven table is level is not known.
    asked = ("pull", group) if group == "uneven" else (group,)
    acts = may_act({name: {"size": "free", "shortest": SWING} for name in asked})
    result = identified(replace(robot, disturbances=acts), recording)
    fits = {n: fit for n, fit in result.disturbances.items() if fit.group == group}
    assert {*true} <= {*fits}
    assert any(abs(size) > FAR * fits[name].std for name, size in true.items())
    for name, fit in fits.items():
        assert abs(fit.value - true.get(name, 0.0)) < FAR * fit.std


def test_no_agent_is_left_out():
    """Walks and springs have tests of their own."""
    assert {*CASES, *WALKS, "on_springs"} == {*TESTED}


class Swirl(Agent):
    """Air that swirls about the place where S was at first."""

    group = "swirl"
    words = "air swirls over the table"
    needs = "position or velocity of S"
    unit = "N/m"
    size = 0.03

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        yield self.carried(motion, self.size)

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        if motion.S:
            yield self.column("size", motion.effect(self.carried(motion, 1.0)))

    def carried(self, motion: RobotMotion, size: float) -> Load:
        assert motion.S is not None
        return motion.load(force=size * np.cross([0.0, 0.0, 1.0], motion.S.r))


def test_a_new_agent_is_one_class(monkeypatch: pytest.MonkeyPatch):
    """It is simulated, found by the test of what acts, and named in words."""
    monkeypatch.setitem(AGENTS, Swirl.group, Swirl())
    robot = replace(TABLE, pads={})
    result = identified(robot, flown(robot, {}))
    assert set(result.disturbances) == {"swirl.size"}
    fit = result.disturbances["swirl.size"]
    assert abs(fit.value - Swirl.size) < FAR * fit.std < 0.3 * Swirl.size
    assert any(Swirl.words in words for words in result.warnings)


def test_the_command_line_and_the_robot_file_have_the_agents_names():
    assert [*DisturbanceGroup] == TESTED
    assert {group for group, each in AGENTS.items() if each.needs} <= {*TESTED}
