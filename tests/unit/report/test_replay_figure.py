"""The replay of a report is small, and shows where the bodies were."""

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.report.replay_figure import (
    FRAMES,
    REPLAY,
    replay_figure,
    replay_sections,
    write_replay,
)
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import centroidal_momentum, placed, recorded_motion
from orbident.scene.scene import scene_of
from orbident.simulation.simulate import simulate


@pytest.fixture(scope="module")
def robot():
    return load_robot("dual-arm")


@pytest.fixture(scope="module")
def flight(robot) -> Recording:
    return simulate(robot, random_motion(robot, duration=10.0))


def points(data: dict) -> np.ndarray:
    columns = [base64.b64decode(data[k]["bdata"]) for k in "xyz"]
    return np.column_stack([np.frombuffer(column, "<f4") for column in columns])


def test_it_is_small_and_has_few_frames(robot, flight: Recording):
    figure = replay_figure(scene_of(robot), recorded_motion(robot, flight).measured)
    assert FRAMES / 2 < len(figure["frames"]) <= FRAMES
    assert len(figure["layout"]["sliders"][0]["steps"]) == len(figure["frames"])
    assert len(json.dumps(figure, allow_nan=False)) < 1_000_000


def test_bodies_are_where_they_were(robot, flight: Recording):
    scene = scene_of(robot)
    motion = recorded_motion(robot, flight).measured
    figure = replay_figure(scene, motion)
    shown = motion.thinned(FRAMES)
    at = placed(scene, shown, np.zeros_like(shown.qd_rw))
    cm = centroidal_momentum(robot, shown).r_cm
    k, last = 7, max(i for i, s in enumerate(scene.shapes) if s.frame == 7)
    before = sum(len(shape.vertices) for shape in scene.shapes[:last])
    shape = scene.shapes[last]
    expected = shape.vertices @ at.R[k, 7].T + at.p[k, 7] - cm[k]
    found = points(figure["frames"][k]["data"][0])
    # Single precision, of some metres.
    assert np.abs(found[before : before + len(expected)] - expected).max() < 1e-6
    faces = np.frombuffer(base64.b64decode(figure["data"][0]["k"]["bdata"]), "<i4")
    assert faces.max() == len(found) - 1


def test_a_folder_keeps_it(robot, flight: Recording, tmp_path: Path):
    assert replay_sections(tmp_path) == []
    write_replay(robot, flight, tmp_path)
    (section,) = replay_sections(tmp_path)
    assert section.charts[0].figure["data"][0]["type"] == "mesh3d"
    (tmp_path / REPLAY).write_text("{")
    with pytest.raises(InputError, match="is not JSON"):
        replay_sections(tmp_path)


def test_a_recording_of_no_motion_leaves_nothing(robot, tmp_path: Path):
    write_replay(robot, Recording(np.arange(3.0), {}), tmp_path)
    assert not (tmp_path / REPLAY).exists()
