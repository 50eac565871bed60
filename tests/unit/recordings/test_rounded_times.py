"""Times that were kept as float32."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.recordings.column_checks import float32_step
from orbident.recordings.recording import Recording

WEEK = 604_800.0
T = np.arange(200) * 0.2


def test_a_week_in_float32_has_steps_of_a_sixteenth():
    assert float32_step((WEEK + T).astype(np.float32).astype(float)) == 1 / 16


@pytest.mark.parametrize(
    "t", [WEEK + T, T.astype(np.float32).astype(float), np.arange(60.0)[::-1] ** 2]
)
def test_times_that_are_exact_enough(t):
    assert float32_step(t) == 0.0


def test_times_that_float32_holds_exactly():
    """Sixteen a second, one row in fifty lost."""
    t = WEEK + np.delete(np.arange(500), np.arange(20, 500, 50)) / 16
    assert float32_step(t) == 0.0


def test_rows_that_float32_made_one_are_named_so():
    t = (WEEK + T / 10).astype(np.float32).astype(float)
    with pytest.raises(InputError, match=r"as float32, in steps of 0\.062 s: write"):
        Recording(t, {})
