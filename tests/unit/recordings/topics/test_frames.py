"""Directions and frames that a map declares, against SciPy's rotations."""

import numpy as np
import pytest
from bag_writers import START, Sent, header, imu, pose, pose_fields, vector
from conversions import cells, converted
from scipy.spatial.transform import Rotation

from orbident.errors import InputError

MS = 1_000_000
DRAW = np.random.default_rng(5)
COUNT = 40
R_WS = Rotation.random(COUNT, rng=DRAW)
P, V, W = DRAW.normal(size=(3, COUNT, 3))
R_BS = Rotation.from_euler("xyz", [20, -40, 110], degrees=True)
MOUNTED = f"    rotation: {R_BS.as_quat().tolist()}\n    point: S\n"
# A dozen products of numbers around one.
EXACT = {"rtol": 0, "atol": 1e-14}


def times():
    return [START + k * MS for k in range(COUNT)]


def check_attitude(recording, expected: Rotation):
    found = Rotation.from_quat(cells(recording, "attitude", "xyzw"))
    np.testing.assert_allclose(found.as_matrix(), expected.as_matrix(), **EXACT)


def test_imu_turned_against_the_base(tmp_path):
    sent = [
        imu("/imu", t, t, w, v, x.as_quat())
        for t, w, v, x in zip(times(), W, V, R_WS, strict=True)
    ]
    entries = (
        "  - topic: /imu\n    type: sensor_msgs/Imu\n"
        + MOUNTED
        + "    take: {gyro: deg/s, accelerometer: mg, attitude: quaternion}\n"
    )
    recording, _ = converted(tmp_path, sent, entries)
    w_B = R_BS.apply(np.radians(W))
    np.testing.assert_allclose(recording.vector("gyro"), w_B, **EXACT)
    f_B = R_BS.apply(V) * 9.80665e-3
    np.testing.assert_allclose(recording.vector("accelerometer"), f_B, **EXACT)
    check_attitude(recording, R_WS * R_BS.inv())


@pytest.mark.parametrize("pose_is", ["base-in-inertial", "inertial-in-base"])
@pytest.mark.parametrize("covariance", [False, True])
def test_poses(tmp_path, pose_is, covariance):
    R, p = (R_WS, P)
    if pose_is == "inertial-in-base":
        R, p = R_WS.inv(), -R_WS.inv().apply(P)
    kind = "geometry_msgs/PoseStamped"
    sent = [
        pose("/p", t, t, x.as_quat(), q) for t, x, q in zip(times(), R, p, strict=True)
    ]
    if covariance:
        kind = "geometry_msgs/PoseWithCovarianceStamped"
        sent = [
            Sent(
                "/p",
                kind,
                s.received,
                {
                    "header": s.fields["header"],
                    "pose": {"pose": s.fields["pose"], "covariance": np.zeros(36)},
                },
            )
            for s in sent
        ]
    entries = (
        f"  - topic: /p\n    type: {kind}\n    pose: {pose_is}\n"
        + MOUNTED
        + "    take: {position: cm, attitude: quaternion}\n"
    )
    recording, _ = converted(tmp_path, sent, entries)
    np.testing.assert_allclose(recording.vector("position"), P / 100, **EXACT)
    check_attitude(recording, R_WS * R_BS.inv())


def transform(t: int, parent: str, child: str, x, p) -> dict:
    return {
        "header": header(t, parent),
        "child_frame_id": child,
        "transform": {"rotation": vector(x), "translation": vector(p)},
    }


TF_ENTRY = """\
    parent: world
    child: base_link
    pose: base-in-inertial
    frame: base
    point: S
    take: {position: m, attitude: quaternion}
"""


def test_one_transform_of_many(tmp_path):
    sent = []
    for t, x, p in zip(times(), R_WS, P, strict=True):
        wanted = transform(t, "world", "base_link", x.as_quat(), p)
        other = transform(t, "base_link", "arm", [0, 0, 0, 1], [9, 9, 9])
        # The arm's is alone in the first messages, and stands first in the others.
        lists = [[other], [other, wanted]]
        sent += [
            Sent("/tf", "tf2_msgs/TFMessage", t, {"transforms": each}) for each in lists
        ]
    entries = "  - topic: /tf\n    type: tf2_msgs/TFMessage\n" + TF_ENTRY
    recording, report = converted(tmp_path, sent, entries)
    np.testing.assert_array_equal(recording.vector("position"), P)
    check_attitude(recording, R_WS)
    topic = report.topics[0]
    assert (topic.messages, topic.used, topic.incomplete) == (2 * COUNT, COUNT, COUNT)
    with pytest.raises(InputError) as raised:
        converted(tmp_path, sent, entries.replace("base_link", "base_lnk"))
    line = str(raised.value)
    assert "'world -> base_lnk' never occurs" in line
    assert "did you mean 'world -> base_link'?" in line


