"""Every cell of a converted bag against what was written."""

import random
import re
from math import nan

import numpy as np
import pytest
from bag_writers import KINDS, START, Sent, float64, imu, joint_state, pose, write_bag
from conversions import HEAD, cells, converted
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.recordings.topics.convert import convert_file

MS = 1_000_000

ENTRIES = """\
  - topic: /joint_states
    type: sensor_msgs/JointState
    take: {position: deg, velocity: deg/s}
    joints: {shoulder: joint1, elbow: joint2}
    clock: arm
  - topic: /joint_states
    type: sensor_msgs/JointState
    take: {velocity: rpm}
    wheels: {rotor: rw_x}
    clock: arm
  - topic: /imu/data
    type: sensor_msgs/msg/Imu
    take: {gyro: rad/s, accelerometer: g}
    frame: base
    point: S
    clock: imu
  - topic: /body/pose
    type: geometry_msgs/PoseStamped
    take: {position: mm, attitude: quaternion}
    pose: base-in-inertial
    frame: base
    point: S
  - topic: /valve
    type: std_msgs/Float64
    take: {torque.z: mN m}
    frame: base
    point: S
"""


def messages(count: int = 60) -> list[Sent]:
    """Four topics; the IMU's clock is 37 ms ahead of the others'."""
    draw = np.random.default_rng(1)
    sent = []
    for k in range(count):
        stamp = START + 10 * MS * k
        received = stamp + 2 * MS
        names = ["elbow", "gripper", "rotor", "shoulder"]
        position, velocity = draw.normal(size=4), draw.normal(size=4)
        sent.append(
            joint_state("/joint_states", received, stamp, names, position, velocity)
        )
        w, f = draw.normal(size=3), draw.normal(size=3)
        sent.append(imu("/imu/data", received, stamp + 37 * MS, w, f))
        if k % 3 == 0:
            x = Rotation.random(rng=draw).as_quat()
            sent.append(pose("/body/pose", received, stamp, x, draw.normal(size=3)))
        if k % 5 == 0:
            sent.append(float64("/valve", received, draw.normal()))
    return sent


def stamp_of(sent: Sent) -> int:
    """ns; a Float64 has none but when it was recorded."""
    if "header" not in sent.fields:
        return sent.received
    stamp = sent.fields["header"]["stamp"]
    return stamp["sec"] * 10**9 + stamp["nanosec"]


def expected(sent: list[Sent]) -> dict[int, dict[str, float]]:
    """Cells by stamp and column, one message and one number at a time."""
    rows: dict[int, dict[str, float]] = {}
    of = {
        "/joint_states": of_joints,
        "/imu/data": of_imu,
        "/body/pose": of_pose,
        "/valve": lambda fields: {"torque.z": fields["data"] * 1e-3},
    }
    for each in sent:
        rows.setdefault(stamp_of(each), {}).update(of[each.topic](each.fields))
    return rows


def of_joints(fields):
    row, deg, at = {}, np.pi / 180, fields["name"].index
    for name, joint in (("shoulder", "joint1"), ("elbow", "joint2")):
        row[f"joint.{joint}.position"] = fields["position"][at(name)] * deg
        row[f"joint.{joint}.velocity"] = fields["velocity"][at(name)] * deg
    row["wheel.rw_x.speed"] = fields["velocity"][at("rotor")] * 2 * np.pi / 60
    return row


def of_imu(fields):
    w, f = fields["angular_velocity"], fields["linear_acceleration"]
    gyro = {f"gyro.{k}": w[k] for k in "xyz"}
    return gyro | {f"accelerometer.{k}": f[k] * 9.80665 for k in "xyz"}


def of_pose(fields):
    x, p = fields["pose"]["orientation"], fields["pose"]["position"]
    attitude = {f"attitude.{k}": x[k] for k in "xyzw"}
    return attitude | {f"position.{k}": p[k] * 1e-3 for k in "xyz"}


