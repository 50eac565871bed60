"""A bag is converted to a recording and identified, by the command."""

import sys
from pathlib import Path

import numpy as np
import pytest
from bag_writers import KINDS, START, Sent, float64, imu, joint_state, pose, write_bag
from processes import finished
from running import LINEAR, Orbident, check_recovered

from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording

MAP = """\
schema: orbident/topic-map/1
topics:
  - topic: /joint_states
    type: sensor_msgs/JointState
    take: {position: rad, velocity: rad/s}
    joints: {shoulder: joint1, elbow: joint2, wrist: joint3}
  - topic: /wheel_x
    type: std_msgs/Float64
    take: {wheel.rw_x.speed: rad/s}
  - topic: /wheel_y
    type: std_msgs/Float64
    take: {wheel.rw_y.speed: rad/s}
  - topic: /wheel_z
    type: std_msgs/Float64
    take: {wheel.rw_z.speed: rad/s}
  - topic: /imu
    type: sensor_msgs/Imu
    take: {gyro: rad/s}
    frame: base
    clock: imu
  - topic: /mocap
    type: geometry_msgs/PoseStamped
    take: {position: m, attitude: quaternion}
    pose: base-in-inertial
    frame: base
    point: S
"""


def as_messages(flight: Recording) -> list[Sent]:
    """A recording as a bag has it: each sensor's message for every sample."""
    sent = []
    joints = ("joint1", "joint2", "joint3")
    q, q_dot = (
        np.column_stack([flight.column(f"joint.{name}.{what}") for name in joints])
        for what in ("position", "velocity")
    )
    w, x, p = (
        flight.vector("gyro"),
        flight.vector("attitude", "xyzw"),
        flight.vector("position"),
    )
    names = ["shoulder", "elbow", "wrist"]
    for k, t in enumerate(flight.t):
        ns = START + round(t * 1e9)
        sent.append(joint_state("/joint_states", ns + 5, ns, names, q[k], q_dot[k]))
        sent.append(imu("/imu", ns + 6, ns, w[k]))
        sent.append(pose("/mocap", ns + 7, ns, x[k], p[k]))
        for axis in "xyz":
            speed = flight.column(f"wheel.rw_{axis}.speed")[k]
            sent.append(float64(f"/wheel_{axis}", ns, speed))
    return sent


@pytest.mark.parametrize("kind", KINDS)
def test_bag_to_parameters(orbident: Orbident, flight: Recording, kind: str):
    bag = write_bag(kind, Path(), as_messages(flight))
    Path("map.yaml").write_text(MAP)
    ran = orbident(
        "convert", bag, "--map", "map.yaml", "-o", "r.parquet", "--json", "-"
    )
    report = ran.done().json
    assert report["samples"] == flight.t.size
    assert report["start_ns"] == START
    assert [each["used"] for each in report["topics"]] == [flight.t.size] * 6
    recording = read_recording("r.parquet")
    for name, column in recording.columns.items():
        # Attitudes are divided by their norm, which is one up to its rounding.
        np.testing.assert_allclose(column, flight.columns[name], rtol=1e-15, atol=1e-15)
    # Times went through nanoseconds: 40 s at 20 Hz are whole ones.
    np.testing.assert_allclose(recording.t, flight.t, rtol=0, atol=1e-9)


def test_the_recording_is_identified(orbident: Orbident, flight: Recording):
    bag = write_bag("ros2-mcap", Path(), as_messages(flight))
    Path("map.yaml").write_text(MAP)
    orbident("convert", bag, "--map", "map.yaml", "-o", "r.csv", "--quiet").done()
    ran = orbident("identify", "paper-spatial", "r.csv", *LINEAR, "--json", "-")
    result = ran.done().json
    inspected = orbident("inspect", "paper-spatial", "--json", "-").done().json
    # The velocity of S is derived from its positions, by a spline through 20 Hz.
    check_recovered(result, inspected, 1e-6)


def sent(count: int = 20) -> list[Sent]:
    stamps = [START + k * 10_000_000 for k in range(count)]
    return [imu("/imu", s, s, [k, 0, 0]) for k, s in enumerate(stamps)]


IMU = "  - {topic: /imu, type: sensor_msgs/Imu, take: {gyro: rad/s}, frame: base}\n"
HEAD = "schema: orbident/topic-map/1\ntopics:\n"


def test_what_is_said(orbident: Orbident):
    odd = [*sent(), sent()[3]._replace(received=START + 900_000_000)]
    odd[5].fields["angular_velocity"]["x"] = float("nan")
    bag = write_bag("ros1", Path(), odd)
    Path("map.yaml").write_text(HEAD + IMU)
    ran = orbident("convert", bag, "--map", "map.yaml", "-o", "r.csv", "--json", "j")
    lines = ran.done().out.splitlines()
    assert lines[0] == f"converted {bag}: 20 samples over 0.19 s"
    heads = " ".join(lines[1].split())
    assert heads == "topic messages used rate (Hz) from (s) to (s) time"
    assert " ".join(lines[2].split()) == "/imu 21 20 100 0.000 0.190 header"
    assert lines[3:] == [
        "/imu: 1 repeated a stamp, rejected (0 differ)",
        "/imu: 1 came late, sorted",
        "/imu: 1 held NaN or no number, left empty",
        "written: r.csv",
    ]
    again = ("convert", bag, "--map", "map.yaml", "-o", "r.csv", "--force", "--quiet")
    ran = orbident(*again)
    assert ran.done().out == ""


