"""A report says first what the checks say, and adds nothing."""

import report_runs

from orbident.report.verdict import verdict_of


def test_refused():
    found = report_runs.rejected()
    said = verdict_of(found)
    assert said.level == "do not trust"
    assert said.headline == "Do not trust it"
    assert said.mass == ""
    assert said.checks == found.checks
    assert any("record one of them" in check.words for check in said.checks)


def test_linear_deviations_are_for_white_noise():
    said = verdict_of(report_runs.result())
    assert said.level == "with care"
    assert said.style == "with-care"
    assert said.mass.endswith(" kg)")
    assert any("takes the noise for white" in check.words for check in said.checks)
