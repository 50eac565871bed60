"""`orbident sample`."""

import csv
from pathlib import Path

import numpy as np
import pytest
import yaml

from orbident.trajectories.trajectory_file import load_trajectory


def test_sample_as_a_table(orbident, table_5):
    orbident("sample", table_5, "-o", "table.csv", "--rate", 10).done()
    with Path("table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 201
    t = 12.3
    q, qd, qdd = load_trajectory(table_5).at(np.array([t]))
    row = rows[123]
    assert float(row["t"]) == pytest.approx(t, abs=1e-12)
    for kind, values in (("position", q), ("velocity", qd), ("acceleration", qdd)):
        for k, joint in enumerate(("joint1", "joint2")):
            assert float(row[f"joint.{joint}.{kind}"]) == pytest.approx(
                values[0, k], abs=1e-12
            )


def test_sample_for_ros(orbident, table_5):
    ran = orbident(
        *("sample", table_5, "-o", "joints.yaml", "--rate", 0.3),
        *("--format", "joint-trajectory", "--json", "-"),
    ).done()
    # 0, 3.33 .. 16.67, 20: the end is in it even where the rate misses it.
    assert ran.json["samples"] == 7
    message = yaml.safe_load(Path("joints.yaml").read_text())
    assert message["joint_names"] == ["joint1", "joint2"]
    points = message["points"]
    assert points[1]["time_from_start"] == {"sec": 3, "nanosec": 333333333}
    assert points[-1]["time_from_start"] == {"sec": 20, "nanosec": 0}
    assert all(len(point["positions"]) == 2 for point in points)


def test_a_sample_rate_that_makes_no_sense(orbident, table_5):
    orbident("sample", table_5, "-o", "t.csv", "--rate", 0).refused("rate")
    orbident("sample", table_5, "-o", "t.txt", "--rate", 1).refused(".txt")
