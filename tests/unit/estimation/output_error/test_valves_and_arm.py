"""A planar arm on a base with six valves and no wheel, flown by the simulator."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Thruster
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import Tolerances
from orbident.simulation.flight import JointPD, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import measure_truth, truth_of_flight
from orbident.simulation.outside import Pulse

FORCE, CLOCK, PULSE = 0.08, 0.15, -0.02
"""N as recorded, and s."""

RATE, DURATION = 16, 40
"""Hz and s."""

PLACES = np.array([(0.25, 0.15), (0.25, -0.15), (-0.25, 0.15), (-0.25, -0.15)])

DEAD = "c"


class Swinging:
    """Two joints that swing."""

    def at(self, t):
        rate = np.array([0.5, 0.8])
        angle = np.multiply.outer(t, rate) + np.array([0.3, 1.1])
        wave = 0.7 * np.sin(angle), 0.7 * rate * np.cos(angle)
        return *wave, -(rate**2) * wave[0]


@pytest.mark.slow
def test_a_dead_valve_beside_an_arm():
    x, y = np.eye(3)[:2]
    thrusters = [
        Thruster(name, np.append(at, 0.0), -np.sign(at[0]) * x, 0.2)
        for name, at in zip("abcd", PLACES, strict=True)
    ]
    thrusters += [Thruster("e", 0.15 * x, -y, 0.2), Thruster("f", -0.15 * x, y, 0.2)]
    sensors = {
        "rate": RATE,
        "joints": {"position": 2e-5},
        "attitude": {"angle": 1e-4},
        "position": {"std": 1e-4},
    }
    robot = replace(
        load_robot("cepheus-like"),
        wheels=(),
        thrusters=tuple(thrusters),
        disturbances={},
        sensors=declared_sensors(sensors),
        tolerances=Tolerances(
            thruster_clock=0.1,
            thruster_pulse=0.02,
            thruster_coupling=0.05,
            thruster_scale=0.2,
        ),
    )
    random = np.random.default_rng(7)
    gains = dict(zip("abcdef", 0.1 * random.standard_normal(6), strict=True))
    asked: dict[str, list[tuple[int, int]]] = {name: [] for name in gains}
    for row in range(8, RATE * DURATION - 40, 12):
        name = "abcdef"[int(random.integers(6))]
        asked[name].append((row, row + int(random.integers(4, 12))))
    pulses = [
        Pulse(
            name,
            on / RATE + CLOCK,
            off / RATE + CLOCK + PULSE,
            FORCE * (1 + gains[name]),
        )
        for name, each in asked.items()
        for on, off in each
        if name != DEAD
    ]
    t = np.arange(RATE * DURATION + 1) / RATE
    start = BaseState(np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3), np.zeros(0))
    law = JointPD(Kp=np.ones(2), Kd=np.full(2, 0.5))
    q, _, _ = Swinging().at(t[:1])
    flight = free_flying(
        robot, t, standing(start, q[0]), Swinging(), law, pulses=pulses
    )
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), 0)
    columns = dict(seen.columns)
    row = np.round(seen.t * RATE)
    for name, each in asked.items():
        on = sum((row >= first) & (row < last) for first, last in each)
        columns[f"thruster.{name}.force"] = FORCE * np.asarray(on, float)
    result = identify(robot, replace(seen, columns=columns))
    assert result.status == "ok", result.warnings
    named = [c.name for c in result.checks if "gives no thrust" in c.reason]
    assert named == [f"thruster.{DEAD}.gain"]
    beta = minimal_sets(robot).beta(robot.theta)
    assert np.abs((result.base.values - beta) / result.base.std).max() < 4
    for name, true in (("clock", CLOCK), ("pulse", PULSE)):
        fit = result.calibration[f"thrusters.{name}"]
        assert abs(fit.value - true) < 4 * fit.std < 0.01
