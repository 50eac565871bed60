"""Clean recordings are screened and lose nothing; all are tried in the long run."""

import numpy as np
import pytest
from random_flights import flight, flights, flyers, recorded

from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording

FLIGHTS = [*flights(), *flyers()]


@pytest.mark.parametrize(
    "name",
    [
        name if k % 6 == 0 else pytest.param(name, marks=pytest.mark.long)
        for k, name in enumerate(FLIGHTS)
    ],
)
def test_what_is_clean_is_left_as_it_is(name: str):
    clean = flight(name)
    recording = recorded(clean, 0).recording
    printed = {name: np.round(x, 4) for name, x in recording.columns.items()}
    for shown in (recording, Recording(recording.t, printed)):
        found = screened(clean.robot, shown)
        assert found.recording is shown
        assert (found.notes, found.rejected) == ((), {})
