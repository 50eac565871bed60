from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_suites import SUITES, sensor_suite
from orbident.simulation.measure import SensorModels, sensor_models
from orbident.simulation.simulate import simulate


def test_nothing_declared_is_nothing_measured():
    assert sensor_models({}) == SensorModels()
    assert sensor_models({"rate": 20.0}) == SensorModels()


def test_sensors_of_a_robot_file():
    found = sensor_models(load_robot("paper-spatial").sensors)
    assert found.gyro is not None
    assert found.gyro.angle_random_walk == pytest.approx(np.deg2rad(0.01) / 60)
    assert found.gyro.bias_instability == pytest.approx(np.deg2rad(0.3) / 3600)
    assert found.accelerometer is not None
    assert found.accelerometer.bias_instability == pytest.approx(10e-6 * 9.80665)
    assert found.joints is not None
    assert found.joints.position == 2.5e-5
    assert (found.attitude, found.position) == (None, None)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"gyros": {}}, "sensors: unknown key 'gyros'; did you mean 'gyro'"),
        (
            {"gyro": {"bias": 1.0}},
            r"sensors\.gyro: unknown key 'bias'; .*'bias_instability'",
        ),
        ({"attitude": {}}, r"sensors\.attitude: a key is missing; give .*angle"),
        ({"wheels": {"position": -1.0}}, r"sensors\.wheels\.position: found -1\.0"),
    ],
)
def test_bad_sections_are_refused(section, message):
    with pytest.raises(InputError, match=message):
        sensor_models(section)


@pytest.mark.parametrize("name", SUITES)
def test_every_suite_records(name):
    suite = sensor_suite(name)
    robot = replace(load_robot("cepheus-like"), sensors=suite)
    recording = simulate(
        robot, random_motion(robot, duration=2.0), rate=100.0, noise="sensors"
    )
    measured = {column.split(".")[0] for column in recording.columns}
    kinds = {"joints": "joint", "wheels": "wheel"}
    assert measured == {kinds.get(key, key) for key in suite} | {"joint"}
    assert all(np.isfinite(column).any() for column in recording.columns.values())


def test_the_papers_suite_is_that_of_its_robot():
    robot = load_robot("paper-spatial")
    assert {"rate": 20.0} | sensor_suite("paper") == robot.sensors


def test_a_suite_is_a_copy():
    sensor_suite("paper")["gyro"]["bias_instability"] = 0.0
    assert sensor_suite("paper")["gyro"]["bias_instability"] > 0


def test_an_unknown_suite_is_refused():
    with pytest.raises(InputError, match="'papers': did you mean 'paper'"):
        sensor_suite("papers")
