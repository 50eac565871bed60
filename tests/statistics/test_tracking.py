"""Tracking with models identified with the paper's noise, over seeds."""

import pytest

from orbident.campaigns.seeds import SeedRuns
from orbident.studies.control import FACTOR, run_control

pytestmark = pytest.mark.long


def test_tracking_is_five_times_better_with_every_seed():
    done = run_control("paper", SeedRuns(5))
    assert done.rejected == 0
    assert done.factor >= FACTOR
    assert done.trusted
