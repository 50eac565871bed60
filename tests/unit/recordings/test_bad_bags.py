"""Bags that cannot be read, and maps that do not fit them."""

import importlib
import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pytest
from bag_writers import (
    KINDS,
    START,
    McapWriter,
    Ros1Writer,
    imu,
    joint_state,
    message,
    typestore,
    write_bag,
)
from conversions import HEAD, converted
from mcap.reader import SeekingReader
from mcap.writer import IndexType
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from orbident.errors import InputError
from orbident.recordings.bag import _whole_until
from orbident.recordings.topics.convert import ConversionReport, convert_file
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import proposed_map

MS = 1_000_000
IMU = "  - {topic: /imu, type: sensor_msgs/Imu, take: {gyro: rad/s}, frame: base}\n"
JOINTS = """\
  - topic: /js
    type: sensor_msgs/JointState
    take: {position: rad, velocity: rad/s}
    joints: {shoulder: joint1}
"""
SENT = [imu("/imu", START + k * MS, START + k * MS, [k, 0, 0]) for k in range(400)]


def refusal(folder: Path, bag: Path | str, entries: str = IMU) -> str:
    """The line with which a bag is refused."""
    (folder / "map.yaml").write_text(HEAD + entries)
    with pytest.raises(InputError) as raised:
        convert_file(bag, folder / "map.yaml", folder / "recording.csv")
    assert not (folder / "recording.csv").exists()
    line = str(raised.value)
    assert "\n" not in line
    assert len(line) < 500
    return line


def largest_file(bag: Path) -> Path:
    files = [each for each in bag.rglob("*") if each.suffix != ".yaml"]
    return max(files, key=lambda f: f.stat().st_size) if bag.is_dir() else bag


def cut_off(folder: Path, bag: Path) -> ConversionReport:
    """What becomes of a bag whose recorder lost power."""
    (folder / "map.yaml").write_text(HEAD + IMU)
    report = convert_file(bag, folder / "map.yaml", folder / "recording.csv")
    said = "is cut off: what is before is used"
    assert any(said in each for each in report.warnings)
    assert all(said in each.notes[-1] for each in survey_file(bag))
    return report


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("part", [0.02, 0.5, 0.98])
def test_truncated(tmp_path, kind, part):
    bag = write_bag(kind, tmp_path, SENT)
    file = largest_file(bag)
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    if kind.startswith("mcap") and part > 0.02:
        assert 0 < cut_off(tmp_path, bag).samples <= len(SENT)
        return
    line = refusal(tmp_path, bag)
    assert line.startswith(f"{bag}: is damaged or no bag of this kind (")
    assert "repair it with" in line


def test_zeros_where_nothing_was_written_yet(tmp_path):
    bag = write_bag("mcap-ros2", tmp_path, SENT)
    content = bag.read_bytes()
    half = len(content) // 2
    bag.write_bytes(content[:half])
    expected = cut_off(tmp_path, bag).samples
    (tmp_path / "recording.csv").unlink()
    with bag.open("rb+") as file:
        file.truncate(_whole_until(file, half))
        file.truncate(2 * half)
    assert cut_off(tmp_path, bag).samples == expected


@pytest.mark.parametrize("kind", ["ros2-sqlite3", "ros2-mcap"])
def test_a_folder_whose_recording_was_not_ended(tmp_path, kind):
    (tmp_path / "other").mkdir()
    first = largest_file(write_bag(kind, tmp_path, SENT[:300]))
    second = largest_file(write_bag(kind, tmp_path / "other", SENT[300:]))
    second.rename(first.with_name("flight_10" + first.suffix))
    (first.parent / "metadata.yaml").unlink()
    first.with_name("flight_11" + first.suffix).touch()
    (tmp_path / "map.yaml").write_text(HEAD + IMU)
    report = convert_file(first.parent, tmp_path / "map.yaml", tmp_path / "r.csv")
    assert report.samples == len(SENT)
    assert (
        "has no metadata.yaml, as when a recording is not ended" in report.warnings[0]
    )


@pytest.mark.parametrize("kind", ["ros1-lz4", "mcap-ros2"])
def test_corrupt_in_the_middle(tmp_path, kind):
    bag = write_bag(kind, tmp_path, SENT)
    content = bytearray(bag.read_bytes())
    middle = len(content) // 3
    if kind == "mcap-ros2":
        with bag.open("rb") as file:
            summary = SeekingReader(file).get_summary()
        assert summary is not None
        # Inside the compressed data: 9 bytes of record and 40 of chunk stand before.
        middle = summary.chunk_indexes[5].chunk_start_offset + 60
    content[middle : middle + 64] = bytes(64)
    bag.write_bytes(content)
    assert "is damaged" in refusal(tmp_path, bag)


