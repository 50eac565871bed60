"""The study of a real table: what flies, and what three ways of reading make of it."""

from pathlib import Path

import numpy as np
import pytest

from orbident.report.study_page import write_study_report
from orbident.robot.units import STANDARD_GRAVITY
from orbident.studies import table_flights
from orbident.studies.planar import planar_trajectory
from orbident.studies.run_table import FAR, TableStudy, run_table
from orbident.trajectories.environment import Environment


@pytest.fixture(scope="module")
def slow_sensors() -> TableStudy:
    """A fifth of the samples: seconds instead of a minute."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(table_flights.SENSORS, "rate", 10.0)
        return run_table(first_seed=3)


def test_the_wheel_spins_up_from_rest_by_a_torque_that_ends():
    robot = table_flights.table_robot()
    flight = table_flights.fly_table(robot, planar_trajectory(robot))
    assert not flight.v_S[0].any()
    assert not flight.qd_rw[0].any()
    spun_up = flight.t > table_flights.SPIN_UP
    assert np.abs(flight.tau_rw).max() < 0.05
    assert np.abs(flight.tau_rw[spun_up]).max() < 1e-12
    # Against the inertial frame the rotor turns as fast as the paper's.
    rotor = flight.qd_rw[:, 0] + flight.w[:, 2]
    np.testing.assert_allclose(rotor[spun_up], -170.0, rtol=1e-6)


def test_what_a_result_may_name_is_what_the_table_does():
    """At the CM's first place, the pull is that of the environment there."""
    robot = table_flights.table_robot()
    given = table_flights.table_environment(robot)
    flight = table_flights.fly_table(robot, planar_trajectory(robot))
    true = table_flights.truly_acting(robot, flight)
    x, y, _ = flight.r_cm[0]
    assert given.tilt is not None
    expected = STANDARD_GRAVITY * given.tilt[0] + 8e-5 * x - 5e-5 * y
    assert true["pull.x"] == pytest.approx(expected, rel=1e-12)
    assert true["drag.base"] == 8e-3
    assert isinstance(given, Environment)


def test_the_papers_method_is_far_off_and_likelihood_with_what_acts_is_not(
    slow_sensors: TableStudy,
):
    errors = {
        name: np.array([abs(row.error_percent) for row in rows])
        for name, rows in slow_sensors.methods.items()
    }
    # The mass is the last: the paper's is off by half of it, and it says so.
    assert errors["paper"][-1] > 20
    assert slow_sensors.refused
    assert errors["without"][-1] > 20
    assert errors["with"][-1] < 3
    assert np.median(errors["with"]) < np.median(errors["paper"]) / 20
    assert {"pull.x", "drag.base"} <= {each.name for each in slow_sensors.acted}


def test_what_is_accepted_is_right(slow_sensors: TableStudy):
    if slow_sensors.result.status == "ok":
        sigmas = [row.sigmas for row in slow_sensors.methods["with"]]
        assert np.abs(sigmas).max() < FAR
    assert slow_sensors.trusted == (slow_sensors.result.status == "ok")


def test_it_is_shown(slow_sensors: TableStudy, tmp_path: Path):
    path = write_study_report(
        slow_sensors, slow_sensors.result, "Study: table", tmp_path
    )
    page = path.read_text()
    for words in ("A real table", "as if nothing acted", "What acted", "drag.base"):
        assert words in page
    document = slow_sensors.to_json()
    assert set(document["by_method"]) == {"paper", "without", "with"}
    assert document["by_method"]["with"][-1]["name"] == "M"