def test_topics_prints_a_map(orbident: Orbident):
    bag = write_bag("ros2-sqlite3", Path(), sent())
    ran = orbident("topics", bag).done()
    head, entry = ran.out.split("# Proposed by 'orbident topics'.")
    assert "# /imu   sensor_msgs/Imu        20        100" in head
    assert all(line.startswith("# ") for line in head.splitlines())
    assert "  - topic: /imu\n" in entry
    # It is a map as a whole, which asks for what nobody told.
    Path("map.yaml").write_text(ran.out)
    orbident("convert", bag, "--map", "map.yaml", "-o", "r.csv").refused(
        "topics[0]: neither of frame and rotation given"
    )
    ran = orbident("topics", bag, "-o", "m.yaml", "--json", "-").done()
    (imu,) = ran.json["topics"]
    assert imu.pop("ranges")["angular_velocity.x"] == [0, 19]
    assert imu == {
        "topic": "/imu",
        "type": "sensor_msgs/Imu",
        "messages": 20,
        "rate": pytest.approx(100, rel=1e-12),
        "names": [],
        "offset": 0,
        "drift": 0,
    }
    assert Path("m.yaml").read_text() == ran.json["map"]
    ran = orbident("topics", bag, "-o", "/dev/full")
    ran.refused("/dev/full: cannot be written")
    assert ran.out == ""


def test_topics_of_a_file_that_is_cut_off(orbident: Orbident):
    bag = write_bag("mcap-ros2", Path(), sent())
    bag.write_bytes(bag.read_bytes()[: bag.stat().st_size // 2])
    ran = orbident("topics", bag, "--json", "-")
    said = f"{bag}: is cut off: what is before is used"
    assert f"warning: {said}" in ran.err
    assert ran.json["warnings"][0].startswith(said)


REFUSED = {
    "no bag": ("gone.bag", HEAD + IMU, "r.csv", "gone.bag: does not exist"),
    "no map": ("flight.bag", None, "r.csv", "map.yaml: no such file"),
    "no topic": (
        "flight.bag",
        HEAD + IMU.replace("/imu", "/inu"),
        "r.csv",
        "has no topic '/inu'; did you mean '/imu'?",
    ),
    "unknown type": (
        "flight.bag",
        HEAD + "  - {topic: /imu, type: sensor_msgs/Image}\n",
        "r.csv",
        "'sensor_msgs/Image' cannot be mapped without",
    ),
    "a column twice": (
        "flight.bag",
        HEAD + IMU + IMU,
        "r.csv",
        "'gyro.x' is fed twice",
    ),
    "another suffix": (
        "flight.bag",
        HEAD + IMU,
        "r.txt",
        "the name of a recording ends in",
    ),
    "no folder": ("flight.bag", HEAD + IMU, "no/r.csv", "folder 'no' does not exist"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(orbident: Orbident, case: str):
    bag, text, out, words = REFUSED[case]
    write_bag("ros1", Path(), sent())
    if text is not None:
        Path("map.yaml").write_text(text)
    orbident("convert", bag, "--map", "map.yaml", "-o", out).refused(words)
    assert not Path("r.csv").exists()


@pytest.mark.parametrize("content", [b"", b"#ROSBAG V2.0\n", b"hello" * 99])
def test_a_damaged_bag(orbident: Orbident, content: bytes):
    Path("flight.bag").write_bytes(content)
    orbident("topics", "flight.bag").refused("flight.bag: is ")


def test_zero_quaternions(orbident: Orbident):
    zero = [imu("/imu", s.received, s.received, attitude=[0, 0, 0, 0]) for s in sent()]
    bag = write_bag("ros1", Path(), zero, "zero")
    Path("map.yaml").write_text(
        HEAD + IMU.replace("gyro: rad/s", "attitude: quaternion")
    )
    orbident("convert", bag, "--map", "map.yaml", "-o", "r.csv").refused(
        "zero.bag: topic '/imu': all 20 quaternions are zero, as of a tracker"
    )


@pytest.mark.slow
def test_a_long_bag_takes_little_memory():
    """30 000 messages of 0.3 kB are converted in a process of their own."""
    bag = write_bag("mcap-ros2", Path(), sent(count=30_000))
    Path("map.yaml").write_text(HEAD + IMU)
    script = (
        "import resource, sys\n"
        "from orbident.recordings.topics.convert import convert_file\n"
        "def peak():\n"
        "    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "before = peak()\n"
        f"convert_file('{bag}', 'map.yaml', 'r.parquet')\n"
        "print(peak() - before)\n"
    )
    ran = finished(sys.executable, "-c", script)
    assert ran.returncode == 0, ran.stderr
    # A batch and a block of rows, Arrow's buffers and the libraries' types: 25 MB,
    # however long the bag is. The decoded messages would be 60 MB.
    assert int(ran.stdout) < 45_000
