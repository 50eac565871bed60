"""Joints that follow others: when their encoders show one motion, and what it is."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from random_motions import random_motion

import orbident as oi
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import SENSORS as CLOCKS
from orbident.preprocessing.followers import encoders_elsewhere, one_motion
from orbident.preprocessing.histories import Lead
from orbident.preprocessing.samples import samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Coupling, Robot
from orbident.robot.sensor_schema import declared_sensors

NOISE, OFFSET = 2.5e-5, 3e-3
"""rad: of an encoder, and what that of a follower may be off by."""

SHOWN = 4.0
"""Deviations within which all of some tens of numbers are."""


def coupled(factor: float) -> Robot:
    """The paper's robot, whose third link is small and follows the second joint."""
    robot = oi.load_robot("paper-spatial")
    theta = robot.theta.copy()
    theta[3] = 0.5, 0, 0, 0, 3e-4, 0, 3e-4, 0, 0, 3e-4
    _, leader, follower = robot.joints
    return replace(
        robot,
        theta=theta,
        joints=(*robot.joints[:2], replace(follower, position=None, velocity=None)),
        couplings=(Coupling(follower.name, leader.name, factor, 0.0),),
        sensors=declared_sensors({"rate": RATE, **SENSORS}),
    )


def flown(robot: Robot, seed: int, offset: float = 0.0) -> Recording:
    """Both joints are measured, with an offset of the follower's encoder."""
    motion = random_motion(robot, seed, 60.0, start="turning")
    led = replace(
        motion,
        joints=robot.joint_names[:2],
        **{name: getattr(motion, name)[:2] for name in ("a", "b", "start", "end")},
    )
    recording = oi.simulate(robot, led, noise="sensors", seed=seed)
    column = follower(robot)
    return recording.with_columns({column: recording.columns[column] + offset})


def follower(robot: Robot) -> str:
    return f"joint.{robot.couplings[0].follower}.position"


@pytest.mark.parametrize("factor", [-0.5, 5.0, 100.0])
def test_noise_is_no_motion_apart(factor):
    """Both move as the one that moves farther says."""
    robot = coupled(factor)
    recording = flown(robot, 1, OFFSET)
    found = one_motion(robot, recording)
    near = 0.2 * np.hypot(1, factor) * NOISE
    if abs(factor) > 1:
        expected = {"joint2": ("joint3", 1 / factor, -OFFSET / factor)}
        near /= abs(factor)
    else:
        expected = {"joint3": ("joint2", factor, OFFSET)}
    (name,) = found
    assert found[name][:2] == expected[name][:2]
    assert found[name].offset == pytest.approx(expected[name][2], abs=near)
    samples = samples_of(robot, recording, dict.fromkeys(CLOCKS, 0.0))
    assert samples.led == found
    _, q, led = samples.q
    offset = np.median(led - factor * q)
    np.testing.assert_allclose(led, factor * q + offset, rtol=0, atol=1e-12)
    np.testing.assert_allclose(samples.qd[2], factor * samples.qd[1], atol=1e-12)


def test_all_that_follow_one_joint_move_as_the_farthest():
    robot = coupled(3.0)
    names = robot.joint_names
    robot = replace(
        robot,
        couplings=(*robot.couplings, Coupling(names[0], names[1], -2.0, 0.1)),
    )
    t = np.arange(400.0) / 10
    random = np.random.default_rng(0)
    q = np.sin(t)
    moved = {names[0]: 0.1 - 2 * q, names[1]: q, names[2]: 3 * q}
    columns = {
        f"joint.{name}.position": x + NOISE * random.standard_normal(t.size)
        for name, x in moved.items()
    }
    found = one_motion(robot, Recording(t, columns))
    assert {*found} == {*names[:2]}
    for name, factor, offset in ((names[0], -2 / 3, 0.1), (names[1], 1 / 3, 0.0)):
        assert found[name].by == names[2]
        assert found[name].factor == pytest.approx(factor)
        assert found[name].offset == pytest.approx(offset, abs=NOISE)


@pytest.mark.parametrize("apart", [10 * NOISE, 1e-3])
def test_play_and_springs_between_joints_are(apart):
    """A slow motion between them, some times as large as the noise."""
    robot = coupled(5.0)
    recording = flown(robot, 1)
    column = follower(robot)
    swing = apart * np.hypot(1, 5) * np.sin(recording.t)
    moved = recording.with_columns({column: recording.columns[column] + swing})
    assert one_motion(robot, moved) == {}
    assert samples_of(robot, moved, dict.fromkeys(CLOCKS, 0.0)).led == {}


def test_an_encoder_elsewhere_is_told():
    """More than zeros of both are off within their tolerances of 1 mrad."""
    robot = coupled(0.5)
    zeros = dict.fromkeys(robot.joint_names, 1e-3)
    robot = replace(robot, tolerances=replace(robot.tolerances, joint_zero=zeros))
    assert [*encoders_elsewhere(robot, flown(robot, 1, 1e-3))] == []
    (words,) = encoders_elsewhere(robot, flown(robot, 1, 5e-3))
    assert "column 'joint.joint3.position' is 0.005 beside what" in words
    assert identify(robot, flown(robot, 1, 5e-3)).notes == (words,)


def test_a_column_with_gaps_leads_no_other():
    """What the other encoder saw meanwhile would be lost."""
    robot = coupled(5.0)
    recording = flown(robot, 1)
    column = follower(robot)
    for seen in (10, 300):
        q = recording.columns[column].copy()
        q[seen:] = np.nan
        (lead,) = one_motion(robot, recording.with_columns({column: q})).values()
        assert (lead.by, lead.factor) == ("joint2", 5.0)


def test_joints_that_never_move_are_all_named():
    robot = coupled(5.0)
    recording = flown(robot, 1)
    still = {
        f"joint.{name}.position": NOISE
        * np.random.default_rng(k).standard_normal(recording.t.size)
        for k, name in enumerate(robot.joint_names[1:])
    }
    held = recording.with_columns(still)
    samples = samples_of(robot, held, dict.fromkeys(CLOCKS, 0.0))
    assert samples.locked == robot.joint_names[1:]


def test_without_an_encoder_it_is_led():
    robot = coupled(100.0)
    recording = flown(robot, 1)
    columns = dict(recording.columns)
    for name in [each for each in columns if each.startswith("joint.joint3")]:
        del columns[name]
    alone = replace(recording, columns=columns)
    samples = samples_of(robot, alone, dict.fromkeys(CLOCKS, 0.0))
    assert samples.led == {"joint3": Lead("joint2", 100.0, 0.0)}


def worst(robot: Robot, result: Result) -> float:
    off = (result.base.values - minimal_sets(robot).beta(robot.theta)) / result.base.std
    return float(np.nanmax(np.abs(off)))


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "seed"), [(5.0, 0), (5.0, 4), (100.0, 2)])
def test_noise_of_two_encoders_shows_no_parameters(factor, seed):
    """What shows only as joints move apart is not determined, and all else is right.

    Taken for motion, noise had shown it, 5 to 9 deviations off.
    """
    robot = coupled(factor)
    recording = flown(robot, seed)
    both = identify(robot, recording)
    columns = dict(recording.columns)
    for name in [each for each in columns if each.startswith("joint.joint3")]:
        del columns[name]
    one = identify(robot, replace(recording, columns=columns))
    for result in (both, one):
        assert result.status == "ok"
        assert worst(robot, result) < SHOWN
    unknown = np.isnan(both.base.std)
    assert unknown.any()
    np.testing.assert_array_equal(unknown, np.isnan(one.base.std))
