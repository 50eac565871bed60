import numpy as np
import pytest

from orbident.recordings.no_measurements import (
    no_measurements,
    reasons_in_words,
    sensor_groups,
)

T = np.arange(0.0, 40.0, 0.05)
N = T.size
NOISE = np.random.default_rng(0).standard_normal((N, 3))
MOTION = np.column_stack([np.sin(0.3 * T), np.cos(0.5 * T), 0.2 * np.sin(T)])
X = MOTION + 1e-3 * NOISE
REPEAT, FROZEN = "repeat of the sample before", "sample of a frozen sensor"


def found(sensor, x):
    return {
        reason: np.flatnonzero(mask)
        for reason, mask in no_measurements(sensor, x).items()
    }


@pytest.mark.parametrize("rows", [[0], [N - 1], [0, 1, 2], [*range(100, 130)]])
@pytest.mark.parametrize("value", [-9999, 9999999])
def test_an_impossible_value_is_found_wherever_it_stands(rows, value):
    x = X.copy()
    x[rows, 1] = value
    ((reason, where),) = found("gyro", x).items()
    assert reason == f"sample with the impossible value {value}"
    np.testing.assert_array_equal(where, rows)


def test_an_impossible_value_of_all_axes_and_one_at_either_side():
    x = X.copy()
    x[100:110], x[300:305] = 9999999, -9999
    assert {
        reason.split()[-1]: where.size for reason, where in found("gyro", x).items()
    } == {
        "9999999": 10,
        "-9999": 5,
    }


def test_positions_that_did_not_come_are_zeros():
    x, gone = X + 1.0, np.random.default_rng(0).random(N) < 0.1
    x[gone] = 0.0
    (where,) = found("position", x).values()
    np.testing.assert_array_equal(where, np.flatnonzero(gone))
    # Rates may be zero, and a position may begin there.
    assert found("gyro", x) == {}
    assert found("position", MOTION - MOTION[0]) == {}


@pytest.mark.parametrize("step", [2, 5])
@pytest.mark.parametrize("sensor", ["gyro", "attitude", "joint.elbow.position"])
def test_of_what_is_held_the_first_is_kept(sensor, step):
    held = X[np.arange(N) // step * step]
    where = found(sensor, held[:, :1] if "joint" in sensor else held)[REPEAT]
    np.testing.assert_array_equal(where, np.flatnonzero(np.arange(N) % step))


def test_what_is_held_in_its_own_time_has_gaps():
    x = np.full((2 * N, 3), np.nan)
    x[::2] = X[np.arange(N) // 4 * 4]
    where = found("position", x)[REPEAT]
    np.testing.assert_array_equal(where, 2 * np.flatnonzero(np.arange(N) % 4))


@pytest.mark.parametrize("pose", [X[200], np.zeros(3)])
@pytest.mark.parametrize("rows", [slice(200, 210), slice(200, N)])
def test_a_frozen_pose_is_found_also_at_the_end(pose, rows):
    x = X.copy()
    x[rows] = pose
    np.testing.assert_array_equal(found("position", x)[FROZEN], np.arange(N)[rows])
    assert found("gyro", x) == {}


@pytest.mark.parametrize("count", [0.1, 0.02, 1e-3, 1e-4])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize(
    "sensor", ["position", "joint.elbow.position", "gyro", "accelerometer"]
)
def test_a_coarse_sensor_is_left_as_it_is(sensor, count, noise):
    x = count * np.round((MOTION + noise * NOISE) / count)
    assert found(sensor, x[:, :1] if "joint" in sensor else x) == {}


def test_an_accelerometer_freezes_and_rests():
    """Equal samples are a fault where there is noise; else the robot may rest."""
    x = X.copy()
    x[300:321] = x[300]
    assert list(found("accelerometer", x)) == [FROZEN]
    np.testing.assert_array_equal(
        found("accelerometer", x)[FROZEN], np.arange(300, 321)
    )
    rests = MOTION.copy()
    rests[:200] = 0.0
    assert found("accelerometer", rests) == {}


def test_a_robot_that_rests_at_first_and_at_last_is_left_as_it_is():
    s = np.clip((T - 10) / 20, 0, 1)
    x = MOTION[400] * (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None]
    for sensor in ("position", "attitude", "gyro", "joint.elbow.position"):
        assert found(sensor, x) == {}


def test_a_staircase_is_no_held_sensor():
    levels = np.random.default_rng(1).uniform(-100, 100, 20)
    assert found("wheel.rw.speed", np.repeat(levels, 40)[:, None]) == {}


def test_too_few_samples_tell_nothing():
    assert found("position", np.zeros((8, 3))) == {}
    assert found("gyro", np.full((N, 3), np.nan)) == {}


def test_groups_of_columns():
    names = ["t", "gyro.x", "gyro.y", "force.x", "joint.a.position", "note"]
    assert sensor_groups(names) == {
        "gyro": ["gyro.x", "gyro.y"],
        "joint.a.position": ["joint.a.position"],
    }


def test_reasons_in_words():
    assert reasons_in_words({"spike": 1, REPEAT: 2}) == [
        "1 spike",
        "2 repeats of the sample before",
    ]
