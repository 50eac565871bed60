"""`validate` on the recording that a result was identified from."""

import pytest
from random_motions import random_motion
from running import Orbident

from orbident.cli.validate import was_used
from orbident.recordings.tables import write_recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

ALL = {"file": "r.csv", "sha256": "1"}
FIRST = {**ALL, "to": 30.0}


@pytest.mark.parametrize(
    ("origin", "sha256", "start", "end", "used"),
    [
        (ALL, "1", None, None, True),
        (ALL, "2", None, None, False),
        ({}, "1", None, None, False),
        (FIRST, "1", None, None, True),
        (FIRST, "1", 30.0, None, False),
        (FIRST, "1", 20.0, None, True),
        ({**ALL, "from": 30.0}, "1", None, 30.0, False),
        ({"recordings": [{**ALL, "sha256": "0"}, ALL]}, "1", None, None, True),
    ],
)
def test_the_same_samples(origin, sha256, start, end, used):
    assert was_used(origin, sha256, start, end) == used


def test_a_result_of_parts_of_two_recordings(orbident: Orbident):
    """A RUN of several recordings is read by all verbs that take one."""
    robot = load_robot("paper-spatial")
    motion = random_motion(robot, duration=20.0)
    for seed in (1, 2):
        recording = simulate(robot, motion, noise="sensors", seed=seed)
        write_recording(recording, f"r{seed}.csv")
    part = ("--from", 0.5, "--to", 19.25)
    orbident("identify", "paper-spatial", "r1.csv", "r2.csv", *part, "-o", "run").done()
    ran = orbident("validate", "run", "r2.csv").done()
    assert "run was identified from r2.csv" in ran.out
    orbident("report", "run", "--force").done()
    orbident("export", "run", "-o", "parameters.csv").done()


def test_it_is_said(orbident: Orbident):
    robot = load_robot("paper-spatial")
    recording = simulate(robot, random_motion(robot, duration=20.0), noise="sensors")
    write_recording(recording, "r.csv")
    orbident("identify", "paper-spatial", "r.csv", "-o", "run").done()
    ran = orbident("validate", "run", "r.csv").done()
    assert "run was identified from r.csv, so its errors say little" in ran.out
    orbident("report", "run", "--force").done()
