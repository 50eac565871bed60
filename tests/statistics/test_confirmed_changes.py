"""A whole recording by recursion: captures are found, and nothing else is.

`ORBIDENT_RUNS=20 pytest -m long tests/statistics/test_confirmed_changes.py` makes 40
flights with a change and 40 without, of two robots.
"""

import os
from dataclasses import replace

import numpy as np
import pytest
from captured_bodies import CapturedBody, holding, simulate_change
from clean_recordings import RATE
from clean_recordings import SENSORS as IN_SPACE
from random_motions import random_motion

import orbident as oi
from orbident.estimation.estimate import Change
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.solve import since_the_last_change
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "2"))
DURATION = 80.0
SOON = 5.0
"""s after the change within which it must be found."""
FAR = 5.0
"""Deviations: of a normal error beyond them there is one in two million."""


def flight(name: str, seed: int, mass: float) -> tuple[oi.Robot, oi.Recording, float]:
    """The robot after a change, its flight, and when that was; of CAD 10 % off."""
    random = np.random.default_rng(seed)
    sensors = declared_sensors({"rate": RATE, **IN_SPACE})
    # What is captured need not keep to what is known of a link (`structure`).
    before = replace(oi.load_robot(name), sensors=sensors, structure={})
    part = mass * before.mass * random.uniform(0.02, 0.2)
    held = CapturedBody(part, random.normal(0, 0.2, 3), 0.05 * part * np.eye(3))
    after = holding(before, held)
    motion = random_motion(
        before, seed=seed, duration=DURATION, wheel_speed=100.0, start="turning"
    )
    at = round(random.uniform(25.0, 55.0), 1)
    recording = simulate_change(before, after, motion, at + 0.05, seed, RATE)
    return after, recording, at


def cad(robot: oi.Robot, seed: int) -> oi.Robot:
    off = 1 + 0.1 * np.random.default_rng(seed).uniform(-1, 1, (len(robot.bodies), 1))
    return replace(robot, theta=off * robot.theta)


def off(result: oi.Result, true: oi.Robot) -> float:
    """The worst base parameter's error, in deviations."""
    beta = oi.minimal_sets(true).beta(true.theta)
    return float(np.nanmax(np.abs(result.base.values - beta) / result.base.std))


def test_an_alarm_too_soon_hides_no_change():
    """A filter that learns raises one shortly before, and none when it happens."""
    after, recording, at = flight("paper-spatial", 0, 1.0)
    user = replace(cad(oi.load_robot("paper-spatial"), 0), sensors=after.sensors)
    problem = momentum_problem(
        replace(user, structure={}), recording, "unknown", lambda _: None
    )
    alarm = Change(at - 1.5, at - 1.5, 2.0, 1.0)
    (change,), last = since_the_last_change(problem, [alarm], lambda _: None)
    assert change.onset <= at <= change.t + 1 / RATE
    assert change.t < at + SOON
    assert last.shown is not None
    base = last.shown.parameters.base
    z = (base.values - oi.minimal_sets(after).beta(after.theta)) / np.sqrt(
        np.diag(base.covariance)
    )
    assert np.abs(z).max() < FAR


@pytest.mark.long
@pytest.mark.parametrize("name", ["paper-spatial", "dual-arm"])
def test_a_change_is_found_and_the_robot_after_it(name: str):
    found, wrong, refused = 0, [], 0
    for seed in range(RUNS):
        after, recording, at = flight(name, seed, 1.0)
        user = cad(oi.load_robot(name), seed)
        user = replace(user, sensors=after.sensors, structure={})
        result = oi.identify(user, recording, method="recursive")
        changes = [c.reason for c in result.checks if c.name == "changes"]
        times = [float(c.split("found at ")[1].split()[0]) for c in changes]
        found += any(-1 / RATE <= t - at < SOON for t in times) and len(times) == 1
        refused += result.status == "rejected"
        if result.status == "ok" and off(result, after) > FAR:
            wrong.append((seed, off(result, after)))
        print(name, seed, at, times, result.refusal() or off(result, after))
    print(f"{name}: {found} of {RUNS} found, {refused} refused, wrong {wrong}")
    assert wrong == []
    assert found >= 0.95 * RUNS - 1


@pytest.mark.long
@pytest.mark.parametrize("name", ["paper-spatial", "dual-arm"])
def test_nothing_is_found_where_nothing_changes(name: str):
    alarms, wrong, refused = 0, [], 0
    for seed in range(RUNS):
        robot, recording, _ = flight(name, 1000 + seed, 0.0)
        user = replace(cad(robot, seed), sensors=robot.sensors)
        result = oi.identify(user, recording, method="recursive")
        alarms += any(c.name == "changes" for c in result.checks)
        refused += result.status == "rejected"
        if result.status == "ok" and off(result, robot) > FAR:
            wrong.append((seed, off(result, robot)))
        print(name, seed, result.refusal() or off(result, robot))
    print(f"{name}: {alarms} alarms in {RUNS}, {refused} refused, wrong {wrong}")
    assert wrong == []
    assert alarms <= RUNS // 40
