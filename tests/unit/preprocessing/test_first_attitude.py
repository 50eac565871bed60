"""A base that nobody saw: its first attitude follows from the motion of S."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import SENSORS
from random_motions import random_motion
from scipy.spatial.transform import Rotation

from orbident.choices import SensorNoise
from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.simulate import simulate


def flown(noise: SensorNoise, seed: int) -> tuple[Robot, Recording]:
    """A recording without an attitude, of a base that is turned at first."""
    sensors = declared_sensors({"rate": 20.0, **SENSORS})
    robot = replace(load_robot("paper-spatial"), sensors=sensors)
    recording = simulate(robot, random_motion(robot, seed), noise=noise, seed=seed)
    return robot, recording


def unseen(recording: Recording) -> Recording:
    columns = {
        name: x
        for name, x in recording.columns.items()
        if not name.startswith("attitude")
    }
    return Recording(recording.t, columns, "unseen")


def test_it_is_that_which_the_velocity_shows():
    robot, recording = flown("none", 0)
    samples = samples_of(robot, unseen(recording))
    found = Rotation.from_quat(np.column_stack(samples.x_WB))
    true = Rotation.from_quat(
        np.column_stack([recording.column(f"attitude.{axis}") for axis in "xyzw"])
    )
    assert (found * true.inv()).magnitude().max() < 1e-4


@pytest.mark.parametrize("seed", [1, 2])
def test_positions_in_any_axes_are_enough(seed: int):
    """The axes of the positions had been named as wrong, as a fact."""
    robot, recording = flown("sensors", seed)
    off = np.random.default_rng(seed).uniform(0.8, 1.2, (len(robot.bodies), 1))
    by_cad = replace(robot, theta=off * robot.theta)
    result = identify(by_cad, unseen(recording))
    assert result.status == "ok", result.refusal()
    beta = minimal_sets(robot).beta(robot.theta)
    assert np.abs((result.base.values - beta) / result.base.std).max() < 4
