"""A base that goes on while nothing is recorded, and joints of which nobody then knows
what they did."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import clean_space

import orbident as oi
from orbident.preprocessing.rates import gaps_as_rows, through_gaps

FAR = 5.0
"""Deviations: of a normal error beyond them there is one in two million."""


@pytest.mark.parametrize("seconds", [0.5, 3.0, 9.0])
def test_rows_that_are_not_there_spoil_nothing(seconds: float):
    """No row is there, as where a logger stopped; and the true robot comes out."""
    recorded = clean_space(seed=1)
    whole = recorded.recording
    kept = (whole.t < 30.0) | (whole.t > 30.0 + seconds)
    columns = {name: x[kept] for name, x in whole.columns.items()}
    gap = replace(whole, t=whole.t[kept], columns=columns)
    result = oi.identify(recorded.robot, gap)
    assert result.status == "ok", result.refusal()
    assert np.abs(recorded.z(result)).max() < FAR


def test_joints_that_nobody_saw_are_as_uncertain_as_they_are():
    """Encoders fail for 9 s, in which joints may have moved in any way."""
    recorded = clean_space(seed=1)
    whole = recorded.recording
    fails = (whole.t > 30.0) & (whole.t < 39.0)
    gap = whole.with_columns(
        {
            name: np.where(fails, np.nan, x)
            for name, x in whole.columns.items()
            if name.startswith("joint.")
        }
    )
    result = oi.identify(recorded.robot, gap)
    assert result.status == "ok", result.refusal()
    assert np.abs(recorded.z(result)).max() < FAR


def test_rows_in_gaps_are_as_far_apart_as_others():
    t = np.r_[0:3:0.1, 5:8:0.1]
    more = through_gaps(t)
    assert np.isin(t, more).all()
    np.testing.assert_allclose(np.diff(more), 0.1, rtol=0.02)


def test_nothing_is_added_where_nothing_is_missing():
    recording = clean_space(seed=1, duration=10.0).recording
    assert gaps_as_rows(recording) is recording


def test_a_clock_that_was_set_anew_is_no_gap_to_fill():
    """A year in milliseconds would need all memory there is."""
    t = np.r_[np.arange(100) / 1e3, 3e7 + np.arange(100) / 1e3]
    assert through_gaps(t) is t
