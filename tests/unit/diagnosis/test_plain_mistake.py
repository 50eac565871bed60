"""A plain mistake of signs, orders or units is named before anything is fitted."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import clean_space
from random_motions import random_motion

from orbident.diagnosis.linear_test import plain_mistake
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

IN_G = "the accelerometer is in g, and not in m/s^2"


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("paper-spatial")


@pytest.fixture(scope="module")
def recording(robot) -> Recording:
    """Encoders and an IMU, with their noise."""
    return simulate(robot, random_motion(robot), noise="sensors", seed=1)


def degrees(recording: Recording) -> Recording:
    gyro = {f"gyro.{k}": np.degrees(recording.column(f"gyro.{k}")) for k in "xyz"}
    return recording.with_columns(gyro)


def accelerometer_in_g(recording: Recording) -> Recording:
    names = [f"accelerometer.{k}" for k in "xyz"]
    in_g = {name: recording.column(name) / 9.80665 for name in names}
    return recording.with_columns(in_g)


def wheels_in_rpm(recording: Recording) -> Recording:
    wheels = {
        name: x * 30 / np.pi
        for name, x in recording.columns.items()
        if name.startswith("wheel.")
    }
    return recording.with_columns(wheels)


def exchanged(recording: Recording) -> Recording:
    one, other = "joint.joint1.position", "joint.joint2.position"
    columns = recording.columns
    return recording.with_columns({one: columns[other], other: columns[one]})


@pytest.mark.parametrize(
    ("mistaken", "words", "method"),
    [
        # It is found before any method is at work: `tests/contract` has all of them.
        (degrees, "the gyro is in degrees per second", "recursive"),
        (exchanged, "joints joint1 and joint2 are exchanged", "maximum-likelihood"),
        # They leave residuals as they are: parameters are far from those of CAD.
        (wheels_in_rpm, "perhaps all wheels are in rpm", "structured"),
        (accelerometer_in_g, f"perhaps {IN_G}", "maximum-likelihood"),
    ],
)
def test_no_fit_is_made(robot, recording, monkeypatch, mistaken, words, method):
    def fitted(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(OutputError, "estimate", fitted)
    result = identify(robot, mistaken(recording), method)
    assert result.status == "rejected"
    assert words in result.refusal()
    assert result.with_causes("all").refusal() == result.refusal()


@pytest.mark.slow
def test_an_accelerometer_in_g_beside_a_position():
    """Eqs. 24 and 31 know nothing of it."""
    good = {"velocity_random_walk": 1e-4, "bias_instability": 1e-5}
    known = clean_space(1, accelerometer=good)
    in_g = accelerometer_in_g(known.recording)
    result = identify(known.robot, in_g).with_causes()
    assert result.refusal().startswith(f"{IN_G}: with that corrected the recording is")


@pytest.mark.parametrize(
    ("name", "seeds"),
    [
        ("paper-spatial", 2),
        ("cepheus-like", 2),
        # Every convention of 496 `pi` takes a minute where any is tried.
        pytest.param("dual-arm", 1, marks=pytest.mark.slow),
    ],
)
def test_nothing_is_wrong(name, seeds):
    robot = load_robot(name)
    for seed in range(seeds):
        flown = simulate(
            robot, random_motion(robot, seed=seed), noise="sensors", seed=seed
        )
        noisy = replace(flown, columns=noisier(flown, seed))
        for each in (flown, noisy):
            problem = momentum_problem(robot, each, "unknown", lambda _: None)
            assert not plain_mistake(problem)


def noisier(recording: Recording, seed: int) -> dict[str, np.ndarray]:
    """A hundredth of each signal's size beside it, but for quaternions."""
    random = np.random.default_rng(seed)
    return {
        name: x
        if name.startswith("attitude")
        else x + 0.01 * np.nanstd(x) * random.standard_normal(x.size)
        for name, x in recording.columns.items()
    }


@pytest.mark.parametrize("sign", [1.0, pytest.param(-1.0, marks=pytest.mark.slow)])
def test_noise_that_changes_its_sign_from_sample_to_sample(robot, recording, sign):
    """It is less alike than white noise: the root of that would be no number."""
    there_and_back = 5e-3 * (-1.0) ** np.arange(recording.t.size)
    gyro = {f"gyro.{k}": recording.column(f"gyro.{k}") + there_and_back for k in "xyz"}
    for name in recording.columns:
        if name.startswith("wheel.rw_x"):
            gyro[name] = sign * recording.column(name)
    problem = momentum_problem(
        robot, recording.with_columns(gyro), "unknown", lambda _: None
    )
    found = [check.reason for check in plain_mistake(problem)]
    assert len(found) == (sign < 0)
    assert all("the sign of wheel rw_x" in reason for reason in found)
