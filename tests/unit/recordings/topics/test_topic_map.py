"""What a topic map may say, and how it is refused."""

from pathlib import Path

import pytest
from conversions import HEAD, refusal

from orbident.errors import InputError
from orbident.recordings.topics.topic_map import load_topic_map

JOINTS = "{topic: /js, type: sensor_msgs/JointState, "
IMU = "{topic: /imu, type: sensor_msgs/Imu, "
POSE = "{topic: /p, type: geometry_msgs/PoseStamped, "
ODOMETRY = "{topic: /o, type: nav_msgs/Odometry, "
TF = "{topic: /tf, type: tf2_msgs/TFMessage, "
FLOAT = "{topic: /f, type: std_msgs/Float64, "
WRENCH = "{topic: /w, type: geometry_msgs/WrenchStamped, "
BASE = "frame: base}"

REFUSED = {
    "unknown type": (
        "{topic: /c, type: sensor_msgs/Image}",
        "'sensor_msgs/Image' cannot be mapped without 'fields'; did you mean "
        "'sensor_msgs/Imu'? known types: 'sensor_msgs/JointState'",
    ),
    "no type": ("{topic: /c}", "type: this key is missing; add it"),
    "no topic": ("{type: sensor_msgs/Imu, take: {gyro: rad/s}}", "topic: this key"),
    "unknown key": (
        IMU + "take: {gyro: rad/s}, frames: base}",
        "unknown key 'frames'; did you mean 'frame'?",
    ),
    "unknown signal": (IMU + "take: {gyros: rad/s}, " + BASE, "unknown key 'gyros'"),
    "nothing taken": (IMU + "take: {}, " + BASE, "nothing is taken"),
    "take missing": (IMU + BASE, "take: this key is missing"),
    "wrong unit": (
        IMU + "take: {gyro: deg}, " + BASE,
        "take.gyro: found 'deg'; declare the messages' unit: rad/s, mrad/s, deg/s",
    ),
    "no unit": (POSE + "take: {position: true}}", "found True; declare"),
    "no frame": (
        IMU + "take: {gyro: rad/s}}",
        "neither of frame and rotation given for gyro",
    ),
    "two frames": (
        IMU + "take: {gyro: rad/s}, rotation: [0, 0, 0, 1], " + BASE,
        "both of frame and rotation",
    ),
    "another frame": (
        IMU + "take: {gyro: rad/s}, frame: imu_link}",
        "frame: found 'imu_link'; give 'base'",
    ),
    "no unit quaternion": (
        IMU + "take: {gyro: rad/s}, rotation: [0, 0, 1, 1]}",
        "its norm is 1.414; give a unit quaternion, scalar last",
    ),
    "no point": (
        IMU + "take: {accelerometer: g}, " + BASE,
        "point missing for accelerometer; give 'point: S'",
    ),
    "no direction": (POSE + "take: {position: m}, point: S}", "pose: this key is"),
    "another direction": (
        POSE + "take: {position: m}, point: S, pose: forwards}",
        "pose: found 'forwards'; give 'base-in-inertial' or 'inertial-in-base'",
    ),
    "no child": (
        TF + "take: {position: m}, point: S, pose: base-in-inertial, parent: w}",
        "child: this key is missing",
    ),
    "no twist": (
        ODOMETRY + "take: {velocity: m/s}, point: S}",
        "twist missing; give 'twist: child'",
    ),
    "no names": (JOINTS + "take: {position: rad}}", "joints and wheels missing"),
    "no joint": (
        JOINTS + "take: {position: rad}, joints: {a: }}",
        "joints.a: found nothing",
    ),
    "units of two kinds": (
        JOINTS + "take: {position: m, velocity: rad/s}, joints: {a: b}}",
        "m and rad/s are not of one kind of joint",
    ),
    "a wheel in metres": (
        JOINTS + "take: {velocity: m/s}, wheels: {a: b}}",
        "wheels cannot be in units of length",
    ),
    "the torque of a wheel": (
        JOINTS + "take: {effort: N m}, wheels: {a: b}}",
        "efforts are torques or currents of joints; give wheels an entry",
    ),
    "two numbers of one": (
        FLOAT + "take: {gyro.x: rad/s, gyro.y: rad/s}, " + BASE,
        "take names 2 columns; a Float64 feeds one",
    ),
    "no such column": (FLOAT + "take: {speed: rad/s}}", "give a column that numbers"),
    "a misspelt column": (
        FLOAT + "take: {wheel.a.sped: rad/s}}",
        "take: found 'wheel.a.sped'; did you mean 'wheel.a.speed'?",
    ),
    "a quaternion's part": (FLOAT + "take: {attitude.x: rad}}", "give a column that"),
    "another dimension": (
        FLOAT + "take: {wheel.a.speed: m/s}}",
        "take: wheel.a.speed: found 'm/s'; declare the messages' unit: rad/s",
    ),
    "a number's frame": (FLOAT + "take: {gyro.z: deg/s}}", "neither of frame and"),
    "a number's point": (
        FLOAT + "take: {torque.z: N m}, " + BASE,
        "point missing for torque; give 'point: S'",
    ),
    "a number's header": (
        FLOAT + "take: {wheel.a.speed: rpm}, time: header}",
        "std_msgs have no header",
    ),
    "a column twice": (
        WRENCH
        + "take: {force: N}, frame: base}\n  - "
        + WRENCH.replace("/w", "/v")
        + "take: {force: N}, frame: base}",
        "column 'force.x' is fed twice, by '/w' and '/v'; keep one",
    ),
    "a joint twice": (
        JOINTS + "take: {position: rad}, joints: {a: j, b: j}}",
        "column 'joint.j.position' is fed twice",
    ),
    "another clock": (
        IMU + "take: {gyro: rad/s}, time: sender, " + BASE,
        "time: found 'sender'; give 'header' or 'receive'",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(tmp_path: Path, case: str):
    entry, words = REFUSED[case]
    assert words in refusal(tmp_path, entry)


WHOLE = {
    "another schema": ("schema: orbident/robot/1\ntopics: []\n", "schema: found"),
    "no topics": ("schema: orbident/topic-map/1\ntopics: []\n", "topics: found []"),
    "topics as keys": (
        "schema: orbident/topic-map/1\ntopics: {/imu: 3}\n",
        "topics: found {'/imu': 3}; give a list",
    ),
    "empty": ("", "found an empty file"),
    "no YAML": ("schema: [", "no valid YAML"),
}


@pytest.mark.parametrize("case", WHOLE)
def test_no_map(tmp_path: Path, case: str):
    text, words = WHOLE[case]
    path = tmp_path / "map.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as raised:
        load_topic_map(path)
    assert words in str(raised.value)


def test_the_entry_is_named(tmp_path: Path):
    path = tmp_path / "map.yaml"
    path.write_text(HEAD + f"  - {WRENCH}take: {{force: N}}, {BASE}\n  - {IMU}{BASE}\n")
    with pytest.raises(InputError) as raised:
        load_topic_map(path)
    assert str(raised.value) == (
        f"{path}:4: topics[1].take: this key is missing; add it"
    )


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("gyro: m/s", ":5: topics[0].take.gyro: found 'm/s'"),
        ("giro: rad/s", ":5: topics[0].take: unknown key 'giro'"),
    ],
)
def test_the_line_is_named(tmp_path: Path, written: str, words: str):
    path = tmp_path / "map.yaml"
    path.write_text(
        f"{HEAD}  - topic: /imu\n    type: sensor_msgs/Imu\n    take: {{{written}}}\n"
        "    frame: base\n"
    )
    with pytest.raises(InputError) as raised:
        load_topic_map(path)
    assert str(raised.value).startswith(f"{path}{words}")


def test_columns(tmp_path: Path):
    path = tmp_path / "map.yaml"
    path.write_text(
        HEAD + f"  - {JOINTS}take: {{velocity: rpm}}, joints: {{a: b}}, "
        "wheels: {c: d}}\n"
    )
    (entry,) = load_topic_map(path)
    assert entry.columns == ("joint.b.velocity", "wheel.d.speed")
    assert entry.wanted == {"a", "c"}
