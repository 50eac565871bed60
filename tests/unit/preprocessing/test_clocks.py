from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, clean_space
from edited_recordings import changed
from random_motions import random_motion
from scipy.interpolate import CubicSpline

import orbident as oi
from orbident.errors import InputError
from orbident.preprocessing.delays import (
    Delay,
    check_seconds,
    clocks_in_words,
    corrections,
    delay_of,
)
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

SPATIAL, PLANAR = load_robot("paper-spatial"), load_robot("cepheus-like")


def found(robot: Robot, late: float, noise, seed=0, duration=40.0) -> oi.Result:
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
    clean, t = simulate(robot, motion, noise="none").columns, recording.t
    # The noise is that of each sample, the motion that of before.
    before = {**recording.columns, **clean}
    shown = {
        name: column - before[name] + CubicSpline(t, before[name])(t - late)
        for name, column in recording.columns.items()
        if name.startswith(("joint", "wheel"))
    }
    inside = (t > abs(late)) & (t < t[-1] - abs(late))
    recording = changed(recording.with_columns(shown), rows=inside)
    random = np.random.default_rng(seed)
    off = 1 + 0.2 * random.choice([-1, 1], robot.theta.shape)
    guess = replace(robot, theta=off * robot.theta)
    momentum = "at-rest" if planar else "unknown"
    return oi.identify(guess, recording, initial_momentum=momentum)


@pytest.mark.parametrize(
    "late",
    [
        # Smaller, and so what the larger one shows.
        pytest.param(0.037, marks=pytest.mark.long),
        pytest.param(-0.2, marks=pytest.mark.slow),
    ],
)
def test_without_noise_the_delay_is_exact(late):
    delay = found(SPATIAL, late, "none").clocks["joints"]
    # Splines through 20 Hz samples.
    assert delay.late == pytest.approx(late, abs=1e-5)
    assert delay.believed


@pytest.mark.parametrize("rows", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_joints_that_are_late_by_rows_are_corrected(rows):
    """By 0.1 s, and by 0.4 s, which is too far for first order."""
    flown = clean_space(seed=2, duration=40.0)
    columns = {
        name: column[:-rows] if name.startswith(("joint", "wheel")) else column[rows:]
        for name, column in flown.recording.columns.items()
    }
    result = oi.identify(flown.robot, oi.Recording(flown.recording.t[rows:], columns))
    assert result.level == "trust", result.warnings
    assert result.clocks["joints"].late == pytest.approx(rows / RATE, abs=1e-3)
    assert np.abs(flown.z(result)).max() < 4


def test_a_delay_that_is_not_sharp_is_in_the_deviations():
    result = found(PLANAR, 0.037, "sensors", 0)
    delay = result.clocks["joints"]
    assert abs(delay.late - 0.037) < 4 * delay.std < 4e-3
    assert delay.believed
    assert result.status == "ok", result.warnings
    assert "joints.clock" not in result.calibration
    off = result.base.values - oi.minimal_sets(PLANAR).beta(PLANAR.theta)
    assert np.abs(off / result.base.std).max() < 4


@pytest.mark.parametrize(
    ("robot", "noise", "seeds"),
    [
        (PLANAR, "sensors", 3),
        (PLANAR, "none", 1),
        pytest.param(SPATIAL, "sensors", 1, marks=pytest.mark.slow),
        pytest.param(SPATIAL, "sensors", 3, marks=pytest.mark.long),
        pytest.param(SPATIAL, "none", 1, marks=pytest.mark.slow),
    ],
)
def test_clocks_that_agree_are_left_alone(robot, noise, seeds):
    for seed in range(seeds):
        assert not found(robot, 0.0, noise, seed).clocks["joints"].believed


def test_a_delay_is_believed_if_it_is_sure_and_worth_it():
    assert delay_of(0.01, 1e-3, 0.0, 1.0, 0.5).believed
    assert not delay_of(0.004, 1e-3, 0.0, 1.0, 0.5).believed
    assert not delay_of(0.01, 1e-3, 0.0, 1.0, 0.99).believed
    assert not delay_of(0.01, 1e-3, 0.005, 1.0, 0.5).believed
    assert not delay_of(5e-5, 1e-9, 0.0, 1.0, 0.5).believed
    assert not delay_of(float("nan"), 1e-9, 0.0, 1.0, 0.5).believed


def test_what_shares_a_clock_is_corrected_together():
    clocks = {"joints": Delay(0.037, 1e-4, True), "attitude": Delay(0.01, 1e-2, False)}
    same = ("joints", "wheels", "torques")
    assert corrections(clocks) == dict.fromkeys(same, 0.037)
    assert clocks_in_words(clocks) == (
        "the clock of joints and wheels is 37.00 +- 0.1 ms behind that of the base "
        "rate: corrected",
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("who", "seconds"),
    [
        pytest.param(("joint.", "wheel."), 1.5, marks=pytest.mark.long),
        (("attitude.", "position."), 6.0),
    ],
)
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


@pytest.mark.parametrize(("unit", "count"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_times_in_another_unit_are_refused(unit: str, count: float):
    recording = simulate(PLANAR, random_motion(PLANAR, duration=5.0), noise="sensors")
    check_seconds(PLANAR, recording)
    counted = replace(recording, t=count * recording.t)
    with pytest.raises(InputError, match=f"seems to be in {unit}: give s"):
        check_seconds(PLANAR, counted)
