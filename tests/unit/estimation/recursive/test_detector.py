"""The detector alone, on numbers whose distribution is known."""

import numpy as np
import pytest
from scipy.stats import chi2

from orbident.estimation.estimate import Change
from orbident.estimation.recursive.history import COLOUR, Detector


def watched(detector: Detector, white: np.ndarray) -> Change | None:
    watch = detector.start()
    for k, row in enumerate(white):
        watch, _, change = detector.step(watch, 0.05 * k, row)
        if change is not None:
            return change
    return None


def test_its_statistic_is_the_largest_over_all_onsets():
    """Against the definition, sum by sum."""
    detector = Detector(rows=3, window=7)
    white = np.random.default_rng(0).standard_normal((40, 3))
    watch = detector.start()
    for k, row in enumerate(white):
        watch, ratio, _ = detector.step(watch, float(k), row)
        obvious = max(
            np.sum(white[j : k + 1].sum(axis=0) ** 2) / (k + 1 - j)
            for j in range(max(0, k - 6), k + 1)
        )
        # Sums that run on round at 1e-15 of their size.
        assert ratio * detector.threshold == pytest.approx(obvious, rel=1e-10)


def test_white_noise_raises_alarms_as_seldom_as_was_asked():
    """One in a hundred is asked for, without the margin for coloured noise."""
    detector = Detector(rows=6, false_alarms=COLOUR * 0.01, samples=200)
    each = 0.01 / (200 * detector.window)
    detector.__dict__["threshold"] = float(chi2.isf(each, 6))
    random = np.random.default_rng(0)
    runs = 100
    alarms = sum(
        watched(detector, random.standard_normal((200, 6))) is not None
        for _ in range(runs)
    )
    # The sum over all tests is a bound: one alarm in 100 at most, 3 more by chance.
    assert alarms <= 4


@pytest.mark.parametrize("shift", [3.0, -10.0])
def test_a_shift_is_found_and_dated(shift: float):
    white = np.random.default_rng(1).standard_normal((400, 6))
    white[200:, 1] += shift
    change = watched(Detector(rows=6), white)
    assert change is not None
    # A shift of 3 takes some ten samples; its onset is off by a few.
    assert 10.0 <= change.t <= 11.0
    assert change.onset == pytest.approx(10.0, abs=0.2)
    assert change.statistic > 1.0
    assert 1.0 - 1e-4 <= change.confidence <= 1.0


def test_no_measurement_is_no_change():
    assert watched(Detector(rows=6), np.zeros((100, 6))) is None
