"""A report says first what the checks say, and adds nothing."""

import report_runs

from orbident.report.page import verdict_of


def test_refused():
    found = report_runs.rejected()
    said = verdict_of(found)
    assert said.level == "do not trust"
    assert said.headline == "Refused"
    assert said.mass == ""
    assert said.checks == found.checks
    assert any("record one of them" in check.words for check in said.checks)


def test_a_linear_fit_is_judged_by_what_the_sensors_show():
    said = verdict_of(report_runs.result())
    assert said.level == "trust"
    assert said.mass.endswith(" kg)")
    (agreement,) = (check for check in said.checks if check.name == "agreement")
    assert agreement.passed
    assert agreement.statistic < agreement.limit
    assert {"whiteness of gyro", "instruments"} <= {check.name for check in said.checks}