def check_table(recording, table):
    stamps = sorted(table)
    # Nanoseconds from the first, exactly.
    np.testing.assert_array_equal(
        recording.t, [(stamp - stamps[0]) / 1e9 for stamp in stamps]
    )
    for name, column in recording.columns.items():
        wanted = [table[stamp].get(name, nan) for stamp in stamps]
        # One product with a unit and, for attitudes, a norm: 2 roundings each.
        np.testing.assert_allclose(column, wanted, rtol=1e-15, atol=0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_every_cell(tmp_path, kind, suffix):
    sent = messages()
    recording, report = converted(tmp_path, sent, ENTRIES, kind, suffix)
    check_table(recording, expected(sent))
    assert len(recording.columns) == 4 + 1 + 6 + 7 + 1
    assert report.start_ns == START
    assert [topic.used for topic in report.topics] == [60, 60, 60, 20, 12]
    assert [topic.clock for topic in report.topics[:3]] == ["arm", "arm", "imu"]
    assert [t.time for t in report.topics] == ["header"] * 4 + ["receive"]
    for topic in report.topics:
        assert topic.messages == topic.used
        assert not topic.sentences()


@pytest.mark.parametrize("kind", KINDS)
def test_shuffled_late_duplicated_missing_and_nan(tmp_path, kind):
    draw = random.Random(3)
    clean = messages()
    # Missing: every seventh.
    kept = [each for k, each in enumerate(clean) if k % 7]
    # A NaN burst of one sensor, 5 messages long.
    burst = [each for each in kept if each.topic == "/imu/data"][10:15]
    for each in burst:
        each.fields["angular_velocity"]["y"] = nan
    wanted = expected(kept)
    # Written again later with the same stamp; two of them altered.
    again = [each for each in kept if each.topic == "/body/pose"][:6]
    changed = [
        each._replace(fields=pose("", 0, START, [0, 0, 0, 1], [9, 9, 9]).fields)
        for each in again[:2]
    ]
    for each, old in zip(changed, again, strict=False):
        each.fields["header"].update(old.fields["header"])
    # Shuffled: the order in the file is that of recording.
    order = list(range(len(kept)))
    draw.shuffle(order)
    shuffled = [
        kept[k]._replace(received=START + 900 * MS + n * MS)
        if kept[k].topic != "/valve"
        else kept[k]
        for n, k in enumerate(order)
    ]
    late = [
        each._replace(received=START + 5000 * MS + n)
        for n, each in enumerate([*changed, *again[2:]])
    ]
    sent = sorted([*shuffled, *late], key=lambda each: each.received)
    recording, report = converted(tmp_path, sent, ENTRIES, kind)
    check_table(recording, wanted)
    by_topic = {topic.topic: topic for topic in report.topics}
    imus = [each for each in kept if each.topic == "/imu/data"]
    assert by_topic["/imu/data"].not_finite == len(burst)
    assert by_topic["/imu/data"].used == len(imus)
    assert by_topic["/imu/data"].out_of_order == late_count(shuffled, "/imu/data")
    poses = by_topic["/body/pose"]
    assert poses.rejected == {"duplicate": 6, "without_stamp": 0, "undecodable": 0}
    assert poses.duplicate_differs == 2
    assert poses.messages == poses.used + 6


def late_count(sent: list[Sent], topic: str) -> int:
    """Messages whose stamp is before one that came earlier."""
    count, latest = 0, 0
    for each in sorted(sent, key=lambda each: each.received):
        if each.topic == topic:
            stamp = stamp_of(each)
            count += stamp < latest
            latest = max(latest, stamp)
    return count


WHEEL = """\
  - topic: /imu
    type: sensor_msgs/Imu
    take: {gyro: rad/s}
    frame: base
"""


def test_stamps_within_100_ns_share_a_row(tmp_path):
    entries = WHEEL + WHEEL.replace("/imu", "/valve").replace(
        "sensor_msgs/Imu", "std_msgs/Float64"
    ).replace("gyro: rad/s", "force.x: N")
    sent = [imu("/imu", START + k * MS, START + k * MS, [k, 0, 0]) for k in range(4)]
    sent += [float64("/valve", START + k * MS + 90, k) for k in range(4)]
    recording, _ = converted(tmp_path, sent, entries)
    np.testing.assert_array_equal(recording.t, [0, 1e-3, 2e-3, 3e-3])
    np.testing.assert_array_equal(recording.column("force.x"), [0, 1, 2, 3])
    (tmp_path / "apart").mkdir()
    sent = [s._replace(received=s.received + 20 * (s.topic == "/valve")) for s in sent]
    recording, _ = converted(tmp_path / "apart", sent, entries)
    assert recording.t.size == 8


def test_headers_that_are_never_set(tmp_path):
    sent = [imu("/imu", START + k * MS, 0, [k, 0, 0]) for k in range(5)]
    recording, report = converted(tmp_path, sent, WHEEL)
    np.testing.assert_array_equal(recording.t, np.arange(5) / 1e3)
    assert report.topics[0].time == "receive"
    assert report.topics[0].sentences() == [
        "/imu: no header stamp is set, so the time is when it was recorded"
    ]


def test_headers_that_are_not_set_at_first_are_rejected(tmp_path):
    stamps = [0, 0, *(START + k * MS for k in range(2, 6))]
    sent = [imu("/imu", START + k * MS, s, [k, 0, 0]) for k, s in enumerate(stamps)]
    recording, report = converted(tmp_path, sent, WHEEL)
    np.testing.assert_array_equal(recording.column("gyro.x"), [2, 3, 4, 5])
    assert report.topics[0].rejected["without_stamp"] == 2


def test_the_map_can_ask_for_the_time_of_recording(tmp_path):
    sent = [imu("/imu", START + k * MS, START + 7, [k, 0, 0]) for k in range(5)]
    recording, report = converted(tmp_path, sent, WHEEL + "    time: receive\n")
    np.testing.assert_array_equal(recording.t, np.arange(5) / 1e3)
    assert report.topics[0].sentences() == []


def test_joints_that_come_in_separate_messages(tmp_path):
    sent = []
    for k in range(6):
        stamp = START + k * MS
        names = ["arm"] if k % 2 else ["rotor", "arm2"]
        sent.append(joint_state("/js", stamp, stamp, names, [k, k + 0.5][: len(names)]))
    entries = """\
  - topic: /js
    type: sensor_msgs/JointState
    take: {position: rad}
    joints: {arm: joint1}
    wheels: {rotor: rw}
"""
    recording, report = converted(tmp_path, sent, entries)
    odd = [nan, 1, nan, 3, nan, 5]
    np.testing.assert_array_equal(recording.column("joint.joint1.position"), odd)
    even = [0, nan, 2, nan, 4, nan]
    np.testing.assert_array_equal(recording.column("wheel.rw.position"), even)
    # Each message lacks one of the two names; none has a NaN.
    assert (report.topics[0].incomplete, report.topics[0].not_finite) == (6, 0)


def test_efforts_are_torques_of_joints(tmp_path):
    sent = []
    for k in range(4):
        stamp, names = START + k * MS, ["elbow", "shoulder"]
        sent.append(joint_state("/js", stamp, stamp, names, [0, k], [], [k, 10 * k]))
    entries = """\
  - topic: /js
    type: sensor_msgs/JointState
    take: {position: rad, effort: mN m}
    joints: {shoulder: joint1, elbow: joint2}
"""
    recording, _ = converted(tmp_path, sent, entries)
    k = np.arange(4)
    np.testing.assert_allclose(recording.column("joint.joint1.torque"), 0.01 * k)
    np.testing.assert_allclose(recording.column("joint.joint2.torque"), 1e-3 * k)
    np.testing.assert_array_equal(recording.column("joint.joint1.position"), k)


def test_efforts_may_be_currents_of_motors(tmp_path):
    sent = []
    for k in range(4):
        stamp = START + k * MS
        sent.append(joint_state("/js", stamp, stamp, ["elbow"], [k], [], [10 * k]))
        sent.append(float64("/motor", stamp, k))
    entries = """\
  - topic: /js
    type: sensor_msgs/JointState
    take: {position: rad, effort: mA}
    joints: {elbow: joint2}
  - topic: /motor
    type: std_msgs/Float64
    take: {joint.joint1.current: A}
"""
    recording, _ = converted(tmp_path, sent, entries)
    k = np.arange(4)
    np.testing.assert_allclose(recording.column("joint.joint2.current"), 0.01 * k)
    assert not recording.has("joint.joint2.torque")
    shown = recording.column("joint.joint1.current")
    np.testing.assert_array_equal(shown[np.isfinite(shown)], k)


def test_clocks_without_a_common_time_are_pointed_out(tmp_path):
    second = WHEEL.replace("/imu", "/pose").replace(
        "sensor_msgs/Imu", "std_msgs/Float64"
    )
    second = second.replace("gyro: rad/s", "force.x: N")
    sent = [imu("/imu", START + k * MS, (1 + k) * MS, [k, 0, 0]) for k in range(4)]
    sent += [float64("/pose", START + k * MS, k) for k in range(4)]
    _, report = converted(tmp_path, sent, WHEEL + second)
    assert len(report.warnings) == 1
    assert "'/imu' ends 1.7e+09 s before '/pose' begins" in report.warnings[0]


def test_no_number_that_is_not_finite_is_written(tmp_path):
    values = [0, np.inf, 2, -np.inf, 4]
    sent = [float64("/v", START + k * MS, v) for k, v in enumerate(values)]
    entries = "  - {topic: /v, type: std_msgs/Float64, take: {wheel.w.speed: rad/s}}\n"
    recording, report = converted(tmp_path, sent, entries)
    np.testing.assert_array_equal(
        recording.column("wheel.w.speed"), [0, nan, 2, nan, 4]
    )
    assert report.topics[0].not_finite == 2


def test_nothing_is_left_beside_the_recording(tmp_path):
    sent = [imu("/imu", START, START), imu("/imu", START + 1, START)]
    with pytest.raises(InputError, match="single sample"):
        converted(tmp_path, sent, WHEEL)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "flight.mcap",
        "map.yaml",
    ]


