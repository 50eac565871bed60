"""What a tracker sends that is lost."""

import numpy as np
import pytest
from bag_writers import START, pose
from conversions import converted
from scipy.spatial.transform import Rotation

MS = 1_000_000
COUNT = 400
T = 0.01 * np.arange(COUNT)
X = Rotation.from_euler("z", 0.4 * np.sin(T)[:, None]).as_quat()
P = np.column_stack([np.sin(T), np.cos(2 * T), 0.1 * T])
X, P = (x + 1e-4 * np.random.default_rng(0).standard_normal(x.shape) for x in (X, P))
X /= np.linalg.norm(X, axis=1, keepdims=True)
LOST = np.arange(200, 210)
ENTRIES = """\
  - topic: /p
    type: geometry_msgs/PoseStamped
    pose: base-in-inertial
    frame: base
    point: S
    take: {position: m, attitude: quaternion}
"""


@pytest.mark.parametrize(
    ("x", "p", "sensors", "words"),
    [
        (
            [0, 0, 0, 0],
            None,
            ["attitude", "position"],
            "attitude: 10 quaternions of zeros",
        ),
        (
            [0, 0, 0, 1],
            [0, 0, 0],
            ["attitude", "position"],
            "position: 10 samples of a frozen sensor",
        ),
        (X[200], P[200], ["attitude", "position"], "attitude: 10 samples of a frozen"),
        (
            None,
            [9999999] * 3,
            ["position"],
            "position: 10 samples with the impossible value 9999999",
        ),
    ],
    ids=["zeros", "identity", "frozen", "placeholder"],
)
def test_a_pose_of_a_tracker_that_is_lost_is_left_empty(tmp_path, x, p, sensors, words):
    attitudes, positions = X.copy(), P.copy()
    attitudes[LOST] = X[LOST] if x is None else x
    positions[LOST] = P[LOST] if p is None else p
    sent = [
        pose("/p", START + k * 10 * MS, START + k * 10 * MS, *each)
        for k, each in enumerate(zip(attitudes, positions, strict=True))
    ]
    recording, report = converted(tmp_path, sent, ENTRIES)
    for sensor, axes in (("attitude", "xyzw"), ("position", "xyz")):
        empty = np.isnan(recording.vector(sensor, axes)).any(axis=1)
        rows = LOST if sensor in sensors else []
        np.testing.assert_array_equal(np.flatnonzero(empty), rows)
    (topic,) = report.topics
    assert any(f"/p: {words}" in said for said in topic.sentences())
    assert topic.not_finite == 0


def test_what_is_sent_well_is_converted_whole(tmp_path):
    sent = [
        pose("/p", START + k * 10 * MS, START + k * 10 * MS, *each)
        for k, each in enumerate(zip(X, P, strict=True))
    ]
    recording, report = converted(tmp_path, sent, ENTRIES)
    np.testing.assert_array_equal(recording.vector("position"), P)
    assert report.topics[0].emptied == {}
