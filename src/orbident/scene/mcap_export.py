"""A motion as recorded and as predicted, as ROS 2 messages for Foxglove and others.

What is predicted has topics and frames of its own, so that it is seen beside what was
measured. Frames have the names of the bodies, with those of the base at its link. The
files are MCAP, and hold the definitions of their messages.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import Signal, Signals
from orbident.extras import extra
from orbident.files.replacing import replacing
from orbident.model.kinematics import poses
from orbident.model.rotations import UNTURNED, quaternion_matrix, rotate
from orbident.recordings.bag import Stores, get_typestore
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.scene.replay import MotionHistory, predicted_motion

with extra("ros", "writing a bag"):
    from mcap.writer import Writer as McapWriter

ROS2 = get_typestore(Stores.ROS2_HUMBLE)


def message(name: str, *fields: Any) -> Any:
    """A message of ROS 2.

    The name is that of its type, `sensor_msgs/Imu`; the fields are in its order.
    """
    return ROS2.types[name.replace("/", "/msg/")](*fields)


class MessageLog:
    """An MCAP file that is being written."""

    def __init__(self, writer: McapWriter) -> None:
        self._writer = writer
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self.counts: Counter[str] = Counter()
        """Messages so far, by topic."""

    def write(self, topic: str, written: Any, time: int) -> None:
        """Add a message.

        All messages of a topic have one type. The time, when it was measured, is in ns
        and not negative.
        """
        kind, writer = written.__msgtype__, self._writer
        if kind not in self._schemas:
            text, _ = ROS2.generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            self._schemas[kind] = schema
        if topic not in self._channels:
            channel = writer.register_channel(topic, "cdr", self._schemas[kind])
            self._channels[topic] = channel
        data = bytes(ROS2.serialize_cdr(written, kind))
        writer.add_message(self._channels[topic], time, data, time)
        self.counts[topic] += 1


WORLD, PREDICTED, FEATURE_FRAME = "world", "predicted/", "feature_point"

LATEST = 2**31
"""s; ROS counts seconds with 32 bits."""

UNKNOWN = np.array([-1.0, *np.zeros(8)])
"""The covariance in an Imu message of what it does not hold,"""

UNSURE = np.zeros(9)
"""and of what it holds with an unknown deviation."""

PART = 512
"""Samples between two words of progress."""


def write_mcap(
    result: Result,
    recording: Recording,
    path: Path,
    signals: Signals = (),
    progress: Callable[[float], object] = lambda done: None,
) -> Mapping[str, int]:
    """Write what a recording shows, and what the identified model predicts of it.

    An existing file is replaced. The signals are what identification predicted of this
    recording's sensors. Gives how many messages each topic has.

    Raises:
        InputError: the result is rejected or not complete, the recording lacks what
            prediction needs, a library is not installed, or the file cannot be written.
    """
    result.check_model()
    replay = predicted_motion(result, recording)
    if replay.predicted is None:
        raise InputError("; ".join(replay.warnings))
    motions = {"measured": replay.measured, "predicted": replay.predicted}
    t_0 = replay.measured.t[0]
    # Times of ROS begin with zero.
    shift = 0.0 if t_0 >= 0 and replay.measured.t[-1] < LATEST else t_0
    with replacing(path) as target, target.open("wb") as file:
        writer = McapWriter(file)
        writer.start(profile="ros2", library="orbident")
        log = MessageLog(writer)
        start = _nanoseconds(t_0 - shift)
        _write_once(log, result, start)
        for k, (name, motion) in enumerate(motions.items()):
            base = _frame(name, result.robot.bodies[0])
            at = result.robot.feature_point, UNTURNED
            S = _transform(start, base, _frame(name, FEATURE_FRAME), *at)
            log.write("/tf_static", message("tf2_msgs/TFMessage", [S]), start)
            moved = motion._replace(t=motion.t - shift)
            for done in _write_motion(log, result.robot, name, moved):
                progress((k + done) / len(motions))
        for signal in signals:
            _write_signal(log, signal, shift)
        writer.finish()
        return dict(log.counts)


def _write_once(log: MessageLog, result: Result, start: int) -> None:
    text = message("std_msgs/String", result.robot.urdf)
    log.write("/robot_description", text, start)
    statuses = [
        message(
            "diagnostic_msgs/DiagnosticStatus",
            0 if result.level == "trust" else 1,
            name,
            f"{result.robot.name} by {result.method}: {result.level}",
            result.robot.name,
            [
                message("diagnostic_msgs/KeyValue", key, repr(float(number)))
                for parameter, _, value, std in getattr(result, name)
                for key, number in ((parameter, value), (f"{parameter}.std", std))
            ],
        )
        for name in ("base", "phi", "pi")
    ]
    estimates = message("diagnostic_msgs/DiagnosticArray", _header(start), statuses)
    log.write("/estimates", estimates, start)


def _write_motion(
    log: MessageLog, robot: Robot, name: str, motion: MotionHistory
) -> Iterator[float]:
    p_LS = robot.feature_point
    names = [*robot.joint_names, *robot.wheel_names]
    q = np.hstack([motion.q, motion.wheel_angles()])
    qd = np.hstack([motion.qd, motion.qd_rw])
    for first in range(0, motion.t.size, PART):
        rows = slice(first, first + PART)
        part = MotionHistory(*(column[rows] for column in motion))
        at = poses(robot, part.q)
        x = Rotation.from_matrix(at.R.reshape(-1, 3, 3)).as_quat()
        x = x.reshape(*at.R.shape[:-2], 4)
        r_base = part.r_S - rotate(quaternion_matrix(part.x_WB), p_LS)
        for k, t in enumerate(part.t):
            time = _nanoseconds(t)
            base = _frame(name, robot.bodies[0])
            frames = [_transform(time, WORLD, base, r_base[k], part.x_WB[k])]
            frames += [
                _transform(time, base, _frame(name, body), at.d[k, i] + p_LS, x[k, i])
                for i, body in enumerate(robot.bodies)
                if i > 0
            ]
            log.write("/tf", message("tf2_msgs/TFMessage", frames), time)
            log.write(f"/imu/{name}", _imu(time, base, part, k), time)
            if name == "measured":
                states = _joint_state(time, names, q[first + k], qd[first + k])
                log.write("/joint_states", states, time)
        yield min(1.0, (first + PART) / motion.t.size)


def _joint_state(time: int, names: list[str], q: np.ndarray, qd: np.ndarray) -> Any:
    # As the library writes them, numbers are side by side in memory.
    numbers = np.array(q), np.array(qd), np.zeros(0)
    return message("sensor_msgs/JointState", _header(time), names, *numbers)


def _imu(time: int, frame: str, motion: MotionHistory, k: int) -> Any:
    return message(
        "sensor_msgs/Imu",
        _header(time, frame),
        _quaternion(motion.x_WB[k]),
        UNSURE,
        _vector(motion.w[k]),
        UNSURE,
        _vector(np.zeros(3)),
        UNKNOWN,
    )


def _write_signal(log: MessageLog, signal: Signal, shift: float) -> None:
    spatial = set(signal.axes) <= set("xyz") and signal.sensor != "joints"
    for name in ("measured", "predicted"):
        topic = f"/signals/{signal.name}/{name}"
        for t, row in zip(signal.t - shift, getattr(signal, name), strict=True):
            time = _nanoseconds(t)
            if spatial:
                xyz = [dict(zip(signal.axes, row, strict=True)).get(k) for k in "xyz"]
                vector = _vector(np.array(xyz, dtype=float))
                written = message("geometry_msgs/Vector3Stamped", _header(time), vector)
            else:
                written = _joint_state(time, list(signal.axes), row, np.zeros(0))
            log.write(topic, written, time)


def _frame(name: str, body: str) -> str:
    return body if name == "measured" else PREDICTED + body


def _transform(time: int, parent: str, child: str, p: np.ndarray, x: np.ndarray) -> Any:
    placed = message("geometry_msgs/Transform", _vector(p), _quaternion(x))
    header = _header(time, parent)
    return message("geometry_msgs/TransformStamped", header, child, placed)


def _header(time: int, frame: str = "") -> Any:
    stamp = message("builtin_interfaces/Time", *divmod(time, 1_000_000_000))
    return message("std_msgs/Header", stamp, frame)


def _vector(v: np.ndarray) -> Any:
    return message("geometry_msgs/Vector3", *map(float, v))


def _quaternion(x: np.ndarray) -> Any:
    return message("geometry_msgs/Quaternion", *map(float, x))


def _nanoseconds(t: float) -> int:
    return max(0, round(float(t) * 1e9))
