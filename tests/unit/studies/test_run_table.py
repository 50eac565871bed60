"""The study of a real table: what flies, and what three ways make of it."""

from pathlib import Path

import numpy as np
import pytest

from orbident.campaigns.seeds import SeedRuns
from orbident.excitation.guarantee import extremes_of
from orbident.excitation.scores import compare_trajectories
from orbident.report.study_page import write_study_report
from orbident.robot.units import STANDARD_GRAVITY
from orbident.studies import run_table as table_study
from orbident.studies.paper_tables import planar_trajectory
from orbident.studies.run_table import FAR, TableStudy, run_table
from orbident.studies.spatial import paper_case


@pytest.fixture(scope="module")
def slow_sensors() -> TableStudy:
    """A fifth of the samples: seconds instead of a minute."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(table_study.SENSORS, "rate", 10.0)
        return run_table(SeedRuns(first=3))


def test_the_wheel_spins_up_from_rest_by_a_torque_that_ends():
    robot = table_study.table_robot()
    flight = table_study.fly_table(robot, planar_trajectory(robot))
    assert not flight.v_S[0].any()
    assert not flight.qd_rw[0].any()
    spun_up = flight.t > table_study.SPIN_UP
    assert np.abs(flight.tau_rw).max() < 0.05
    assert np.abs(flight.tau_rw[spun_up]).max() < 1e-12
    # Against the inertial frame the rotor turns as fast as the paper's.
    rotor = flight.qd_rw[:, 0] + flight.w[:, 2]
    np.testing.assert_allclose(rotor[spun_up], -170.0, rtol=1e-6)


def test_what_a_result_may_name_is_what_the_table_does():
    """At the CM's first place, the pull is that of the environment there."""
    robot = table_study.table_robot()
    motion, _ = table_study.table_motions(robot)
    given = motion.environment
    true = table_study.truly_acting(robot, motion)
    x, y, _ = table_study.fly_table(robot, planar_trajectory(robot)).r_cm[0]
    assert given is not None
    assert given.tilt is not None
    expected = STANDARD_GRAVITY * given.tilt[0] + 8e-5 * x - 5e-5 * y
    assert true["pull.x"] == pytest.approx(expected, rel=1e-12)
    assert true["drag.base"] == 8e-3


def test_our_motion_is_designed_for_a_table():
    """Within the paper's limits, and worth what a search said of it."""
    robot = table_study.table_robot()
    case = paper_case(robot)
    paper, ours = table_study.table_motions(robot)
    assert ours.duration == paper.duration
    np.testing.assert_array_equal(ours.start, case.conditions.start)
    np.testing.assert_array_equal(ours.end, case.conditions.end)
    assert ours.design is not None
    joints = extremes_of(ours)
    assert (joints.velocity <= case.conditions.limits.velocity).all()
    scores = compare_trajectories(robot, [[case.trajectory], [ours]]).scores
    assert scores[1].d == pytest.approx(ours.design["value"], rel=1e-3)
    assert (scores[0].price or 0) > 50 * (scores[1].price or np.inf)


@pytest.mark.slow
def test_the_papers_method_is_far_off_and_our_motion_is_best(
    slow_sensors: TableStudy,
):
    errors = {
        name: np.array([abs(row.error_percent) for row in rows])
        for name, rows in slow_sensors.methods.items()
    }
    # The mass is the last: the paper's is off by half of it, and it says so.
    assert errors["paper"][-1] > 20
    assert slow_sensors.refused
    assert errors["with"][-1] < 10
    assert errors["ours"].max() < 10
    assert np.median(errors["with"]) < np.median(errors["paper"]) / 20
    worst = {
        way: max(row.std_percent for row in slow_sensors.methods[way])
        for way in ("with", "ours")
    }
    assert worst["ours"] < worst["with"] / 10
    acted = {each.name: each for each in slow_sensors.acted}
    assert {"pull.x", "drag.base"} <= acted.keys()
    assert max(abs(each.sigmas) for each in acted.values()) < FAR


@pytest.mark.slow
def test_what_is_accepted_is_right(slow_sensors: TableStudy):
    assert slow_sensors.trusted
    for way in ("with", "ours"):
        sigmas = [row.sigmas for row in slow_sensors.methods[way]]
        assert np.abs(sigmas).max() < FAR


@pytest.mark.slow
def test_it_is_shown(slow_sensors: TableStudy, tmp_path: Path):
    path = write_study_report(
        slow_sensors, slow_sensors.result, "Study: table", tmp_path
    )
    page = path.read_text()
    shown = (
        "A real table",
        "Our motion, maximum likelihood",
        "What acted",
        "drag.base",
    )
    for words in shown:
        assert words in page
    document = slow_sensors.to_json()
    assert set(document["by_method"]) == {"paper", "with", "ours"}
    assert document["by_method"]["ours"][-1]["name"] == "M"
