from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, clean_space
from edited_recordings import changed
from random_motions import random_motion

import orbident as oi
from orbident.estimation.clocks import clocks_in_words, joint_clocks, joint_delay
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.base_motion import AXES as GYRO
from orbident.preprocessing.delays import Delay, corrections, delay_of
from orbident.preprocessing.samples import samples_of
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.spatial import spatial_robot, spatial_trajectory

SPATIAL, PLANAR = load_robot("paper-spatial"), load_robot("cepheus-like")


def found(robot: Robot, late: float, noise, seed=0, duration=40.0) -> Delay:
    """What is found of joints whose clock is so much behind, with CAD 20 % off."""
    planar = robot.motion == "planar"
    motion = random_motion(
        robot,
        seed=3,
        duration=duration,
        start="spun up" if planar else "turning",
        wheel_speed=-170.0 if planar else 200.0,
    )
    recording = simulate(robot, motion, noise=noise, seed=seed)
    samples = samples_of(robot, recording, {"joints": -late, "wheels": -late})
    random = np.random.default_rng(seed)
    off = 1 + 0.2 * random.choice([-1, 1], robot.theta.shape)
    guess = replace(robot, theta=off * robot.theta)
    momentum = "at-rest" if planar else "unknown"
    find = joint_delay
    return find(guess, minimal_sets(guess), samples, momentum)


@pytest.mark.parametrize("late", [0.037, -0.2])
def test_without_noise_the_delay_is_exact(late):
    delay = found(SPATIAL, late, "none")
    # Splines through 20 Hz samples.
    assert delay.late == pytest.approx(late, abs=1e-7)
    assert delay.believed


@pytest.mark.parametrize("robot", [SPATIAL, PLANAR], ids=lambda robot: robot.name)
def test_with_noise_the_delay_is_right_to_a_millisecond(robot):
    for seed in range(3):
        delay = found(robot, 0.037, "sensors", seed)
        assert delay.late == pytest.approx(0.037, abs=1e-3)
        assert abs(delay.late - 0.037) < 4 * delay.std
        assert delay.believed


@pytest.mark.parametrize("robot", [SPATIAL, PLANAR], ids=lambda robot: robot.name)
@pytest.mark.parametrize("noise", ["none", "sensors"])
def test_clocks_that_agree_are_left_alone(robot, noise):
    for seed in range(3):
        assert not found(robot, 0.0, noise, seed).believed


def test_a_fast_logger():
    """A few thousand samples at 1000 Hz show too little motion to tell."""
    robot = spatial_robot()
    flight = simulate(robot, spatial_trajectory(robot), 1000.0, noise="sensors")
    part = changed(flight, rows=slice(25_000, 55_000))
    samples = samples_of(robot, part)
    delay = joint_delay(robot, minimal_sets(robot), samples, "unknown")
    assert delay.late == pytest.approx(0.0, abs=5e-3)
    assert not delay.believed


def test_many_parameters_and_few_samples():
    """440 of them take up noise; held near CAD they do not mimic a delay."""
    robot = load_robot("dual-arm")
    assert found(robot, 0.037, "none", duration=20.0).late == pytest.approx(
        0.037, abs=1e-4
    )


def test_a_delay_is_believed_if_it_is_sure_and_worth_it():
    assert delay_of(0.01, 1e-3, 0.0, 1.0, 0.5).believed
    assert not delay_of(0.004, 1e-3, 0.0, 1.0, 0.5).believed
    assert not delay_of(0.01, 1e-3, 0.0, 1.0, 0.99).believed
    assert not delay_of(0.01, 1e-3, 0.005, 1.0, 0.5).believed
    assert not delay_of(5e-5, 1e-9, 0.0, 1.0, 0.5).believed
    assert not delay_of(float("nan"), 1e-9, 0.0, 1.0, 0.5).believed


def test_what_shares_a_clock_is_corrected_together():
    clocks = {"joints": Delay(0.037, 1e-4, True), "attitude": Delay(0.01, 1e-2, False)}
    assert corrections(clocks) == {"joints": 0.037, "wheels": 0.037}
    assert clocks_in_words(clocks) == (
        "the clock of joints and wheels is 37.00 +- 0.1 ms behind that of the base "
        "rate: corrected",
    )


def test_a_search_that_loses_its_way_is_not_believed():
    """With an attitude that is wrong the delay grows beyond the recording."""
    motion = random_motion(PLANAR, duration=20.0, start="spun up")
    right = simulate(PLANAR, motion, rate=50.0, noise="sensors")
    x = dict(zip("xyzw", "wxyz", strict=True))
    wrong = {f"attitude.{k}": right.columns[f"attitude.{x[k]}"] for k in "xyzw"}
    samples = samples_of(PLANAR, changed(right, wrong), {})
    delay = joint_delay(PLANAR, minimal_sets(PLANAR), samples, "at-rest")
    assert not delay.believed


@pytest.mark.parametrize("rows", [1, 3])
def test_too_few_complete_samples_show_no_delay(rows):
    """No cubic goes through them; the fuzzer found such a recording."""
    flight = simulate(SPATIAL, random_motion(SPATIAL, wheel_speed=200.0), rate=20.0)
    few = {name: np.full(flight.t.size, np.nan) for name in GYRO}
    for name, column in few.items():
        column[:rows] = flight.columns[name][:rows]
    samples = samples_of(SPATIAL, changed(flight, few))
    assert joint_clocks(SPATIAL, minimal_sets(SPATIAL), samples, "unknown") == {}


@pytest.mark.parametrize("who", [("joint.", "wheel."), ("attitude.", "position.")])
@pytest.mark.parametrize("seconds", [1.5, 6.0])
def test_clocks_that_were_never_set_together_are_refused(who, seconds):
    """Not corrected: the message names which, by how much, and what to do."""
    flown = clean_space(seed=2)
    rows = round(seconds * RATE)
    columns = {
        name: column[:-rows] if name.startswith(who) else column[rows:]
        for name, column in flown.recording.columns.items()
    }
    late = oi.Recording(flown.recording.t[:-rows], columns)
    result = oi.identify(flown.robot, late)
    assert result.level == "do not trust"
    assert not any("corrected" in note for note in result.notes)
    assert np.isnan(result.mass.value)
    # Joints move so much in 6 s that the search for their delay loses its way.
    if who == ("joint.", "wheel.") and seconds > 5:
        return
    assert f"is about {seconds:.2g} s behind" in result.refusal()
    assert "one clock" in result.refusal()


def test_a_camera_that_is_late_is_corrected_as_before():
    flown = clean_space(seed=2)
    rows = 4
    columns = {
        name: column[:-rows] if name.startswith(("attitude.", "pos")) else column[rows:]
        for name, column in flown.recording.columns.items()
    }
    late = oi.Recording(flown.recording.t[:-rows], columns)
    result = oi.identify(flown.robot, late)
    assert result.level == "trust", result.warnings
    assert result.clocks["attitude"].late == pytest.approx(0.4, abs=2e-3)
    assert np.abs(flown.z(result)).max() < 4
