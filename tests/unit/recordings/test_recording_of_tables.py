"""What Python users have at hand: mappings, frames, arrays of vectors."""

import sys

import numpy as np
import pandas as pd
import pytest
from processes import finished
from small_problems import small_recording

import orbident as oi


@pytest.fixture(scope="module")
def robot() -> oi.Robot:
    return oi.load_robot("cepheus-like")


@pytest.fixture(scope="module")
def recording(robot: oi.Robot) -> oi.Recording:
    return small_recording(robot)


def same(one: oi.Recording, other: oi.Recording) -> bool:
    return np.array_equal(one.t, other.t) and all(
        np.array_equal(one.columns[name], other.columns[name], equal_nan=True)
        for name in other.columns
    )


def test_a_frame_and_back(recording: oi.Recording):
    frame = recording.to_frame()
    assert same(oi.Recording.of(frame), recording)
    assert same(oi.Recording.of(frame.reset_index()), recording)


def test_vectors_are_arrays():
    t = np.linspace(0.0, 1.0, 5)
    gyro, attitude = np.arange(15.0).reshape(5, 3), np.tile([0.0, 0, 0, 1], (5, 1))
    found = oi.Recording.of({"t": t, "gyro": gyro, "attitude": attitude})
    np.testing.assert_array_equal(found.vector("gyro"), gyro)
    np.testing.assert_array_equal(found.vector("attitude", "xyzw"), attitude)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"t": [0, 1], "gyro": np.zeros((2, 4))}, "2 by 3|by 3 components"),
        ({"gyro.x": [0.0, 1.0]}, "'t' is missing"),
        ({"t": [0, 1], "gyro": np.zeros((2, 3)), "gyro.x": [0, 1]}, "2 columns are"),
        (pd.DataFrame({"gyro.x": [0.0, 1.0]}), "'t' is missing"),
    ],
)
def test_one_line_for_what_is_none(table, words: str):
    with pytest.raises(oi.InputError, match=words):
        oi.Recording.of(table)


def test_identify_takes_what_is_at_hand(robot: oi.Robot, recording: oi.Recording):
    expected = oi.identify(robot, recording, initial_momentum="at-rest")
    from_frame = oi.identify(robot, recording.to_frame(), initial_momentum="at-rest")
    assert float(from_frame.mass) == float(expected.mass)
    assert from_frame["M"].value == expected.base.values[0]
    assert from_frame["pi_1"].std == expected.pi.std[0]
    assert oi.validate(expected, recording.to_frame()).samples == recording.t.size
    with pytest.raises(oi.InputError, match="phi_1"):
        expected["phi_11"]


REFUSED = """
import orbident as oi
for call in (
    lambda: oi.identify('cepheus-like', 3),
    lambda: oi.validate({'t': [0, 1]}, None),
):
    try:
        call()
    except oi.InputError as error:
        print(error)
"""


def test_other_things_are_refused_in_one_line():
    """Without the types that tests check."""
    one, other = finished(sys.executable, "-c", REFUSED).stdout.splitlines()
    assert "found int in place of a recording" in one
    assert "give the result first" in other


def test_a_robot_without_a_file(robot: oi.Robot):
    """As YAML has it, by its keys."""
    made = oi.load_robot(
        {
            "name": "satellite",
            "bodies": {"base": {"mass": np.float64(10), "inertia": np.ones(3)}},
            "thrusters": [
                {
                    "name": "t1",
                    "position": [0.1, 0, 0],
                    "direction": [0, 1, 0],
                    "thrust": 1.0,
                }
            ],
        }
    )
    assert made.mass == pytest.approx(10.0)
    with pytest.raises(oi.InputError, match="bodis"):
        oi.load_robot({"bodis": {}})
