"""By how much chi-square falls where a number may be off by more than its tolerance."""

import numpy as np
import pytest

from orbident.estimation.unknowns import TOLD, CalibrationFit


@pytest.mark.parametrize("std", [0.1, 1.0, 2.0])
def test_it_is_how_far_the_recording_is_from_what_was_known(std: float):
    """A recording alone says 5 with deviation `std`; beforehand it is 0 within 1."""
    alone, tolerance = 5.0, 1.0
    left = 1 / np.hypot(1 / std, 1 / tolerance)
    fit = CalibrationFit(alone * (left / std) ** 2, left, tolerance)
    of_both = fit.value**2 + ((fit.value - alone) / std) ** 2
    assert fit.beyond_tolerance == pytest.approx(of_both)


def test_what_a_recording_hardly_tells_is_not_beyond():
    fit = CalibrationFit(0.01, 1.0 - 1e-9, 1.0)
    assert fit.beyond_tolerance == pytest.approx(1e-4 / TOLD)
