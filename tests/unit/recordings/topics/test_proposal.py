"""What is in a bag, and the map that is proposed."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.io
from bag_writers import (
    KINDS,
    START,
    Sent,
    float64,
    header,
    imu,
    joint_state,
    pose,
    pose_fields,
    vector,
    write_bag,
)

from orbident.errors import InputError
from orbident.recordings.topics.convert import convert_file
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import (
    MESSAGE_TYPES,
    load_topic_map,
    proposed_map,
)

MS = 1_000_000


def transform(t: int, parent: str, child: str) -> dict:
    return {
        "header": header(t, parent),
        "child_frame_id": child,
        "transform": {
            "rotation": vector([0, 0, 0, 1]),
            "translation": vector([1, 2, 3]),
        },
    }


def one_of_each(t: int, k: int) -> list[Sent]:
    """A message of every type that can be mapped, and one that cannot."""
    pose_part = {
        "pose": pose_fields([0, 0, 0, 1], [1, 2, 3]),
        "covariance": np.zeros(36),
    }
    twist = {"linear": vector([k, 0, 0]), "angular": vector([0, k, 0])}
    wrench = {"force": vector([k, 0, 0]), "torque": vector([0, k, 0])}
    frames = {"header": header(t, "world"), "child_frame_id": "base"}
    covariance = {"header": header(t, "world"), "pose": pose_part}
    odometry = {"twist": {"twist": twist, "covariance": np.zeros(36)}}
    arm = transform(t, "base", "arm")
    return [
        joint_state("/joint_states", t, t, ["arm", "yes", "1"], [k, 0, 0], [1, 1, 1]),
        imu("/imu", t, t, [k, 0, 0]),
        imu("/imu_without_attitude", t, t, [k, 0, 0], attitude=[0, 0, 0, 0]),
        pose("/pose", t, t, [0, 0, 0, 1], [k, 0, 0]),
        Sent("/cov", "geometry_msgs/PoseWithCovarianceStamped", t, covariance),
        Sent(
            "/vicon",
            "geometry_msgs/TransformStamped",
            t,
            transform(t, "world", "base"),
        ),
        Sent(
            "/tf",
            "tf2_msgs/TFMessage",
            t,
            {"transforms": [transform(t, "world", "base"), arm]},
        ),
        Sent(
            "/odom", "nav_msgs/Odometry", t, {**frames, "pose": pose_part, **odometry}
        ),
        Sent(
            "/wrench",
            "geometry_msgs/WrenchStamped",
            t,
            {"header": header(t), "wrench": wrench},
        ),
        float64("/rotor", t, k),
        Sent("/name", "std_msgs/String", t, {"data": "flight"}),
    ]


def sent() -> list[Sent]:
    return [
        each
        for k in range(5)
        for n, each in enumerate(one_of_each(START + k * 10 * MS, k))
        if k != 3 or n != 1
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_topics(tmp_path: Path, kind: str):
    found = survey_file(write_bag(kind, tmp_path, sent()))
    names = [each.topic.name for each in found]
    assert names == sorted({each.topic for each in sent()})
    assert {each.topic.type for each in found} == {*MESSAGE_TYPES, "std_msgs/String"}
    by_name = {each.topic.name: each for each in found}
    assert by_name["/imu"].topic.count == 4
    # 4 messages in 40 ms, 5 in 40 ms.
    assert by_name["/imu"].rate == pytest.approx(75, rel=1e-12)
    assert by_name["/pose"].rate == pytest.approx(100, rel=1e-12)
    assert by_name["/joint_states"].labels == ("arm", "yes", "1")
    assert by_name["/tf"].labels == ("world -> base", "base -> arm")


ANSWERS = {
    "/joint_states": "",
    "/imu": "frame: base, point: S",
    "/imu_without_attitude": "frame: base, point: S",
    "/pose": "pose: base-in-inertial, frame: base, point: S",
    "/cov": "pose: base-in-inertial, frame: base, point: S",
    "/vicon": "pose: base-in-inertial, frame: base, point: S",
    "/tf": "pose: base-in-inertial, frame: base, point: S, parent: world, child: base",
    "/odom": "twist: child, frame: base, point: S",
    "/wrench": "frame: base, point: S",
    "/rotor": "take: {wheel.rotor.speed: rad/s}",
}


@pytest.mark.parametrize("topic", ANSWERS)
def test_a_topic_that_is_decided_converts(tmp_path: Path, topic: str):
    only = [each for each in sent() if each.topic in {topic, "/name"}]
    bag = write_bag("ros1", tmp_path, only)
    proposal = proposed_map(survey_file(bag))
    path, out = tmp_path / "map.yaml", tmp_path / "r.csv"
    path.write_text(proposal)
    assert "# /name (std_msgs/String) cannot be mapped" in proposal
    answers = re.split(r", (?=[a-z]+: )", ANSWERS[topic]) if ANSWERS[topic] else []
    if answers:
        # What messages do not tell is not guessed.
        with pytest.raises(InputError, match=r":\d+: topics\[0\]"):
            load_topic_map(path)
        lines = [f"    {answer}\n" for answer in answers]
        name = f"  - topic: {topic}\n"
        assert name in proposal
        path.write_text(proposal.replace(name, name + "".join(lines)))
    report = convert_file(bag, path, out)
    assert report.topics[0].used == len(only) - 5


def test_names_are_quoted_where_yaml_needs_it(tmp_path: Path):
    only = [each for each in sent() if each.topic == "/joint_states"]
    path = tmp_path / "map.yaml"
    path.write_text(proposed_map(survey_file(write_bag("ros1", tmp_path, only))))
    (entry,) = load_topic_map(path)
    assert entry.wanted == {"arm", "yes", "1"}


def test_what_is_taken_is_in_the_messages(tmp_path: Path):
    few = [joint_state("/js", START + k, START + k, ["a"], [k]) for k in range(2)]
    proposal = proposed_map(survey_file(write_bag("ros1", tmp_path, few)))
    assert "take: {position: rad}  # REP 103 says SI" in proposal
    few = [imu("/imu", START, START, attitude=[0, 0, 0, 0])]
    proposal = proposed_map(survey_file(write_bag("ros1", tmp_path, few, "other")))
    assert "its orientation is all zero, so attitude is left out" in proposal
    assert "attitude: quaternion" not in proposal


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_a_table_tells_ranges_and_the_units_that_they_suggest(tmp_path: Path, kind):
    """Not of what the file has a unit for, nor of wheels, which turn on and on."""
    t = np.arange(100) / 10
    columns = {
        "t": t,
        "joint.arm.position": 90 * np.sin(t),
        "wheel.rw.position": 800 * t,
        "level": np.where(t < 1, np.nan, t),
        "never": np.full(100, np.nan),
    }
    path = tmp_path / f"run.{kind}"
    if kind == "mat":
        columns = {name.replace(".", "_"): x for name, x in columns.items()}
        scipy.io.savemat(path, columns)
    else:
        table = pd.DataFrame(columns)
        table.to_csv(path) if kind == "csv" else table.to_parquet(path)
    proposal = proposed_map(survey_file(path))
    hint = "" if kind == "mat" else " (deg?)"
    for line in (
        "joint.arm.position -89.9",
        "wheel.rw.position 0 to 7920\n",
        "level 1 to 9.9\n",
        "never\n",
    ):
        name, space, rest = line.partition(" ")
        shown = name.replace(".", "_") if kind == "mat" else name
        assert f"#   {shown}{space}{rest}" in proposal
    assert re.search(rf"position -89\.\d+ to 8\d\.\d+{re.escape(hint)}\n", proposal)