@pytest.mark.parametrize("suffix", [".bag", ".mcap", ".db3"])
def test_another_kind_of_file(tmp_path, suffix):
    bag = tmp_path / f"flight{suffix}"
    bag.write_bytes(b"\x00\xff\x80ELF" * 500)
    assert "is damaged or no bag of this kind" in refusal(tmp_path, bag)
    bag.write_bytes(b"")
    assert f"{bag}: is empty" in refusal(tmp_path, bag)


def test_paths(tmp_path):
    assert "gone.bag: does not exist; check the path" in refusal(tmp_path, "gone.bag")
    (tmp_path / "notes.pdf").write_text("hello")
    assert "name ends in one of .bag, .mcap" in refusal(
        tmp_path, tmp_path / "notes.pdf"
    )
    (tmp_path / "folder").mkdir()
    line = refusal(tmp_path, tmp_path / "folder")
    assert "is a folder without metadata.yaml" in line


@pytest.mark.parametrize("cell", ["timestamp = 0.5", "data = 'text'"])
def test_a_database_with_cells_of_another_type(tmp_path, cell):
    bag = write_bag("ros2-sqlite3", tmp_path, SENT)
    with closing(sqlite3.connect(largest_file(bag))) as database:
        database.execute(f"update messages set {cell} where id = 200")
        database.commit()
    assert "is damaged or no bag of this kind" in refusal(tmp_path, bag)


def test_topics_whose_names_are_no_text(tmp_path):
    """SQLite keeps bytes in a column of text; the fuzzer found such a bag."""
    bag = largest_file(write_bag("ros2-sqlite3", tmp_path, SENT))
    with closing(sqlite3.connect(bag)) as database:
        database.execute("update topics set name = X'FF'")
        database.commit()
    with pytest.raises(InputError, match="is damaged or no bag of this kind"):
        survey_file(bag)


def test_a_folder_without_its_files(tmp_path):
    bag = write_bag("ros2-sqlite3", tmp_path, SENT)
    largest_file(bag).unlink()
    assert "is damaged" in refusal(tmp_path, bag)


@pytest.mark.parametrize("kind", KINDS)
def test_no_messages(tmp_path, kind):
    assert "holds no messages" in refusal(tmp_path, write_bag(kind, tmp_path, []))


def test_a_bare_database_can_be_read(tmp_path):
    bag = largest_file(write_bag("ros2-sqlite3", tmp_path, SENT))
    (tmp_path / "map.yaml").write_text(HEAD + IMU)
    alone = shutil.copy(bag, tmp_path / "alone.db3")
    out = tmp_path / "r.csv"
    assert convert_file(alone, tmp_path / "map.yaml", out).samples == 400


def test_topic_that_is_not_there(tmp_path):
    bag = write_bag("ros1", tmp_path, SENT)
    line = refusal(tmp_path, bag, IMU.replace("/imu", "/imv"))
    assert "has no topic '/imv'; did you mean '/imu'? it has '/imu'" in line


def test_topic_of_another_type(tmp_path):
    bag = write_bag("ros1", tmp_path, SENT)
    line = refusal(tmp_path, bag, JOINTS.replace("/js", "/imu"))
    assert "map.yaml: topic /imu: type: found sensor_msgs/JointState" in line
    assert "but it is sensor_msgs/Imu in" in line


def test_topic_without_messages(tmp_path):
    store = typestore(ros1=True)
    with Ros1Writer(tmp_path / "flight.bag") as writer:
        writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
        other = writer.add_connection("/n", "std_msgs/msg/Float64", typestore=store)
        writer.write(other, START, b"\0" * 8)
    line = refusal(tmp_path, tmp_path / "flight.bag")
    assert "topic '/imu' has no messages" in line


def test_joint_that_never_occurs(tmp_path):
    sent = [
        joint_state("/js", START + k, START + k * MS, ["sholder", "elbow"], [1, 2])
        for k in range(3)
    ]
    with pytest.raises(InputError) as raised:
        converted(tmp_path, sent, JOINTS)
    line = str(raised.value)
    assert "topic '/js': 'shoulder' never occurs in its messages" in line
    assert "did you mean 'sholder'? known names: 'elbow', 'sholder'" in line


def test_a_quantity_that_messages_leave_out(tmp_path):
    sent = [
        joint_state("/js", START + k, START + k * MS, ["shoulder"], [1])
        for k in range(3)
    ]
    with pytest.raises(InputError) as raised:
        converted(tmp_path, sent, JOINTS)
    message = str(raised.value)
    assert "column 'joint.joint1.velocity' never has a finite number" in message
    assert "give what has it an entry of its own" in message


