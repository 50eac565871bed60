"""A recording's columns in the robot's order, with what was missing derived."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.preprocessing.origins import Origin, origin_in_words
from orbident.preprocessing.samples import samples_of
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot

ROBOT = load_robot("cepheus-like")
T = np.arange(40) * 0.05


def columns(**changed):
    plain = {
        "joint.joint1.position": T**2,
        "joint.joint1.velocity": 2 * T,
        "joint.joint2.position": 1 + T**3,
        "joint.joint2.velocity": 3 * T**2,
        "wheel.rw.speed": np.full(T.size, -170.0),
        "gyro.x": 0 * T,
        "gyro.y": 0 * T,
        "gyro.z": T,
        "attitude.x": 0 * T,
        "attitude.y": 0 * T,
        "attitude.z": 0 * T,
        "attitude.w": 1 + 0 * T,
        "velocity.x": 4 * T,
        "velocity.y": 5 * T,
        "velocity.z": 0 * T,
    }
    named = {name.replace("__", "."): values for name, values in changed.items()}
    merged = plain | named
    return {name: values for name, values in merged.items() if values is not None}


def samples(**changed):
    return samples_of(ROBOT, Recording(T, columns(**changed), source="flight.csv"))


def test_columns_come_in_the_order_of_the_robot_and_without_a_copy():
    table = columns()
    taken = samples_of(ROBOT, Recording(T, table))
    assert np.shares_memory(taken.q[1], table["joint.joint2.position"])
    batch = taken.batch(0, T.size)
    np.testing.assert_array_equal(batch.q, np.stack([T**2, 1 + T**3], axis=1))
    np.testing.assert_array_equal(batch.v_S[:, 1], 5 * T)
    assert set(taken.origins.values()) == {Origin.MEASURED}


def test_only_the_rates_that_are_missing_are_derived():
    taken = samples(joint__joint2__velocity=None)
    np.testing.assert_allclose(taken.qd[1], 3 * T**2, atol=1e-12)  # a cubic: exact
    np.testing.assert_array_equal(taken.qd[0], 2 * T)
    assert origin_in_words(taken.origins["joint_rates"]) == (
        "derived: smoothed positions; measured"
    )


NO_VELOCITY = {f"velocity__{k}": None for k in "xyz"}


def test_wheel_speed_and_velocity_follow_from_positions():
    taken = samples(
        wheel__rw__speed=None,
        wheel__rw__position=-170 * T,
        **NO_VELOCITY,
        position__x=T**2,
        position__y=T,
        position__z=0 * T,
    )
    np.testing.assert_allclose(taken.qd_rw[0], -170, rtol=1e-12)
    np.testing.assert_allclose(taken.v_S[0], 2 * T, atol=1e-12)
    for name in ("wheel_speeds", "velocity"):
        assert taken.origins[name] is Origin.SMOOTHED_POSITIONS


def test_without_velocity_nothing_moves_but_momentum_stays():
    batch = samples(**NO_VELOCITY).batch(0, T.size)
    assert batch.turning.all()
    assert not batch.moving.any()


def test_gaps_of_joints_are_filled_and_gaps_of_the_gyro_are_not():
    gap = np.isin(np.arange(T.size), [5, 6])
    batch = samples(
        joint__joint1__position=np.where(gap, np.nan, T**2),
        gyro__z=np.where(np.arange(T.size) % 2, np.nan, T),
    ).batch(0, T.size)
    np.testing.assert_allclose(batch.q[[4, 6], 0], T[[4, 6]] ** 2, atol=1e-12)
    np.testing.assert_array_equal(batch.turning, np.arange(T.size) % 2 == 0)
    np.testing.assert_array_equal(batch.x_WB[1], [0, 0, 0, 1])


def test_the_last_batch_is_what_remains():
    batches = list(samples().batches(16))
    assert [batch.turning.size for batch in batches] == [16, 16, 8]
    np.testing.assert_array_equal(np.concatenate([b.w for b in batches])[:, 2], T)


def test_the_first_valid_sample():
    taken = samples(gyro__z=np.where(T < 0.5, np.nan, T))
    first = taken.first()
    assert first is not None
    assert first.w[0, 2] == T[10]
    assert samples(gyro__z=np.full(T.size, np.nan)).first() is None


def test_a_joint_that_moves_less_than_its_noise_is_locked():
    noise = 1e-5 * np.random.default_rng(0).standard_normal(T.size)
    taken = samples(joint__joint2__position=0.7 + noise, joint__joint2__velocity=noise)
    assert taken.locked == ("joint2",)
    assert np.ptp(taken.q[1]) == 0
    np.testing.assert_allclose(taken.q[1][0], 0.7, atol=1e-5)
    assert not taken.qd[1].any()


@pytest.mark.parametrize(
    "missing",
    ["joint.joint1.position", "gyro.y", "attitude.w", "wheel.rw.speed"],
)
def test_a_missing_column_is_named(missing):
    changed = {missing.replace(".", "__"): None}
    with pytest.raises(InputError, match=missing):
        samples(**changed)


NEVER = np.full(T.size, np.nan)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"attitude__w": NEVER}, "attitude has no samples while the gyro has"),
        (
            {"gyro__y": NEVER, **{f"attitude__{k}": None for k in "xyzw"}},
            "gyro has 0 samples",
        ),
        (
            {
                **{f"velocity__{k}": None for k in "xyz"},
                **{f"accelerometer__{k}": NEVER for k in "xyz"},
            },
            "accelerometer has 0 samples",
        ),
    ],
)
def test_what_has_no_samples_is_refused_with_the_file(changed, words):
    with pytest.raises(InputError, match=rf"^flight\.csv: .*{words}"):
        samples(**changed)
