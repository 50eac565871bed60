"""The times at which a motion is sampled."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.simulation.simulate import sample_times


def test_the_end_of_the_motion_is_sampled():
    # 0.3 / 0.1 is a little less than 3.
    np.testing.assert_allclose(sample_times(0.3, 10.0), [0.0, 0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("duration", "rate", "remedy"),
    [(400_000.0, 10.0, "sample slower"), (1.0, 0.1, "sample faster")],
)
def test_too_many_or_too_few_samples(duration: float, rate: float, remedy: str):
    """Two million take 1.6 GB; they are refused before any is made."""
    with pytest.raises(InputError, match=rf"give 2 to 2e\+06: {remedy}"):
        sample_times(duration, rate)
