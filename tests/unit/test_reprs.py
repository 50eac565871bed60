"""What a session shows of an object: a few lines that say what it is, no arrays."""

import inspect
from pathlib import Path
from typing import get_args

import numpy as np
import report_runs

import orbident as oi
from orbident.estimation.budget import SensitivityTable
from orbident.estimation.quantities import Quantity

LINES, LONGEST = 24, 1500
"""A terminal's screen, and what a notebook's cell shows without scrolling."""


def shown(thing: object) -> str:
    text = repr(thing)
    assert len(text.splitlines()) < LINES
    assert len(text) < LONGEST
    assert "array(" not in text
    return text


def test_the_version():
    assert oi.__version__.count(".") == 2


def test_what_public_functions_return_is_public():
    for name in dir(oi):
        thing = getattr(oi, name)
        if not inspect.isfunction(thing):
            continue
        returned = inspect.signature(thing).return_annotation
        for kind in (returned, *get_args(returned)):
            if getattr(kind, "__module__", "").startswith("orbident."):
                assert getattr(oi, kind.__name__) is kind


def test_a_robot_and_its_sets():
    robot = oi.load_robot("dual-arm")
    assert shown(robot).startswith("dual-arm: spatial")
    assert "496 pi" in shown(oi.minimal_sets(robot))


def test_a_recording_and_a_trajectory():
    robot, recording = report_runs.flown()
    assert "401 rows" in shown(recording)
    none = np.zeros((len(robot.joints), 3))
    trajectory = oi.Trajectory(10.0, robot.joint_names, none, none, none, none)
    assert shown(trajectory) == (
        "trajectory: 10 s, 3 harmonics, joints 'joint1', 'joint2', 'joint3'"
    )
    assert shown(oi.Environment(gravity_gradient=False)) == "Environment()"
    acting = oi.Environment(tilt=(0.001, 0.0))
    assert shown(acting) == "Environment(tilt=(0.001, 0.0))"


def test_a_result_and_what_is_in_it():
    result = report_runs.result()
    assert shown(result).endswith(".plot")
    assert shown(result.pi).endswith("11 more: .names, .values, .std, .formulas")
    assert shown(result.mass_forms).startswith("M from pi_13 ")
    assert shown(Quantity(1110.4440, 0.3713)) == "1110.44 +- 0.37"
    assert shown(result.signals()[0]).startswith("momentum: x (N m s), y (N m s)")
    assert shown(result.checks[0]).count("\n") == 0
    assert "over v_cm, w, 3 joints and 3 wheels" in shown(result.dynamics())
    table = SensitivityTable(
        ("M", "sigma_1"), ("gyro.scale.x",), ("%",), np.array([[1.0], [-20.0]])
    )
    assert shown(table) == (
        "2 parameters, 1 errors; 1 % of gyro.scale.x shifts sigma_1 most, by 20 of its "
        "deviations"
    )


def test_what_is_made_of_results():
    _, recording = report_runs.flown()
    result = report_runs.result()
    assert "401 samples: explained" in shown(oi.validate(result, recording))
    assert shown(oi.compare(result, result)).startswith("no change: ")
    rejected = oi.compare(result, report_runs.rejected())
    assert shown(rejected).startswith("rejected: ")


def test_topics_of_a_file(tmp_path: Path):
    (tmp_path / "log.csv").write_text("t,x\n0,1\n1,2\n")
    [topic] = oi.survey_file(tmp_path / "log.csv")
    assert isinstance(topic, oi.Surveyed)
    shown(topic)


def test_a_file_that_was_converted(tmp_path: Path):
    rows = "".join(f"{t},{t}\n" for t in range(4))
    (tmp_path / "log.csv").write_text(f"t,w\n{rows}")
    (tmp_path / "map.yaml").write_text(
        "schema: orbident/topic-map/1\n"
        "topics:\n"
        "  - {topic: /, type: table, stamp: {t: s}, take: {gyro.z: rad/s},\n"
        "     fields: {gyro.z: w}, frame: base}\n"
    )
    report = oi.convert_file(
        tmp_path / "log.csv", tmp_path / "map.yaml", tmp_path / "flight.csv"
    )
    log = tmp_path / "log.csv"
    assert shown(report).startswith(f"{log}: 4 samples over 3 s from / (4)")


def test_a_run_is_kept_where_a_text_says(tmp_path: Path):
    result = report_runs.result()
    place = str(tmp_path / "run")
    oi.save_result(result, place)
    assert repr(oi.load_result(place)) == repr(result)