def test_transform_stamped(tmp_path):
    sent = [
        Sent(
            "/vicon",
            "geometry_msgs/TransformStamped",
            t,
            transform(t, "world", "base_link", x.as_quat(), p),
        )
        for t, x, p in zip(times(), R_WS, P, strict=True)
    ]
    kind = "geometry_msgs/TransformStamped"
    entries = f"  - topic: /vicon\n    type: {kind}\n" + TF_ENTRY
    recording, _ = converted(tmp_path, sent, entries, "ros1")
    np.testing.assert_array_equal(recording.vector("position"), P)
    check_attitude(recording, R_WS)


@pytest.mark.parametrize("twist", ["child", "parent"])
def test_odometry(tmp_path, twist):
    v, w = (V, W) if twist == "parent" else (R_WS.inv().apply(V), R_WS.inv().apply(W))
    sent = [
        Sent(
            "/odom",
            "nav_msgs/Odometry",
            t,
            {
                "header": header(t, "world"),
                "child_frame_id": "base_link",
                "pose": {
                    "pose": pose_fields(x.as_quat(), p),
                    "covariance": np.zeros(36),
                },
                "twist": {
                    "twist": {"linear": vector(a), "angular": vector(b)},
                    "covariance": np.zeros(36),
                },
            },
        )
        for t, x, p, a, b in zip(times(), R_WS, P, v, w, strict=True)
    ]
    entries = (
        f"  - topic: /odom\n    type: nav_msgs/Odometry\n    twist: {twist}\n"
        + MOUNTED
        + "    take: {position: m, attitude: quaternion, velocity: m/s, gyro: rad/s}\n"
    )
    recording, _ = converted(tmp_path, sent, entries)
    np.testing.assert_array_equal(recording.vector("position"), P)
    np.testing.assert_allclose(recording.vector("velocity"), V, **EXACT)
    # w_B = R_BS R_WS^T w_W.
    w_B = R_BS.apply(R_WS.inv().apply(W))
    np.testing.assert_allclose(recording.vector("gyro"), w_B, **EXACT)
    check_attitude(recording, R_WS * R_BS.inv())


def test_wrench(tmp_path):
    sent = [
        Sent(
            "/w",
            "geometry_msgs/WrenchStamped",
            t,
            {
                "header": header(t, "base"),
                "wrench": {"force": vector(f), "torque": vector(n)},
            },
        )
        for t, f, n in zip(times(), V, W, strict=True)
    ]
    entries = (
        "  - topic: /w\n    type: geometry_msgs/WrenchStamped\n"
        + MOUNTED
        + "    take: {force: mN, torque: N m}\n"
    )
    recording, _ = converted(tmp_path, sent, entries)
    np.testing.assert_allclose(recording.vector("force"), R_BS.apply(V) / 1e3, **EXACT)
    np.testing.assert_allclose(recording.vector("torque"), R_BS.apply(W), **EXACT)


def test_a_quaternion_of_few_digits_is_made_one_of_length_one(tmp_path):
    rough = [np.round(x.as_quat(), 3) for x in R_WS]
    sent = [pose("/p", t, t, x, p) for t, x, p in zip(times(), rough, P, strict=True)]
    entries = (
        "  - topic: /p\n    type: geometry_msgs/PoseStamped\n"
        "    pose: base-in-inertial\n" + MOUNTED + "    take: {attitude: quaternion}\n"
    )
    recording, _ = converted(tmp_path, sent, entries)
    norms = np.linalg.norm(cells(recording, "attitude", "xyzw"), axis=1)
    np.testing.assert_allclose(norms, 1, **EXACT)


@pytest.mark.parametrize("scale", [0.1, 0.98, 1.02])
def test_the_first_quaternion_that_is_none_is_named(tmp_path, scale):
    sent = [
        pose("/p", t, t, x.as_quat() * (scale if k in {7, 9} else 1), p)
        for k, (t, x, p) in enumerate(zip(times(), R_WS, P, strict=True))
    ]
    entries = (
        "  - topic: /p\n    type: geometry_msgs/PoseStamped\n"
        "    pose: base-in-inertial\n" + MOUNTED + "    take: {attitude: quaternion}\n"
    )
    with pytest.raises(InputError) as raised:
        converted(tmp_path, sent, entries)
    line = str(raised.value)
    assert "topic '/p': 2 of 40 quaternions are not of length one within 1 %" in line
    assert f"first at 1700000000.007 s with norm {scale:.4g}" in line
