"""Wheels of whose speeds tachometers alone tell, with noise, flown by MuJoCo."""

from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest
from acting_in_mujoco import Torque
from clean_recordings import SENSORS
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import random_robot, random_wheels

from orbident.estimation.identify import identify
from orbident.estimation.output_error import problem
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import Truth, measure_truth

RATE, DURATION, SPEED, RAMP = 20.0, 30.0, 100.0, 20.0
"""Hz; s; rad/s at the start, and so much more between two corners."""

FAR = 5.0
"""Deviations: of ten thousand numbers none is so far off by chance."""


class Flown:
    """One flight of a robot, which tachometers of any noise may see."""

    def __init__(self, robot: Robot, ramp: float) -> None:
        """Wheels are faster by `ramp` for a while, rad/s."""
        self.planar = robot.motion == "planar"
        # What turns a base on a table is seen by motion capture alone.
        unseen = {"gyro"} if self.planar else set()
        self.sensors = {k: x for k, x in SENSORS.items() if k not in unseen}
        self.robot, self.ramp = robot, ramp

    def undeclared(self, noise: float, seed: int) -> tuple[str, np.ndarray]:
        """As `identified`, where nobody declares that noise."""
        robot = self.seen(noise)
        recording = measure_truth(robot, *self.true, seed)
        sensors = robot.sensors.model_copy(update={"wheels": None})
        return self._judged(identify(replace(robot, sensors=sensors), recording))

    def seen(self, noise: float) -> Robot:
        """The robot with tachometers of this noise, rad/s."""
        sensors = {"rate": RATE, **self.sensors, "wheels": {"tachometer": noise}}
        return replace(self.robot, sensors=declared_sensors(sensors))

    @cached_property
    def true(self) -> tuple[np.ndarray, Truth]:
        """Times, and what is true at them."""
        start = "spun up" if self.planar else "turning"
        motion = random_motion(self.robot, 1, DURATION, SPEED, start)
        nothing = Torque(np.zeros(3))
        return Flight(self.seen(1.0), motion, nothing, ramp=self.ramp).flown

    def result(self, noise: float, seed: int) -> Result:
        """What is identified of a recording with tachometers of this noise."""
        robot = self.seen(noise)
        momentum = "at-rest" if self.planar else "unknown"
        recording = measure_truth(robot, *self.true, seed)
        return identify(robot, recording, initial_momentum=momentum)

    def identified(self, noise: float, seed: int) -> tuple[str, np.ndarray]:
        """The level, and errors of the base parameters over their deviations."""
        return self._judged(self.result(noise, seed))

    def _judged(self, result: Result) -> tuple[str, np.ndarray]:
        beta = minimal_sets(self.robot).beta(self.robot.theta)
        return result.level, (result.base.values - beta) / result.base.std


def drawn(seed: int, parents: tuple[int, ...], wheels: int) -> Robot:
    """Wheels in any direction; nothing acts on it, and instruments are as they say."""
    axes = random_wheels(seed, ("held",) * wheels)
    robot = random_robot(seed, parents, wheels=axes, base=20.0)
    exact = load_robot("paper-spatial").tolerances
    return replace(robot, disturbances={}, tolerances=exact)


def test_speeds_with_corners():
    level, off = Flown(drawn(3, (0, 1, 2), 3), RAMP).identified(0.3, seed=0)
    assert level == "trust"
    assert np.abs(off).max() < 4


def test_speeds_whose_noise_nobody_declares():
    """Taken for exact they had been refused, since nothing explained the gyro."""
    level, off = Flown(drawn(3, (0, 1, 2), 3), 0.0).undeclared(0.3, seed=0)
    assert level == "trust"
    assert np.abs(off).max() < 4


@pytest.mark.slow
def test_noise_that_limits_a_mass_is_named():
    """The tachometers here are three times as noisy as the worst ones above."""
    budget = Flown(drawn(3, (0, 1, 2), 3), RAMP).result(1.0, seed=0).budget()
    assert budget is not None
    assert "M is limited by noise of the wheel speeds" in budget.in_words()


@pytest.mark.slow
def test_noise_that_is_left_out_widens_no_deviation(monkeypatch):
    """Most waves of such a tachometer are; with all of them the same is found."""
    flown = Flown(drawn(3, (0, 1, 2), 3), 0.0)
    some = flown.result(0.01, seed=0)
    monkeypatch.setattr(problem, "NEGLIGIBLE", 0.0)
    every = flown.result(0.01, seed=0)
    moved = (some.base.values - every.base.values) / every.base.std
    assert np.abs(moved).max() < 0.1
    np.testing.assert_allclose(some.base.std, every.base.std, rtol=0.01)


@pytest.mark.long
@pytest.mark.parametrize("ramp", [0.0, RAMP])
@pytest.mark.parametrize("noise", [0.003, 0.03, 0.1, 0.3])
def test_intervals_hold_noise_of_tachometers(noise: float, ramp: float):
    """Four robots, eight seeds each; `-s` shows the table."""
    robots = {
        "paper-spatial": load_robot("paper-spatial"),
        "cepheus-like": load_robot("cepheus-like"),
        "random, three wheels": drawn(3, (0, 1, 2), 3),
        "random, four wheels": drawn(5, (0, 1, 0), 4),
    }
    every, refused = [], 0
    for name, robot in robots.items():
        flown = Flown(robot, ramp)
        found = [flown.identified(noise, seed) for seed in range(8)]
        off = np.abs([off for level, off in found if level != "do not trust"])
        print(
            f"{name:22} {noise:5g} rad/s, ramp {ramp:2g}: {len(off)} of 8, "
            f"{np.mean(off < 1.96):.1%} inside, worst {off.max():.1f}"
        )
        assert off.max() < FAR
        refused += 8 - len(off)
        every.append(off.ravel())
    # Of all 256 it is one, with wheels whose noise turns the base hundreds of times as
    # much as the gyro's own noise seems to.
    assert refused <= 1
    assert np.mean(np.concatenate(every) < 1.96) > 0.93