def with_broken(folder: Path, broken: range) -> Path:
    """A bag some of whose messages are cut short."""
    store = typestore(ros1=True)
    path, name = folder / "flight.bag", "sensor_msgs/msg/Imu"
    with Ros1Writer(path) as writer:
        connection = writer.add_connection("/imu", name, typestore=store)
        for k, sent in enumerate(SENT):
            data = bytes(store.serialize_ros1(message(store, name, sent.fields), name))
            writer.write(connection, sent.received, data[:50] if k in broken else data)
    return path


def test_messages_that_cannot_be_decoded_are_counted(tmp_path):
    bag = with_broken(tmp_path, range(10, 17))
    (tmp_path / "map.yaml").write_text(HEAD + IMU)
    report = convert_file(bag, tmp_path / "map.yaml", tmp_path / "r.csv")
    topic = report.topics[0]
    assert (topic.messages, topic.used) == (400, 393)
    assert topic.rejected == {"duplicate": 0, "without_stamp": 0, "undecodable": 7}
    assert topic.sentences() == ["/imu: 7 could not be decoded, rejected"]


def test_no_message_can_be_decoded(tmp_path):
    bag = with_broken(tmp_path, range(400))
    (found,) = survey_file(bag)
    assert (found.topic.count, found.example) == (400, None)
    assert "# /imu (sensor_msgs/Imu) cannot be mapped" in proposed_map([found])
    assert "none of its 400 messages can be decoded" in refusal(tmp_path, bag)


def test_an_encoding_that_is_not_of_ros(tmp_path):
    with (tmp_path / "flight.mcap").open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("sensor_msgs/Imu", "jsonschema", b"{}")
        channel = writer.register_channel("/imu", "json", schema)
        writer.add_message(channel, START, b"{}", START)
        writer.finish()
    line = refusal(tmp_path, tmp_path / "flight.mcap")
    assert "topic '/imu' is encoded as 'json'" in line


def test_an_mcap_file_without_an_index(tmp_path):
    store, name = typestore(ros1=False), "sensor_msgs/msg/Imu"
    with (tmp_path / "flight.mcap").open("wb") as file:
        writer = McapWriter(
            file,
            index_types=IndexType.NONE,
            use_statistics=False,
            use_summary_offsets=False,
            repeat_channels=False,
            repeat_schemas=False,
        )
        writer.start()
        # No definition either: ROS's own is used.
        schema = writer.register_schema(name, "", b"")
        channel = writer.register_channel("/imu", "cdr", schema)
        for sent in SENT:
            data = store.serialize_cdr(message(store, name, sent.fields), name)
            writer.add_message(channel, sent.received, bytes(data), sent.received)
        writer.finish()
    (tmp_path / "map.yaml").write_text(HEAD + IMU)
    bag, out = tmp_path / "flight.mcap", tmp_path / "r.csv"
    assert convert_file(bag, tmp_path / "map.yaml", out).samples == 400


def test_the_place_is_checked_first(tmp_path):
    with pytest.raises(InputError, match=r"the name of a recording ends in"):
        convert_file("gone.bag", "gone.yaml", tmp_path / "r.txt")


@pytest.mark.parametrize("library", ["rosbags", "mcap"])
def test_without_the_libraries(monkeypatch, library):
    for name in list(sys.modules):
        if name.split(".")[0] == library:
            monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, library, None)
    module = "orbident.recordings.bag"
    monkeypatch.delitem(sys.modules, module, raising=False)
    with pytest.raises(InputError, match=rf'needs {library}: .* "orbident\[ros\]"'):
        importlib.import_module(module)


@pytest.mark.parametrize(
    ("standard", "changed", "lost"),
    [
        (" orientation\n", " attitude\n", "sensor_msgs/Imu has no 'orientation'"),
        ("float64 w", "float64 s", "geometry_msgs/Quaternion has no 'w'"),
        ("float64 w", "string w", "geometry_msgs/Quaternion has no 'w'"),
    ],
)
def test_a_message_that_is_only_called_as_one_of_ros(tmp_path, standard, changed, lost):
    name = "sensor_msgs/msg/Imu"
    definition, _ = typestore(ros1=True).generate_msgdef(name, ros_version=1)
    assert standard in definition
    own = get_typestore(Stores.EMPTY)
    own.register(get_types_from_msg(definition.replace(standard, changed), name))
    bag = tmp_path / "flight.bag"
    with Ros1Writer(bag) as writer:
        connection = writer.add_connection("/imu", name, typestore=own)
        writer.write(connection, START, bytes(400))
    expected = f"topic '/imu': its sensor_msgs/Imu is not ROS's: {lost}"
    assert expected in refusal(tmp_path, bag)
    with pytest.raises(InputError, match=expected):
        survey_file(bag)
