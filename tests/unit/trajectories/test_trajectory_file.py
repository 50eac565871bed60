import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.trajectories.trajectory import InitialState, Trajectory
from orbident.trajectories.trajectory_file import (
    load_experiment,
    load_trajectory,
    numbered,
    save_trajectory,
)

HEAD = "schema: orbident/trajectory/1\n"
SMALL = HEAD + "duration: 2\njoints: {j: {a: [1], b: [2]}}\n"
INTERFACE_EXAMPLE = """\
schema: orbident/trajectory/1
duration: 80.0                  # t_f, s
joints:
  joint1: {a: [0.0411, -0.0622], b: [0.0533, -0.1269], start: {position: 0.5}}
  joint2: {a: [1e-3], b: [2], end: {velocity: 0.1, acceleration: -0.2}}
  joint3: {}
initial: {angular_velocity: [0.01, 0.03, 0.025], attitude: [0.2, 0.1, 0.3, 0.93],
          velocity: [0, 0, 0], wheel_speed: {rw_x: 277.8}}
design: {objective: cond, value: 5.8, margins: {joint1: [0.1, 0.2]}}
"""

number = st.floats(-LARGEST, LARGEST)
names = st.lists(st.text(min_size=1, max_size=6), unique=True, max_size=3)


@st.composite
def fields(draw):
    joints = draw(names)
    K, harmonics = len(joints), draw(st.integers(0, 3)) if joints else 0
    return {
        "duration": draw(st.floats(SMALLEST, LARGEST)),
        "joints": tuple(joints),
        "a": draw(arrays(float, (K, harmonics), elements=number)),
        "b": draw(arrays(float, (K, harmonics), elements=number)),
        "start": draw(arrays(float, (K, 3), elements=number)),
        "end": draw(arrays(float, (K, 3), elements=number)),
        "design": draw(st.none() | st.just({"objective": "cond", "scores": [1.0, 2]})),
    }


initial_fields = st.fixed_dictionaries(
    {
        "angular_velocity": arrays(float, 3, elements=number),
        "attitude": arrays(float, 4, elements=st.floats(0.45, 0.54)),
        "velocity": arrays(float, 3, elements=number),
        "wheel_speed": st.dictionaries(st.sampled_from("ab"), number),
    }
)


@given(fields=fields(), initial_fields=initial_fields)
def test_round_trip_is_bit_identical(fields, initial_fields):
    written = Trajectory(**fields, initial=InitialState(**initial_fields))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "traj.yaml"
        save_trajectory(written, path)
        read = load_trajectory(path)
    assert (read.duration, read.joints) == (written.duration, written.joints)
    for name in ("a", "b", "start", "end"):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))
    for name in ("angular_velocity", "attitude", "velocity"):
        np.testing.assert_array_equal(
            getattr(read.initial, name), getattr(written.initial, name)
        )
    assert read.initial.wheel_speed == written.initial.wheel_speed
    assert read.design == written.design


def load(tmp_path, text):
    path = tmp_path / "traj.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_trajectory(path)


def test_the_interfaces_example(tmp_path):
    trajectory = load(tmp_path, INTERFACE_EXAMPLE)
    assert trajectory.joints == ("joint1", "joint2", "joint3")
    np.testing.assert_array_equal(trajectory.a, [[0.0411, -0.0622], [0.001, 0], [0, 0]])
    np.testing.assert_array_equal(trajectory.b, [[0.0533, -0.1269], [2, 0], [0, 0]])
    np.testing.assert_array_equal(trajectory.start[0], [0.5, 0, 0])
    np.testing.assert_array_equal(trajectory.end[1], [0, 0.1, -0.2])
    assert trajectory.initial.wheel_speed == {"rw_x": 277.8}
    assert trajectory.design is not None
    assert trajectory.design["value"] == 5.8
    assert trajectory.source == str(tmp_path / "traj.yaml")


def test_defaults(tmp_path):
    trajectory = load(tmp_path, SMALL)
    assert not trajectory.start.any()
    assert not trajectory.end.any()
    np.testing.assert_array_equal(trajectory.initial.attitude, [0, 0, 0, 1])
    assert trajectory.design is None


def test_numbers_that_yaml_reads_as_text(tmp_path):
    text = SMALL.replace("duration: 2", 'duration: "2e1"').replace("[1]", "[1e-3]")
    trajectory = load(tmp_path, text)
    assert trajectory.duration == 20.0
    assert trajectory.a == [[0.001]]


