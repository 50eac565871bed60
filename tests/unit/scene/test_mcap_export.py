"""What is written is read by MCAP's own reader and ROS 2's decoder for it."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import report_runs
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.model.kinematics import poses
from orbident.recordings.recording import Recording
from orbident.scene.mcap_export import write_mcap
from orbident.scene.replay import predicted_motion


def read(path: Path) -> tuple[dict[str, list[Any]], dict[str, str]]:
    """Every message by topic, and the topics' types."""
    found, types = defaultdict(list), {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        for schema, channel, raw, decoded in reader.iter_decoded_messages():
            assert schema is not None
            assert channel.message_encoding == "cdr"
            types[channel.topic] = schema.name
            found[channel.topic].append((raw.log_time, decoded))
        assert summary.statistics.message_count == sum(map(len, found.values()))
    return dict(found), types


def stamps(messages: Sequence[Any]) -> np.ndarray:
    """Times in the headers, s; they are the file's own times too."""
    times = []
    for logged, each in messages:
        header = (each.transforms[0] if hasattr(each, "transforms") else each).header
        stamp = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
        assert stamp == logged
        times.append(stamp * 1e-9)
    return np.array(times)


def xyz(v: Any) -> list[float]:
    return [v.x, v.y, v.z]


def xyzw(x: Any) -> list[float]:
    return [x.x, x.y, x.z, x.w]


@pytest.fixture(scope="module")
def result() -> Result:
    return report_runs.result()


@pytest.fixture(scope="module")
def recording() -> Recording:
    return report_runs.flown()[1]


@pytest.fixture(scope="module")
def written(result, recording, tmp_path_factory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("mcap") / "flight.mcap"
    counts = write_mcap(result, recording, path, result.signals())
    found, types = read(path)
    assert counts == {topic: len(messages) for topic, messages in found.items()}
    return {"messages": found, "types": types}


def test_types(written):
    types = written["types"]
    assert types["/joint_states"] == "sensor_msgs/msg/JointState"
    assert types["/tf"] == types["/tf_static"] == "tf2_msgs/msg/TFMessage"
    for name in ("measured", "predicted"):
        assert types[f"/imu/{name}"] == "sensor_msgs/msg/Imu"
    assert types["/estimates"] == "diagnostic_msgs/msg/DiagnosticArray"
    assert types["/robot_description"] == "std_msgs/msg/String"


def test_joints_and_wheels(written, result, recording):
    messages = written["messages"]["/joint_states"]
    motion = predicted_motion(result, recording).measured
    # Nanoseconds.
    np.testing.assert_allclose(stamps(messages), motion.t, atol=1e-9)
    robot = result.robot
    assert messages[0][1].name == [*robot.joint_names, *robot.wheel_names]
    velocity = np.array([each.velocity for _, each in messages])
    assert np.array_equal(velocity, np.hstack([motion.qd, motion.qd_rw]))
    position = np.array([each.position for _, each in messages])
    assert np.array_equal(position[:, :3], motion.q)
    # A wheel at a steady speed turns by it.
    turned = np.diff(position[:, 3:], axis=0) / np.diff(motion.t)[:, None]
    between = (motion.qd_rw[1:] + motion.qd_rw[:-1]) / 2
    np.testing.assert_allclose(turned, between, rtol=1e-9, atol=1e-9)


def test_imu(written, result, recording):
    replay = predicted_motion(result, recording)
    assert replay.predicted is not None
    for name, motion in (
        ("measured", replay.measured),
        ("predicted", replay.predicted),
    ):
        messages = written["messages"][f"/imu/{name}"]
        rate = np.array([xyz(each.angular_velocity) for _, each in messages])
        attitude = np.array([xyzw(each.orientation) for _, each in messages])
        assert np.array_equal(rate, motion.w)
        assert np.array_equal(attitude, motion.x_WB)
        # As ROS says that there is no acceleration.
        assert messages[0][1].linear_acceleration_covariance[0] == -1
    frame = "base" if "base" in result.robot.bodies else result.robot.bodies[0]
    assert messages[0][1].header.frame_id == f"predicted/{frame}"


def test_frames(written, result, recording):
    """A body is where forward kinematics has it, in the world."""
    robot = result.robot
    replay = predicted_motion(result, recording)
    assert replay.predicted is not None
    at = poses(robot, replay.measured.q)
    by_child = defaultdict(list)
    for _, each in written["messages"]["/tf"]:
        for moved in each.transforms:
            by_child[moved.child_frame_id].append(moved)
    for prefix, motion in (("", replay.measured), ("predicted/", replay.predicted)):
        base = prefix + robot.bodies[0]
        assert {moved.header.frame_id for moved in by_child[base]} == {"world"}
        R_WB, p_WB = placed(by_child[base])
        # The base link's origin, and S from there.
        r_S = p_WB + R_WB.apply(robot.feature_point)
        np.testing.assert_allclose(r_S, motion.r_S, atol=1e-12)
        for i, body in enumerate(robot.bodies[1:], start=1):
            frames = by_child[prefix + body]
            assert {moved.header.frame_id for moved in frames} == {base}
            R, p = placed(frames)
            np.testing.assert_allclose(R.as_matrix(), at.R[:, i], atol=1e-12)
            np.testing.assert_allclose(p - robot.feature_point, at.d[:, i], atol=1e-12)


def placed(frames: Sequence[Any]) -> tuple[Rotation, np.ndarray]:
    x = [xyzw(moved.transform.rotation) for moved in frames]
    p = [xyz(moved.transform.translation) for moved in frames]
    return Rotation.from_quat(x), np.array(p)


def test_signals_and_estimates(written, result):
    for signal in result.signals():
        for name in ("measured", "predicted"):
            messages = written["messages"][f"/signals/{signal.name}/{name}"]
            np.testing.assert_allclose(stamps(messages), signal.t, atol=1e-9)
            values = np.array([xyz(each.vector) for _, each in messages])
            axes = ["xyz".index(k) for k in signal.axes]
            assert np.array_equal(values[:, axes], getattr(signal, name))
    [(_, estimates)] = written["messages"]["/estimates"]
    for status, found in zip(
        estimates.status, (result.base, result.phi, result.pi), strict=True
    ):
        shown = {each.key: float(each.value) for each in status.values}
        for name, _, value, std in found:
            assert (shown[name], shown[f"{name}.std"]) == (value, std)


def test_times_that_ros_cannot_hold_begin_with_zero(result, recording, tmp_path):
    path = tmp_path / "a.mcap"
    early = Recording(recording.t - 100.0, recording.columns)
    write_mcap(result, early, path)
    times = stamps(read(path)[0]["/joint_states"])
    assert times[0] == 0.0
    np.testing.assert_allclose(times, recording.t - recording.t[0], atol=2e-9)


def test_a_rejected_result_is_not_written(recording, tmp_path):
    with pytest.raises(InputError, match="is refused"):
        write_mcap(report_runs.rejected(), recording, tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())
