"""The verdict says what the result says of itself."""

from dataclasses import replace

import numpy as np
import report_runs

from orbident.report.verdict import judgement


def test_rejected():
    found = report_runs.rejected()
    said = judgement(found, found.signals())
    assert said.level == "no"
    assert said.headline == "Do not trust it"
    assert said.mass == ""
    assert any("record one of them" in warning for warning in said.warnings)


def test_linear_deviations_are_for_white_noise():
    found = report_runs.result()
    said = judgement(found, found.signals())
    assert said.level == "care"
    assert said.mass.endswith(" kg)")
    assert any("takes the noise for white" in check.words for check in said.checks)


def _likely(**changes):
    sensors = {
        "gyro": {
            **{"rms": 1e-5, "noise": 1e-5, "declared": 1e-5, "samples": 400},
            "whiteness": 0.02,
        }
    }
    residual = {"rms": {"gyro": 1e-5}, "chi2_per_dof": 1.01, "sensors": sensors}
    found = replace(
        report_runs.result(), method="maximum-likelihood", residual=residual
    )
    return replace(found, **changes)


def test_all_is_well():
    found = _likely()
    said = judgement(found, found.signals())
    assert said.level == "yes"
    assert all(check.good for check in said.checks)


def test_a_doubt_is_enough():
    base = report_runs.result().base
    unknown = np.where(np.arange(base.values.size) == 3, np.nan, base.values)
    residual = {**_likely().residual, "chi2_per_dof": 9.0}
    for found, words in (
        (_likely(base=replace(base, values=unknown)), "1 of"),
        (_likely(residual=residual), "3.0 times as large as the noise"),
        (_likely(condition_number={"Y_normalised": 1e5}), "hardly excited"),
    ):
        said = judgement(found, found.signals())
        assert said.level == "care"
        assert any(words in check.words for check in said.checks if not check.good)
    warned = _likely(warnings=("clock late",))
    assert judgement(warned, ()).level == "care"
