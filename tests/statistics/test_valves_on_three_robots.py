"""Valves that are late, short, on one tank, and one of them dead: three robots.

How valves work is written here, for the two robots with joints that the simulator
flies, which other engines fly alike (`tests/oracles`); the third is flown by plain sums
(`valved_satellite`). What a robot file says within a deviation is drawn with that
deviation for each seed: thrust, and the mass that scales show. Of as many seeds as
ORBIDENT_VALVES says (20 by default):

    ORBIDENT_VALVES=20 pytest -m long -s tests/statistics/test_valves_on_three_robots.py
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import valved_satellite
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import KnownQuantities, Robot, Thruster
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import Tolerances
from orbident.robot.units import MeasuredQuantity
from orbident.simulation.flight import Driven, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import measure_truth, truth_of_flight
from orbident.simulation.outside import Pulse
from orbident.trajectories.environment import Environment

SEEDS = int(os.environ.get("ORBIDENT_VALVES", "20"))

CLOCK, PULSE, COUPLING = 0.15, -0.02, 0.08
"""s, s, and what each loses for every further one."""

SHARED = {"clock": CLOCK, "pulse": PULSE, "coupling": COUPLING}

SCALE = GAIN = 0.2
"""Of all valves and of each, relative deviations."""

SCALES = 1e-3
"""Relative deviation of a known mass."""

RATE, DURATION = 20, 40
"""Hz and s."""

CORNERS = np.array([(0.25, 0.15), (0.25, -0.15), (-0.25, 0.15), (-0.25, -0.15)])
"""Where a robot on a table has valves, m."""

TABLE_SENSORS = {
    "rate": RATE,
    "joints": {"position": "2e-5 rad"},
    "attitude": {"angle": 1e-4},
    "position": {"std": 1e-4},
}

SPACE_SENSORS = {
    "rate": RATE,
    "gyro": {"angle_random_walk": "0.01 deg/sqrt(h)", "bias_instability": "0.3 deg/h"},
    "joints": {"position": "2.5e-5 rad"},
    "wheels": {"position": "2.5e-5 rad"},
    "attitude": {"angle": 1e-4},
    "position": {"std": 5e-4},
}

PLANAR_ARM = """
schema: orbident/robot/1
name: planar-arm
motion: planar
dh:
  base: {mass: 12 kg, com: [0.01, 0.02, 0], inertia: [0.2, 0.2, 0.3], xyz: [0.2, 0, 0]}
  rows:
    - {joint: j1, a: 0.3, mass: 1 kg, com: [-0.15, 0, 0], inertia: [0.01, 0.01, 0.02]}
    - {joint: j2, mass: 0.8 kg, com: [-0.1, 0.02, 0], inertia: [0.01, 0.01, 0.01]}
"""


class Flight(NamedTuple):
    """A recording, of what robot it is said to be, and what is true."""

    robot: Robot
    seen: Recording
    dead: str
    beta: np.ndarray


def gains(random: np.random.Generator, valves: int) -> np.ndarray:
    """Relative errors of thrust, as a robot file declares them."""
    of_each = 1 + GAIN * random.standard_normal(valves)
    return of_each * (1 + SCALE * random.standard_normal()) - 1


def weighed(random: np.random.Generator, mass: float) -> MeasuredQuantity:
    """What scales show, kg."""
    std = SCALES * mass
    return MeasuredQuantity(mass + std * random.standard_normal(), std)


def without_arm(folder: Path, seed: int, known: bool) -> Flight:
    """Eight valves on a table that is not level."""
    random = np.random.default_rng(1000 + seed)
    valve = int(random.integers(8))
    truth = valved_satellite.Truth(
        gains=gains(random, 8),
        coupling=COUPLING,
        clock=CLOCK,
        pulse=PULSE,
        tilt=tuple(1e-3 * random.standard_normal(2)),
    )
    truth = valved_satellite.with_dead(truth, 1 + valve)
    robot = valved_satellite.satellite(folder)
    if known:
        robot = replace(robot, known=KnownQuantities(weighed(random, truth.mass)))
    seen = valved_satellite.flown(truth, seed)
    return Flight(robot, seen, f"t{1 + valve}", valved_satellite.base_of(truth))


def planar_arm(folder: Path, seed: int, known: bool) -> Flight:
    """Two joints and eight valves on a table that is not level, without wheels."""
    path = folder / "arm.yaml"
    path.write_text(PLANAR_ARM)
    thrusters = [
        Thruster(f"{axis}{n}", np.append(at, 0.0), -np.sign(at[k]) * np.eye(3)[k], GAIN)
        for n, at in enumerate(CORNERS)
        for k, axis in enumerate("xy")
    ]
    robot = with_valves(load_robot(path), thrusters, TABLE_SENSORS)
    random = np.random.default_rng(2000 + seed)
    table = Environment(tilt=(2e-4 * random.normal(), 2e-4 * random.normal()))
    return flown(robot, seed, known, force=0.3, environment=table)


def servicer(_folder: Path, seed: int, known: bool) -> Flight:
    """The paper's arm and wheels, with two valves along each axis either way."""
    places = np.array([(0.9, 0.7, 0.3), (-0.8, 0.5, -0.4)])
    thrusters = [
        Thruster(
            f"t{6 * n + 2 * k + (s < 0)}", s * np.roll(p, k), s * np.eye(3)[k], GAIN
        )
        for n, p in enumerate(places)
        for k in range(3)
        for s in (1.0, -1.0)
    ]
    robot = with_valves(load_robot("paper-spatial"), thrusters, SPACE_SENSORS)
    return flown(robot, seed, known, force=10.0)