@pytest.mark.slow
def test_many_blocks_of_rows(tmp_path):
    # More than a block of the table and than a batch of a track, in reverse.
    count = 40_000
    sent = [float64("/v", START + 1000 * (count - k), count - k) for k in range(count)]
    entries = "  - {topic: /v, type: std_msgs/Float64, take: {wheel.w.speed: rad/s}}\n"
    recording, report = converted(tmp_path, sent, entries)
    np.testing.assert_array_equal(
        recording.column("wheel.w.speed"), np.arange(1, count + 1)
    )
    assert report.topics[0].out_of_order in {0, count - 1}


def test_unit_quaternions_are_needed_only_where_they_are_used(tmp_path):
    sent = [
        imu("/imu", START + k * MS, START + k * MS, [k, 0, 0], attitude=[0, 0, 0, 0])
        for k in range(300)
    ]
    recording, _ = converted(tmp_path, sent, WHEEL)
    assert cells(recording, "gyro", "xyz").shape == (300, 3)
    entry = WHEEL.replace("{gyro: rad/s}", "{attitude: quaternion}")
    with pytest.raises(InputError) as raised:
        converted(tmp_path, sent, entry)
    assert "topic '/imu': all 300 quaternions are zero, as of" in str(raised.value)


def test_a_bag_that_counts_more_messages_than_a_number_holds(tmp_path):
    """Counts in its metadata are for progress alone."""
    bag = write_bag("ros2-mcap", tmp_path, messages(20))
    about = bag / "metadata.yaml"
    many = re.sub(r"message_count: \d+", f"message_count: {10**400}", about.read_text())
    about.write_text(many)
    (tmp_path / "map.yaml").write_text(HEAD + ENTRIES)
    report = convert_file(bag, tmp_path / "map.yaml", tmp_path / "recording.csv")
    assert report.topics[0].messages == 20
