from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import SUITES, declared_sensors
from orbident.simulation.simulate import simulate


def test_sensors_of_a_robot_file():
    found = load_robot("paper-spatial").sensors
    assert set(found.declared) == {"gyro", "accelerometer", "joints", "wheels"}
    assert found.gyro is not None
    assert found.gyro.white_noise == pytest.approx(np.deg2rad(0.01) / 60)
    assert found.gyro.bias_instability == pytest.approx(np.deg2rad(0.3) / 3600)
    assert found.accelerometer is not None
    assert found.accelerometer.bias_instability == pytest.approx(10e-6 * 9.80665)
    assert found.of("joints").white_std() == 2.5e-5
    assert found.of("attitude").white_std() == 0.0


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"gyros": {}}, "sensors: unknown key 'gyros'; did you mean 'gyro'"),
        (
            {"gyro": {"bias": 1.0}},
            r"sensors: gyro: unknown key 'bias'; .*'bias_instability'",
        ),
        ({"attitude": {}}, r"sensors: attitude\.angle: this key is missing"),
        ({"wheels": {"position": -1.0}}, r"sensors: wheels\.position: found -1\.0"),
    ],
)
def test_bad_sections_are_refused(section, message):
    with pytest.raises(InputError, match=message):
        declared_sensors(section)


@pytest.mark.parametrize("name", SUITES)
def test_every_suite_records(name):
    suite = declared_sensors({"suites": [name]})
    robot = replace(load_robot("cepheus-like"), sensors=suite)
    recording = simulate(
        robot, random_motion(robot, duration=2.0), rate=100.0, noise="sensors"
    )
    measured = {column.split(".")[0] for column in recording.columns}
    kinds = {"joints": "joint", "wheels": "wheel"}
    assert measured == {kinds.get(key, key) for key in suite.declared} | {"joint"}
    assert all(np.isfinite(column).any() for column in recording.columns.values())


def test_the_papers_suite_is_that_of_its_robot():
    suite = declared_sensors({"suites": ["paper"]})
    assert load_robot("paper-spatial").sensors.declared == suite.declared