def with_valves(robot: Robot, thrusters: Sequence[Thruster], sensors: dict) -> Robot:
    """The robot with what its file would say of valves."""
    return replace(
        robot,
        thrusters=tuple(thrusters),
        sensors=declared_sensors(sensors),
        tolerances=Tolerances(
            thruster_clock=0.1,
            thruster_pulse=0.02,
            thruster_coupling=0.05,
            thruster_scale=SCALE,
        ),
    )


def commanded(random: np.random.Generator, names: list[str]) -> dict[str, np.ndarray]:
    """Which valves are asked to be open in each row: none, one, two or three."""
    on = {name: np.zeros(RATE * DURATION + 1) for name in names}
    row, end = 10, RATE * DURATION - 20
    while row < end:
        rows = min(int(random.integers(5, 25)), end - row)
        for name in random.permutation(names)[: random.integers(0, 4)]:
            on[name][row : row + rows] = 1.0
        row += rows
    return on


def pulses_of(on: dict[str, np.ndarray], thrust: dict[str, float]) -> list[Pulse]:
    """What valves do: late, short, and weaker the more are open."""
    open_ = {}
    for name, level in on.items():
        edges = np.flatnonzero(np.diff(level)) + 1
        open_[name] = [
            (first / RATE + CLOCK, last / RATE + CLOCK + PULSE)
            for first, last in edges.reshape(-1, 2)
        ]
    times = np.unique([t for each in open_.values() for pair in each for t in pair])
    pulses = []
    for start, end in pairwise(times):
        now = [
            name
            for name, each in open_.items()
            if any(a <= (start + end) / 2 < b for a, b in each)
        ]
        shared = 1 - COUPLING * (len(now) - 1)
        pulses += [
            Pulse(name, start, end, thrust[name] * shared)
            for name in now
            if thrust[name] > 0
        ]
    return pulses


def flown(
    robot: Robot,
    seed: int,
    known: bool,
    force: float,
    environment: Environment | None = None,
) -> Flight:
    """By the simulator; all valves are recorded with the same force (N)."""
    random = np.random.default_rng(seed)
    names = [each.name for each in robot.thrusters]
    thrust = force * (1 + gains(random, len(names)))
    valve = int(random.integers(len(names)))
    thrust[valve] = 0.0
    on = commanded(random, names)
    pulses = pulses_of(on, dict(zip(names, thrust, strict=True)))
    motion = random_motion(robot, seed, float(DURATION)).for_robot(robot)
    t = np.arange(RATE * DURATION + 1) / RATE
    q, qd, _ = motion.at(t[:1])
    start = standing(BaseState.of(motion.initial, robot), q[0])._replace(qd=qd[0])
    flight = free_flying(
        robot, t, start, motion, Driven(), pulses=pulses, environment=environment
    )
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), seed)
    seen = seen.with_columns(
        {f"thruster.{name}.force": force * level for name, level in on.items()}
    )
    beta = minimal_sets(robot).beta(robot.theta)
    if known:
        robot = replace(robot, known=KnownQuantities(weighed(random, robot.mass)))
    return Flight(robot, seen, names[valve], beta)


def scores(result: Result, beta: np.ndarray) -> list[float]:
    """What was found less what is true, in deviations."""
    fits = [(result.calibration[f"thrusters.{name}"], x) for name, x in SHARED.items()]
    off = [(fit.value - x) / fit.std for fit, x in fits]
    return [*((result.base.values - beta) / result.base.std).tolist(), *off]


def named_dead(result: Result) -> list[str]:
    named = [each.name for each in result.checks if "gives no thrust" in each.reason]
    return [name.split(".")[1] for name in named]


@pytest.mark.long
@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("fly", [without_arm, planar_arm, servicer])
def test_intervals_hold_and_the_fault_is_named(tmp_path, fly, known):
    z, right = [], 0
    for seed in range(SEEDS):
        robot, seen, dead, beta = fly(tmp_path, seed, known)
        result = identify(robot, seen)
        right += named_dead(result) == [dead]
        if result.status != "ok":
            print(seed, result.refusal())
            continue
        z.append(scores(result, beta))
        worst = max(map(abs, z[-1]))
        print(f"{seed}: dead {dead}, named {named_dead(result)}, worst {worst:.2f}")
    table = np.array(z)
    inside = np.mean(np.abs(table) < 1.96)
    print(f"{fly.__name__}, mass known: {known}; accepted {len(z)} of {SEEDS};")
    print(f"{inside:.1%} of {table.size} inside, worst {np.abs(table).max():.2f};")
    print(f"dead valve named in {right}")
    assert right >= 0.95 * SEEDS
    assert len(z) >= 0.95 * SEEDS
    # Numbers of one flight are correlated: three deviations of 95 %.
    assert abs(inside - 0.95) < 3 * np.sqrt(0.95 * 0.05 / table.size * 4)