def test_numpy_numbers_in_the_design(tmp_path):
    trajectory = load(tmp_path, SMALL)
    design = {"value": np.float64(5.8), "margins": np.array([1.0, 2.0]), "n": (1, 2)}
    path = tmp_path / "designed.yaml"
    save_trajectory(
        Trajectory(
            trajectory.duration,
            trajectory.joints,
            trajectory.a,
            trajectory.b,
            trajectory.start,
            trajectory.end,
            design=design,
        ),
        path,
    )
    expected = {"value": 5.8, "margins": [1.0, 2.0], "n": [1, 2]}
    assert load_trajectory(path).design == expected


def swap(old, new):
    assert old in SMALL
    return SMALL.replace(old, new)


REFUSED = {
    "empty": ("", "an empty file; .* first 'schema: orbident/trajectory/1'"),
    "malformed": (HEAD + "joints: [1\n", r"traj\.yaml:3:1: no valid YAML"),
    "not text": (b"schema: \xff", "byte 8 is not UTF-8 text"),
    "joint twice": (
        swap("b: [2]}", "b: [2]}, j: {a: [1], b: [1]}"),
        "key 'j' is given twice",
    ),
    "schema": (swap("trajectory/1", "trajectory/2"), "schema: found 'orbident/traj"),
    "no schema": (SMALL.removeprefix(HEAD), "schema: this key is missing; add it"),
    "no joints": (HEAD + "duration: 1\n", "joints: this key is missing"),
    "unknown key": (SMALL + "rate: 3\n", "unknown key 'rate'; known keys: 'schema', "),
    "unknown inside": (
        swap("b: [2]", "b: [2], start: {positon: 1}"),
        r"joints\.j\.start: unknown key 'positon'; did you mean 'position'",
    ),
    "zero duration": (swap("duration: 2", "duration: 0"), "found 0; .* above zero"),
    "negative": (swap("duration: 2", "duration: -1"), "duration: found -1"),
    "nan duration": (swap("duration: 2", "duration: .nan"), "duration: found nan"),
    "text": (swap("duration: 2", "duration: long"), "duration: found 'long'; .*number"),
    "boolean": (
        swap("duration: 2", "duration: yes"),
        "'yes'; give a finite number",
    ),
    "infinite": (swap("a: [1]", "a: [.inf]"), r"joints\.j\.a\[0\]: found inf"),
    "lengths": (swap("a: [1]", "a: [1, 2]"), r"joints\.j: a has 2 and b has 1 entries"),
    "harmonics": (
        swap("a: [1], b: [2]", f"a: {[0] * 1001}, b: {[0] * 1001}"),
        r"joints\.j: has 1001 harmonics; give at most 1000",
    ),
    "joint list": (swap("{j: {a: [1], b: [2]}}", "[1]"), r"joints: found \[1\]"),
    "integer joint": (
        swap("{j:", "{7:"),
        r"joints\[7\]: found 7; give text, in",
    ),
    "short vector": (
        SMALL + "initial: {velocity: [0, 0]}\n",
        r"initial\.velocity: found \[0, 0\]; give a 3-vector",
    ),
    "long quaternion": (
        SMALL + "initial: {attitude: [0, 0, 0, 0, 1]}\n",
        r"initial\.attitude: .*give a 4-vector",
    ),
    "boolean in a vector": (
        SMALL + "initial: {velocity: [0, 0, no]}\n",
        "give a 3-vector of finite numbers",
    ),
    "norm": (
        SMALL + "initial: {attitude: [0, 0, 0, 2]}\n",
        r"initial\.attitude: .*norm 2; give a unit",
    ),
    "two faults": (
        swap("duration: 2", "duration: 0").replace("[1]", "[x]"),
        r"duration: found 0; give a number above zero \(and 1 more\)",
    ),
}


@pytest.mark.parametrize(("text", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_refusals(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "traj.yaml"))
    assert "\n" not in str(caught.value)


def test_places_refused(tmp_path):
    trajectory = load(tmp_path, SMALL)
    with pytest.raises(InputError, match="no such file"):
        load_trajectory(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="is a folder; give a file"):
        load_trajectory(tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        save_trajectory(trajectory, tmp_path / "nowhere" / "traj.yaml")
    with pytest.raises(InputError, match="is a folder"):
        save_trajectory(trajectory, tmp_path)


@pytest.mark.parametrize("path", [".", "/", ""])
def test_a_folder_is_no_trajectory_file(path: str):
    with pytest.raises(InputError, match="is a folder; give"):
        load_experiment(Path(path))
    with pytest.raises(InputError, match="is a folder; give the name"):
        numbered(Path(path), 2)
