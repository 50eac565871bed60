import math
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import clean_space

from orbident.estimation.recursive.filter_input import noise_of
from orbident.preprocessing.samples import samples_of
from orbident.robot.sensor_schema import GyroSpec
from orbident.simulation.sensor import markov

B, T = 1e-5, 100.0
SECTION = {"angle_random_walk": 1e-6, "bias_instability": B, "correlation_time": T}
GYRO = GyroSpec.model_validate(SECTION)


def test_the_walk_is_that_of_the_simulated_bias():
    """Increments over a second, of a process of which it is a model."""
    t, std = 0.01 * np.arange(400_000), np.array([GYRO.drift_std])
    bias = markov(np.random.default_rng(0), t, std, np.array([T]), from_zero=True)
    steps = np.diff(bias[::100], axis=0)
    assert steps.std() == pytest.approx(GYRO.bias_walk, rel=0.03)


def test_all_that_use_it_have_the_same_walk():
    flown = clean_space(seed=0, duration=20.0, gyro=SECTION)
    noise = noise_of(flown.robot, samples_of(flown.robot, flown.recording))
    assert noise.gyro_walk == GYRO.bias_walk
    assert GYRO.bias_walk == pytest.approx(1.0760 * B * math.sqrt(2 / T), rel=1e-4)


def test_a_section_without_a_bias_does_not_make_it_known():
    for gyro in (GyroSpec(angle_random_walk=1e-6), GYRO, GyroSpec()):
        assert gyro.turn_on_std == GyroSpec.UNKNOWN_BIAS
    assert GyroSpec(turn_on_bias=1e-4).turn_on_std == 1e-4


def test_a_recursion_finds_a_bias_of_which_nothing_is_declared():
    """1 deg/h at turn-on, while the file gives the random walk alone."""
    white = {"angle_random_walk": math.radians(0.01) / 60, "bias_instability": 0.0}
    flown = clean_space(seed=1, gyro={**white, "turn_on_bias": math.radians(1.0)})
    gyro = {"gyro": GyroSpec.model_validate(white)}
    robot = replace(flown.robot, sensors=flown.robot.sensors.model_copy(update=gyro))
    noise = noise_of(robot, samples_of(robot, flown.recording))
    assert noise.gyro_bias == GyroSpec.UNKNOWN_BIAS
