"""Bags written by the libraries' own writers, one message list for every kind."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

KINDS = ("ros1", "ros1-lz4", "ros2-sqlite3", "ros2-mcap", "mcap-ros1", "mcap-ros2")
START = 1_700_000_000_000_000_000
"""ns; an epoch time, whose nanoseconds float64 seconds could not hold."""


Numbers = Sequence[float] | np.ndarray


class Sent(NamedTuple):
    """One message."""

    topic: str
    type: str
    received: int
    fields: dict[str, Any]


def header(stamp: int, frame: str = "") -> dict[str, Any]:
    sec, nanosec = divmod(stamp, 1_000_000_000)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}


def vector(values: Numbers) -> dict[str, float]:
    return dict(zip("xyzw", map(float, values), strict=False))


def pose_fields(x: Numbers, p: Numbers) -> dict[str, Any]:
    return {"orientation": vector(x), "position": vector(p)}


def joint_state(
    topic: str,
    received: int,
    stamp: int,
    names: Sequence[str],
    position: Numbers,
    velocity: Numbers = (),
    effort: Numbers = (),
) -> Sent:
    fields = {
        "header": header(stamp),
        "name": list(names),
        "position": np.array(position, dtype=np.float64),
        "velocity": np.array(velocity, dtype=np.float64),
        "effort": np.array(effort, dtype=np.float64),
    }
    return Sent(topic, "sensor_msgs/JointState", received, fields)


def imu(
    topic: str,
    received: int,
    stamp: int,
    gyro: Numbers = (0, 0, 0),
    force: Numbers = (0, 0, 0),
    attitude: Numbers = (0, 0, 0, 1),
) -> Sent:
    fields = {
        "header": header(stamp, "imu"),
        "orientation": vector(attitude),
        "orientation_covariance": np.zeros(9),
        "angular_velocity": vector(gyro),
        "angular_velocity_covariance": np.zeros(9),
        "linear_acceleration": vector(force),
        "linear_acceleration_covariance": np.zeros(9),
    }
    return Sent(topic, "sensor_msgs/Imu", received, fields)


def pose(topic: str, received: int, stamp: int, x: Numbers, p: Numbers) -> Sent:
    fields = {"header": header(stamp, "world"), "pose": pose_fields(x, p)}
    return Sent(topic, "geometry_msgs/PoseStamped", received, fields)


def float64(topic: str, received: int, value: float) -> Sent:
    return Sent(topic, "std_msgs/Float64", received, {"data": float(value)})


def write_bag(
    kind: str, folder: Path, sent: Sequence[Sent], name: str = "flight"
) -> Path:
    """A bag with these messages, in this order; its path."""
    writer = {
        "ros1": _ros1,
        "ros1-lz4": _ros1,
        "ros2-sqlite3": _ros2,
        "ros2-mcap": _ros2,
        "mcap-ros1": _mcap,
        "mcap-ros2": _mcap,
    }[kind]
    return writer(kind, folder / name, sent)


LABORATORY = {
    "lab_msgs/msg/RigidBody": "string name\ngeometry_msgs/Pose pose\nbool seen",
    "lab_msgs/msg/Bodies": "std_msgs/Header header\nlab_msgs/RigidBody[] bodies",
    "lab_msgs/msg/Odd": "string header\nfloat64[] transforms\nfloat64 name",
    "lab_msgs/msg/Arm": "uint64 timestamp\nfloat32[3] rate\nfloat64[] q\nstring state",
}
"""Messages that no ROS has."""


def typestore(ros1: bool) -> Any:
    """The messages of a ROS 1 or a ROS 2; the library lacks one of ROS 1's."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name, text in LABORATORY.items():
        store.register(get_types_from_msg(text, name))
    if ros1:
        transforms = "geometry_msgs/TransformStamped[] transforms"
        store.register(get_types_from_msg(transforms, "tf2_msgs/msg/TFMessage"))
    return store


def _ros1(kind: str, path: Path, sent: Sequence[Sent]) -> Path:
    store, path = typestore(ros1=True), path.with_suffix(".bag")
    writer = Ros1Writer(path)
    if kind.endswith("lz4"):
        writer.set_compression(Ros1Writer.CompressionFormat.LZ4)
    with writer:
        found = {}
        for topic, kind_, received, fields in sent:
            name = kind_.replace("/", "/msg/")
            if topic not in found:
                found[topic] = writer.add_connection(topic, name, typestore=store)
            data = store.serialize_ros1(message(store, name, fields), name)
            writer.write(found[topic], received, data)
    return path


def _ros2(kind: str, path: Path, sent: Sequence[Sent]) -> Path:
    store = typestore(ros1=False)
    plugin = StoragePlugin.MCAP if kind.endswith("mcap") else StoragePlugin.SQLITE3
    with Ros2Writer(path, version=9, storage_plugin=plugin) as writer:
        found = {}
        for topic, kind_, received, fields in sent:
            name = kind_.replace("/", "/msg/")
            if topic not in found:
                found[topic] = writer.add_connection(topic, name, typestore=store)
            data = store.serialize_cdr(message(store, name, fields), name)
            writer.write(found[topic], received, data)
    return path


def _mcap(kind: str, path: Path, sent: Sequence[Sent]) -> Path:
    ros1 = kind.endswith("ros1")
    store, path = typestore(ros1), path.with_suffix(".mcap")
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=4096)
        writer.start(profile=kind.removeprefix("mcap-"))
        found = {}
        for topic, kind_, received, fields in sent:
            name = kind_.replace("/", "/msg/")
            if topic not in found:
                text, _ = store.generate_msgdef(name, ros_version=1 if ros1 else 2)
                schema = writer.register_schema(
                    kind_ if ros1 else name,
                    "ros1msg" if ros1 else "ros2msg",
                    text.encode(),
                )
                found[topic] = writer.register_channel(
                    topic, "ros1" if ros1 else "cdr", schema
                )
            built = message(store, name, fields)
            write = store.serialize_ros1 if ros1 else store.serialize_cdr
            data = bytes(write(built, name))
            writer.add_message(found[topic], received, data, received)
        writer.finish()
    return path


def message(store: Any, name: str, fields: dict[str, Any]) -> Any:
    """A message of a type from nested dictionaries; ROS 1 headers are numbered."""
    if name == "std_msgs/msg/Header" and "seq" in _field_types(store, name):
        fields = {"seq": 0, **fields}
    types = _field_types(store, name)
    built = {
        key: [message(store, types[key], each) for each in value]
        if isinstance(value, list) and value and isinstance(value[0], dict)
        else message(store, types[key], value)
        if isinstance(value, dict)
        else value
        for key, value in fields.items()
    }
    return store.types[name](**built)


def _field_types(store: Any, name: str) -> dict[str, str]:
    """Each field's message type, or its elements'."""

    def of(kind: Any) -> str:
        # (node, name) of a message, (node, ((node, name), ...)) of an array of them.
        inner = kind[1]
        while not isinstance(inner, str):
            inner = inner[0] if isinstance(inner[0], str) else inner[0][1]
        return inner

    return {key: of(kind) for key, kind in store.fielddefs[name][1]}
