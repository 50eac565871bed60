import math

import numpy as np
import pytest

from orbident.preprocessing.histories import histories
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.smoothing import Settings
from orbident.recordings.recording import Recording
from orbident.robot.sensor_schema import EncoderSpec

T = np.arange(400) * 0.01


def wheel(late=0.0, **columns):
    named = {f"wheel.rw.{name}": column for name, column in columns.items()}
    return histories(
        Recording(T, named), "wheel", ("rw",), "speed", None, late, Settings()
    )


@pytest.mark.parametrize("measured", [True, False])
def test_late_encoders_are_read_later(measured):
    columns = {"position": np.sin(T)} | ({"speed": np.cos(T)} if measured else {})
    found = wheel(late=0.035, **columns)
    rate = found.rates[0]
    inside = np.isfinite(rate)
    # Nothing is known of what comes after the last sample.
    assert not inside[-3:].any()
    assert inside[:-4].all()
    np.testing.assert_allclose(rate[inside], np.cos(T + 0.035)[inside], atol=1e-6)
    assert found.origin == (Origin.MEASURED if measured else Origin.SMOOTHED_POSITIONS)


def test_noise_is_declared_where_counts_hide_it():
    assert EncoderSpec(position=1e-3).unseen_std is None
    counts = EncoderSpec(position=3e-3, resolution=4e-3 * math.sqrt(12))
    assert counts.unseen_std == pytest.approx(5e-3)


def test_four_samples_tell_no_noise():
    """Nor a share of it, and there is no warning of NumPy's."""
    few = Recording(T[:4], {"wheel.rw.position": np.array([0.0, 1.0, 1.5, 3.0])})
    found = histories(few, "wheel", ("rw",), "speed", None, 0.0, Settings())
    assert np.isnan(found.shares).all()
