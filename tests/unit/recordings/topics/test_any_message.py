"""Messages of a laboratory's own types, and what a survey tells of clocks and units."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from bag_writers import (
    KINDS,
    START,
    Sent,
    header,
    imu,
    joint_state,
    pose,
    pose_fields,
    write_bag,
)
from conversions import HEAD, cells, converted

from orbident.errors import InputError
from orbident.recordings.topics.convert import convert_file
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import load_topic_map, proposed_map
from orbident.robot.robot_file import load_robot

MS = 1_000_000
ENTRIES = """\
  - topic: /bodies
    type: lab_msgs/Bodies
    take: {position: mm, attitude: quaternion}
    fields:
      position: bodies.chaser.pose.position
      attitude: bodies.chaser.pose.orientation
    frame: base
    point: S
  - topic: /arm
    type: lab_msgs/msg/Arm
    stamp: {timestamp: us}
    offset: 3.2
    take: {joint.joint1.position: deg, joint.joint2.position: rad, gyro: deg/s}
    fields:
      joint.joint1.position: -q.1
      joint.joint2.position: 2 * q.0 + 1
      gyro: rate
    frame: base
  - topic: /array
    type: std_msgs/Float64MultiArray
    take: {wheel.rw.speed: rpm}
    fields: {wheel.rw.speed: data.2}
"""
DRAW = np.random.default_rng(4)
P, Q, RATE, DATA = (DRAW.normal(size=(30, n)) for n in (3, 2, 3, 3))
X = DRAW.normal(size=(30, 4))
X /= np.linalg.norm(X, axis=1)[:, None]


def messages() -> list[Sent]:
    """Two robots in a message, in either order; a counter 3.2 s behind; no stamp."""
    sent = []
    for k in range(30):
        t = START + 10 * MS * k
        bodies = [
            {"name": "target", "pose": pose_fields(X[0], P[0]), "seen": True},
            {"name": "chaser", "pose": pose_fields(X[k], P[k]), "seen": True},
        ]
        fields = {"header": header(t), "bodies": bodies[:: 1 if k % 3 else -1]}
        sent.append(Sent("/bodies", "lab_msgs/Bodies", t + MS, fields))
        arm = {
            "timestamp": (t - 3200 * MS) // 1000,
            "rate": np.float32(RATE[k]),
            "q": Q[k] if k else Q[k, :1],
            "state": "tracking",
        }
        sent.append(Sent("/arm", "lab_msgs/Arm", t + MS, arm))
        layout = {"layout": {"dim": [], "data_offset": 0}, "data": DATA[k]}
        sent.append(Sent("/array", "std_msgs/Float64MultiArray", t, layout))
    return sent


@pytest.mark.parametrize("kind", KINDS)
def test_every_cell(tmp_path: Path, kind: str):
    found, report = converted(tmp_path, messages(), ENTRIES, kind)
    np.testing.assert_allclose(found.t, 0.01 * np.arange(30), rtol=0, atol=1e-12)
    # What is left are roundings of products of float64, and of float32 for the rate.
    np.testing.assert_allclose(found.vector("position"), P / 1000, rtol=1e-15)
    np.testing.assert_allclose(found.vector("attitude", "xyzw"), X, rtol=1e-15)
    rate = np.radians(np.float32(RATE).astype(float))
    np.testing.assert_allclose(found.vector("gyro"), rate, rtol=1e-15)
    joint1 = np.radians(-Q[:, 1])
    # The first message has one joint only.
    joint1[0] = np.nan
    np.testing.assert_allclose(found.column("joint.joint1.position"), joint1, 1e-15)
    joint2 = 2 * Q[:, 0] + 1
    np.testing.assert_allclose(found.column("joint.joint2.position"), joint2, 1e-15)
    speed = DATA[:, 2] * np.pi / 30
    np.testing.assert_allclose(found.column("wheel.rw.speed"), speed, 1e-15)
    assert [topic.time for topic in report.topics] == ["header", "stamp", "receive"]
    assert report.topics[1].not_finite == 1


def test_an_offset_moves_every_kind_of_time(tmp_path: Path):
    sent = [imu("/imu", START + 5 * MS * k, START + 5 * MS * k) for k in range(4)]
    sent += [Sent("/f", "std_msgs/Float64", START, {"data": 1.0})]
    for time in ("header", "receive"):
        keys = f"take: {{gyro: rad/s}}, frame: base, time: {time}, offset: 1e-3"
        entries = (
            f"  - {{topic: /imu, type: sensor_msgs/Imu, {keys}}}\n"
            "  - {topic: /f, type: std_msgs/Float64, take: {wheel.a.speed: rpm}, "
            "offset: -1}\n"
        )
        found, report = converted(tmp_path, sent, entries)
        assert report.start_ns == START - 10**9
        assert cells(found, "gyro", "xyz").shape == (4, 3)
        assert found.t[1] == pytest.approx(1.001, abs=1e-12)


def test_clocks_that_were_never_set_together(tmp_path: Path):
    """The offset that the warning gives puts them right."""
    sent = []
    for k in range(20):
        t = START + 10 * MS * k
        sent.append(imu("/imu", t + MS, t - 3200 * MS))
        sent.append(pose("/pose", t + 4 * MS, t, [0, 0, 0, 1], [k, 0, 0]))
    entries = """\
  - {topic: /imu, type: sensor_msgs/Imu, take: {gyro: rad/s}, frame: base%s}
  - topic: /pose
    type: geometry_msgs/PoseStamped
    take: {position: mm}
    pose: base-in-inertial
    point: S
