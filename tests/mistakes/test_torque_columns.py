"""Torque columns written otherwise are named before any fit, and good ones are not."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from random_flights import Known, flight, recorded
from recordings import designed

from orbident.diagnosis.torque_columns import plain_torques
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.robot.sensor_schema import declared_sensors

ROBOTS = "space 4", "table 5", "free-flyer 1"


def flown(name: str, seed: int = 1, rotor: float = 0.0) -> tuple[Known, np.ndarray]:
    """A flight of a robot known within 10 %, and what its torque sensors show.

    Args:
        name: of the flight.
        seed: of the noise.
        rotor: the most that a motor takes beside what a joint carries.
    """
    clean, random = flight(name), np.random.default_rng(seed)
    assert clean.true.tau is not None
    tau, qd = clean.true.tau, clean.true.qd
    size, qdd = tau.std(axis=0), np.gradient(qd, clean.t, axis=0)
    rubbed = random.uniform(0, 0.5, (2, *size.shape)) * size
    shown = tau + rubbed[0] * np.sign(qd) + rubbed[1]
    shown += rotor * random.uniform(size=size.size) * qdd * size / qdd.std(axis=0)
    shown += 0.05 * size * random.standard_normal(tau.shape)
    known = recorded(clean, seed)
    return known._replace(robot=designed(clean.robot)), shown


def said(known: Known, shown: np.ndarray) -> str:
    joints = known.robot.joint_names
    columns = {
        f"joint.{name}.torque": x for name, x in zip(joints, shown.T, strict=True)
    }
    momentum = "at-rest" if known.robot.motion == "planar" else "unknown"
    recording = known.recording.with_columns(columns)
    problem = momentum_problem(known.robot, recording, momentum, lambda _: None)
    return "".join(check.reason for check in plain_torques(problem))


@pytest.mark.parametrize("rotor", [0.0, 10.0])
@pytest.mark.parametrize("name", ROBOTS)
def test_what_is_written_right(name: str, rotor: float):
    assert said(*flown(name, rotor=rotor)) == ""


@pytest.mark.parametrize("name", ROBOTS)
def test_a_sign(name: str):
    known, shown = flown(name)
    first = known.robot.joint_names[0]
    right = f"the sign of the torque of {first}, or of the joint, is the opposite: "
    assert said(known, shown * [-1.0, *np.ones(shown.shape[1] - 1)]).startswith(right)


@pytest.mark.parametrize("name", ROBOTS)
def test_another_order(name: str):
    known, shown = flown(name)
    one, other = known.robot.joint_names[:2]
    order: Sequence[int] = [1, 0, *range(2, shown.shape[1])]
    words = (
        f"another order, or the joints are ({one} shows {other}, {other} shows {one})"
    )
    assert words in said(known, shown[:, order])


@pytest.mark.parametrize(
    ("times", "words"), [(1e3, "is in mN m"), (0.01, "the motor's side of a gear")]
)
def test_another_unit(times: float, words: str):
    known, shown = flown(ROBOTS[0])
    of = ", ".join(known.robot.joint_names)
    assert said(known, times * shown).startswith(f"the torque of {of} is ")
    assert words in said(known, times * shown)


def test_where_torques_say_too_little():
    """Half of them is noise, and CAD values are far off."""
    known, shown = flown(ROBOTS[0])
    random = np.random.default_rng(5)
    noisy = shown + shown.std(axis=0) * random.standard_normal(shown.shape)
    off = 1 + 0.5 * random.uniform(-1, 1, (len(known.robot.bodies), 1))
    robot = replace(known.robot, theta=off * known.robot.theta)
    assert said(known._replace(robot=robot), -noisy) == ""


@pytest.mark.slow
@pytest.mark.parametrize("times", [pytest.param(0.5, marks=pytest.mark.long), 1.41])
def test_a_scale_beyond_its_tolerance(times: float):
    """As an amplifier's root mean square is of its peak; no unit is so far off."""
    known, shown = flown("space 4")
    names, random = known.robot.joint_names, np.random.default_rng(3)
    size = shown.std(axis=0)
    shown = times * shown + 0.02 * size * random.standard_normal(shown.shape)
    said = known.robot.sensors.model_dump(by_alias=True, exclude_none=True)
    sensors = declared_sensors(said | {"torques": {"std": float(0.06 * size.max())}})
    free = dict.fromkeys(names, np.inf)
    tolerances = replace(
        known.robot.tolerances,
        joint_torque_scale=dict.fromkeys(names, 0.01),
        joint_viscous=free,
        joint_coulomb=free,
        joint_torque_offset=free,
    )
    robot = replace(known.robot, sensors=sensors, tolerances=tolerances)
    columns = {
        f"joint.{name}.torque": x for name, x in zip(names, shown.T, strict=True)
    }
    recording = known.recording.with_columns(columns)
    result = identify(robot, recording).with_causes("all")
    off = re.search(
        r"the scale or the sign of the torque of joint \S+ is off by (\S+)",
        result.refusal(),
    )
    assert off, result.refusal()
    assert float(off[1]) == pytest.approx(times - 1, abs=0.03)
