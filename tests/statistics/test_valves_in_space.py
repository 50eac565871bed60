"""A servicer with arm, wheels and twelve valves: late, short, on one tank, one dead.

Flown by the simulator, which other engines fly alike (`tests/oracles`); how valves work
is written here. Of as many seeds as ORBIDENT_VALVES says (20 by default):

    ORBIDENT_VALVES=20 pytest -m long -s tests/statistics/test_valves_in_space.py
"""

import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
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
from orbident.simulation.control_laws import Driven, Pulse
from orbident.simulation.flight import standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import measure_truth, truth_of_flight

SEEDS = int(os.environ.get("ORBIDENT_VALVES", "20"))

FORCE, CLOCK, PULSE, COUPLING = 10.0, 0.15, -0.02, 0.08
"""N as recorded, s, s, and what each loses for every further one."""

RATE, DURATION = 20, 40
"""Hz and s."""

SENSORS = {
    "rate": RATE,
    "gyro": {"angle_random_walk": "0.01 deg/sqrt(h)", "bias_instability": "0.3 deg/h"},
    "joints": {"position": "2.5e-5 rad"},
    "wheels": {"position": "2.5e-5 rad"},
    "attitude": {"angle": 1e-4},
    "position": {"std": 5e-4},
}


def servicer(known: bool) -> Robot:
    """The paper's, with two valves along each axis either way."""
    places = np.array([(0.9, 0.7, 0.3), (-0.8, 0.5, -0.4)])
    thrusters = [
        Thruster(
            f"t{6 * n + 2 * k + (s < 0)}", s * np.roll(p, k), s * np.eye(3)[k], 0.2
        )
        for n, p in enumerate(places)
        for k in range(3)
        for s in (1.0, -1.0)
    ]
    robot = load_robot("paper-spatial")
    scales = KnownQuantities(mass=MeasuredQuantity(robot.mass, 1e-3 * robot.mass))
    return replace(
        robot,
        thrusters=tuple(thrusters),
        sensors=declared_sensors(SENSORS),
        known=scales if known else robot.known,
        tolerances=Tolerances(
            thruster_clock=0.1,
            thruster_pulse=0.02,
            thruster_coupling=0.05,
            thruster_scale=0.2,
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


def pulses_of(on: dict[str, np.ndarray], gains: dict[str, float]) -> list[Pulse]:
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
        force = FORCE * (1 - COUPLING * (len(now) - 1))
        pulses += [
            Pulse(name, start, end, force * (1 + gains[name]))
            for name in now
            if gains[name] > -1
        ]
    return pulses


def flown(robot: Robot, seed: int) -> tuple[Recording, str]:
    """A recording, and which valve is dead."""
    random = np.random.default_rng(seed)
    names = [each.name for each in robot.thrusters]
    gains = dict(zip(names, 0.2 * random.standard_normal(len(names)), strict=True))
    dead = str(random.choice(names))
    scale = 0.1 * random.standard_normal()
    gains = {name: (1 + x) * (1 + scale) - 1 for name, x in gains.items()}
    gains[dead] = -1.0
    on = commanded(random, names)
    motion = random_motion(robot, seed, float(DURATION)).for_robot(robot)
    t = np.arange(RATE * DURATION + 1) / RATE
    q, qd, _ = motion.at(t[:1])
    start = standing(BaseState.of(motion.initial, robot), q[0])._replace(qd=qd[0])
    flight = free_flying(robot, t, start, motion, Driven(), pulses=pulses_of(on, gains))
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), seed)
    force = {f"thruster.{name}.force": FORCE * level for name, level in on.items()}
    return seen.with_columns(force), dead


def scores(result: Result, robot: Robot) -> list[float]:
    """What was found less what is true, in deviations."""
    beta = minimal_sets(robot).beta(robot.theta)
    shared = {"clock": CLOCK, "pulse": PULSE, "coupling": COUPLING}
    fits = [result.calibration[f"thrusters.{name}"] for name in shared]
    off = [(f.value - x) / f.std for f, x in zip(fits, shared.values(), strict=True)]
    return [*((result.base.values - beta) / result.base.std).tolist(), *off]


def named_dead(result: Result) -> list[str]:
    named = [each.name for each in result.checks if "gives no thrust" in each.reason]
    return [name.split(".")[1] for name in named]


@pytest.mark.long
@pytest.mark.parametrize("known", [False, True])
def test_intervals_hold_and_the_fault_is_named(known):
    robot = servicer(known)
    z, right, refused = [], 0, 0
    for seed in range(SEEDS):
        seen, dead = flown(robot, seed)
        result = identify(robot, seen)
        right += named_dead(result) == [dead]
        if result.status != "ok":
            refused += 1
            print(seed, result.refusal())
            continue
        own = scores(result, robot)
        z.append(own)
        worst = max(map(abs, own))
        print(f"{seed}: dead {dead}, named {named_dead(result)}, worst {worst:.2f}")
    table = np.array(z)
    inside = np.mean(np.abs(table) < 1.96)
    print(f"known {known}: {inside:.1%} of {table.size} numbers are inside,")
    print(f"{right} of {SEEDS} dead valves are named, {refused} flights refused")
    assert right >= 0.95 * SEEDS
    assert refused <= 0.05 * SEEDS
    # Numbers of one flight are correlated: three deviations of 95 %.
    assert abs(inside - 0.95) < 3 * np.sqrt(0.95 * 0.05 / table.size * 4)