"""
    _, report = converted(tmp_path, sent, entries % "")
    (said,) = report.warnings[-1:]
    # 3.2 s, less 1 ms by which it is recorded sooner after it was sent.
    words = "the clock of '/imu' is 3.197 s behind that of '/pose', by when the"
    assert said.startswith(words)
    assert "'offset: 3.197'" in said
    found, report = converted(tmp_path, sent, entries % ", offset: 3.197")
    assert report.warnings == ()
    assert found.t[-1] == pytest.approx(0.193, abs=1e-9)


def test_fields_that_have_the_names_of_others(tmp_path: Path):
    """A header that is text, transforms that are numbers, a name that is one."""
    fields = {"header": "x", "transforms": np.array([1.0, 2.0]), "name": 3.0}
    sent = [Sent("/odd", "lab_msgs/Odd", START + k, fields) for k in (0, 10**6)]
    (found,) = survey_file(write_bag("mcap-ros2", tmp_path, sent, "odd"))
    assert list(found.ranges) == ["transforms.0", "transforms.1", "name"]
    assert found.offset is None
    entry = (
        "  - {topic: /odd, type: lab_msgs/Odd, take: {joint.a.position: rad}, "
        "fields: {joint.a.position: transforms.1}}\n"
    )
    recording, report = converted(tmp_path, sent, entry)
    np.testing.assert_array_equal(recording.column("joint.a.position"), [2, 2])
    assert report.topics[0].time == "receive"


WRONG = {
    "another field": (
        "qq.0",
        "topic '/arm': 'qq.0' is no number of its messages; did you mean 'q.0'? known "
        "fields: 'timestamp', 'rate.0', 'rate.1', 'rate.2', 'q.0'",
    ),
    "text": ("state", "'state' is no number of its messages"),
    "an array": ("rate", "'rate' is no number of its messages; did you mean 'rate."),
    "a part of a number": ("timestamp.x", "'timestamp.x' is no number"),
    "an element that never comes": (
        "q.7",
        "'joint.a.position' never has a finite number; 'q.7': there is no '7'; known",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_refused(tmp_path: Path, case: str):
    field, words = WRONG[case]
    entry = (
        "  - {topic: /arm, type: lab_msgs/Arm, take: {joint.a.position: rad}, "
        f"fields: {{joint.a.position: {field}}}}}\n"
    )
    with pytest.raises(InputError) as raised:
        converted(tmp_path, messages(), entry)
    assert words in str(raised.value)


def test_an_element_whose_name_is_misspelt(tmp_path: Path):
    entries = ENTRIES.replace("bodies.chaser.pose.pos", "bodies.chasr.pose.pos")
    with pytest.raises(InputError) as raised:
        converted(tmp_path, messages(), entries)
    assert (
        "topic '/bodies': column 'position.x' never has a finite number; "
        "'bodies.chasr.pose.position.0': there is no 'chasr'; did you mean 'chaser'?"
    ) in str(raised.value)


def test_a_bag_without_definitions(tmp_path: Path):
    """ROS 2 before Jazzy wrote none into its SQLite files."""
    bag = write_bag("ros2-sqlite3", tmp_path, messages())
    with sqlite3.connect(bag / f"{bag.name}.db3") as file:
        file.execute("DELETE FROM message_definitions")
    proposal = proposed_map(survey_file(bag))
    assert "# /arm (lab_msgs/Arm) cannot be mapped" in proposal
    entry = "{topic: /arm, type: lab_msgs/Arm, take: {joint.a.position: rad}, "
    path = tmp_path / "map.yaml"
    path.write_text(f"{HEAD}  - {entry}fields: {{joint.a.position: q.0}}}}\n")
    with pytest.raises(InputError, match="has no definition of lab_msgs/Arm; record"):
        convert_file(bag, path, tmp_path / "r.csv")


def test_the_proposal_lists_what_messages_hold(tmp_path: Path):
    bag = write_bag("mcap-ros2", tmp_path, messages())
    proposal = proposed_map(survey_file(bag), load_robot("cepheus-like"))
    assert "type: lab_msgs/Arm\n    # TODO stamp: {<the field" in proposal
    assert "bodies.chaser.pose.position.x -" in proposal
    assert "# cepheus-like has joints joint1, joint2; wheels rw" in proposal
    for topic in ("/bodies", "/arm", "/array"):
        assert f"  - topic: {topic}\n" in proposal
    path = tmp_path / "map.yaml"
    path.write_text(proposal)
    words = "type: 'lab_msgs/Arm' cannot be mapped without 'fields'"
    with pytest.raises(InputError, match=words):
        load_topic_map(path)


def test_clocks_ranges_and_names(tmp_path: Path):
    """A sender 3.2 s behind whose clock runs 50 ppm fast, received 2 to 3 ms late."""
    late = np.random.default_rng(2).uniform(2, 3, 2000)
    sent = []
    for k, delay in enumerate(late):
        t = START + 10 * MS * k
        received = t + int(delay * MS)
        stamp = t - 3200 * MS + 50 * 10 * MS * k // 10**6
        q, speed = [90 * np.sin(k / 300), k, 0], [1.0, 700.0, 0]
        names = ["joint1", "rw", "lid"]
        sent.append(joint_state("/js", received, stamp, names, q, speed))
        p = [1500 * np.cos(k / 300), 0, 0]
        sent.append(pose("/pose", received, t, [0, 0, 0, 1], p))
        sent.append(imu("/imu", received, t, [0, 0, 0.5], [0, 0, 9.81]))
    surveyed = survey_file(write_bag("ros1", tmp_path, sent))
    by_name = {each.topic.name: each for each in surveyed}
    # Delays differ by half a millisecond; in 20 s their medians move by some us.
    assert by_name["/js"].offset == pytest.approx(-3.2025, abs=1e-3)
    assert by_name["/js"].drift == pytest.approx(50e-6, abs=20e-6)
    assert by_name["/pose"].offset == pytest.approx(-0.0025, abs=5e-4)
    assert by_name["/pose"].drift == pytest.approx(0, abs=20e-6)
    assert by_name["/pose"].ranges["pose.position.x"][1] == 1500
    proposal = proposed_map(surveyed, load_robot("cepheus-like"))
    assert "position -1500 to 1500 (mm?)" in proposal
    assert "attitude 0 to 1\n" in proposal
    assert "gyro 0 to 0.5\n" in proposal
    assert "    joints:  # name in the messages: name in the robot\n" in proposal
    assert "      joint1: joint1  # position -89.99 to 90 (deg?)" in proposal
    assert "      rw: rw  # position 0 to 1990" in proposal
    assert (
        "# TODO joints or wheels: {lid: <the robot's name>}  # position 0 to 0"
        in proposal
    )
