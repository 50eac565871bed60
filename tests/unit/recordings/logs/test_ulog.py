"""A log with all that PX4 writes into one, read as pyulog reads it."""

import struct
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from conversions import HEAD
from pyulog import ULog

from orbident.recordings.logs.log import read_ulog
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import convert_file

N = 30
START = 4_000_000
"""us since the computer was switched on; PX4 logs from arming on."""

FORMATS = (
    "sensor_gyro:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;"
    "float x;float y;float z;uint8_t[3] clip_counter;uint8_t samples;"
    "uint8_t[4] _padding0;",
    "vehicle_attitude:uint64_t timestamp;float[4] q;uint8_t quat_reset_counter;"
    "bool armed;int16_t turns;",
)


def message(kind: str, body: bytes) -> bytes:
    return struct.pack("<H", len(body)) + kind.encode() + body


def information(key: str, value: bytes) -> bytes:
    return message("I", bytes([len(key)]) + key.encode() + value)


def parameter(key: str, value: bytes) -> bytes:
    return message("P", bytes([len(key)]) + key.encode() + value)


def gyro(number: int, k: int) -> bytes:
    t = START + 4000 * k + 100 * number
    rates = (0.1 * k, -0.2 * k, 0.3 * number)
    fixed = struct.pack("<HQQI", number, t, t - 50, 1310988)
    return message("D", fixed + struct.pack("<3f4B", *rates, 0, 0, 1, 8))


def attitude(k: int) -> bytes:
    q = (np.cos(0.01 * k), 0.0, 0.0, np.sin(0.01 * k))
    body = struct.pack("<HQ4fB?h", 2, START + 8000 * k, *q, 1, True, -3)
    return message("D", body)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Two gyros and an attitude among texts, parameters, a drop-out and marks."""
    definitions = [
        message("B", bytes(40)),
        information("char[3] sys_name", b"PX4"),
        *(message("F", text.encode()) for text in FORMATS),
        parameter("int32_t SYS_AUTOSTART", struct.pack("<i", 4001)),
        parameter("float MC_ROLL_P", struct.pack("<f", 6.5)),
        *(
            message("A", struct.pack("<BH", instance, number) + name)
            for number, (name, instance) in enumerate(
                [(b"sensor_gyro", 0), (b"sensor_gyro", 1), (b"vehicle_attitude", 0)]
            )
        ),
    ]
    data = []
    for k in range(N):
        data += [gyro(0, k), gyro(1, k)]
        if k % 2 == 0:
            data.append(attitude(k // 2))
        if k == 10:
            text = struct.pack("<BQ", ord("6"), START + 4000 * k) + b"armed"
            mark = bytes.fromhex("2f731320250cbb12")
            data += [
                message("L", text),
                message("O", struct.pack("<H", 12)),
                message("S", mark),
                parameter("float MC_ROLL_P", struct.pack("<f", 7.0)),
            ]
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START - 1000)
    path = tmp_path / "log.ulg"
    path.write_bytes(head + b"".join([*definitions, *data]))
    return path


def test_every_field_is_what_pyulog_reads(log: Path):
    theirs = ULog(str(log))
    assert not theirs.file_corruption
    with ExitStack() as stack:
        ours = read_ulog(log, stack)
    names = {"sensor_gyro": (0, 0), "sensor_gyro.1": (0, 1), "vehicle_attitude": (0, 0)}
    assert set(ours) == set(names)
    for name, (_, instance) in names.items():
        data = theirs.get_dataset(name.partition(".")[0], instance).data
        fields = {key.replace("[", ".").replace("]", ""): key for key in data}
        assert set(ours[name]) == set(fields)
        for field, key in fields.items():
            np.testing.assert_array_equal(ours[name][field].values(), data[key])


ENTRIES = """\
  - topic: /sensor_gyro.1
    type: table
    stamp: {timestamp: us}
    take: {gyro: rad/s}
    fields: {gyro: [x, y, z]}
    frame: base
  - topic: /vehicle_attitude
    type: table
    stamp: {timestamp: us}
    take: {attitude: quaternion}
    fields: {attitude: [q.1, q.2, q.3, q.0]}
    frame: base
"""


def test_the_recording_is_what_pyulog_reads_and_writes(log: Path, tmp_path: Path):
    """Theirs, ours, and ours of the file as their writer writes it again."""
    theirs = ULog(str(log))
    again = tmp_path / "again.ulg"
    theirs.write_ulog(str(again))
    topic_map = tmp_path / "map.yaml"
    topic_map.write_text(HEAD + ENTRIES)
    recordings = []
    for path in (log, again):
        out = path.with_suffix(".parquet")
        assert convert_file(path, topic_map, out).warnings == ()
        recordings.append(read_recording(out))
    for recording in recordings:
        for topic, instance, columns in (
            ("sensor_gyro", 1, {f"gyro.{k}": k for k in "xyz"}),
            ("vehicle_attitude", 0, {"attitude.w": "q[0]", "attitude.z": "q[3]"}),
        ):
            data = theirs.get_dataset(topic, instance).data
            for column, key in columns.items():
                found = recording.column(column)
                there = np.isfinite(found)
                # float32 in the log; quaternions are made as long as one.
                np.testing.assert_allclose(found[there], data[key], atol=1e-7)
                # The first stamp is that of the attitude.
                t = 1e-6 * (data["timestamp"].astype(float) - START)
                np.testing.assert_allclose(recording.t[there], t, atol=1e-9)
