import numpy as np
import pytest

from orbident.errors import InputError
from orbident.robot.sensor_schema import Sampled
from orbident.simulation.sensor import sensor_columns

T = np.arange(1001) / 100.0
TRUE = np.column_stack([np.sin(T), np.cos(2 * T)])


def random(seed=0):
    return np.random.default_rng(seed)


def exact(true, dt, random):
    """A sensor without noise, to look at when sensors sample."""
    del dt, random
    return true


def test_a_sensor_without_a_rate_samples_every_row():
    np.testing.assert_array_equal(
        sensor_columns(Sampled(), T, TRUE, random(), exact), TRUE
    )


@pytest.mark.parametrize(("rate", "stride"), [(100.0, 1), (50.0, 2), (100 / 7, 7)])
def test_a_sample_on_every_kth_row_and_nan_elsewhere(rate, stride):
    shown = sensor_columns(Sampled(rate=rate), T, TRUE, random(), exact)
    expected = np.full_like(TRUE, np.nan)
    expected[::stride] = TRUE[::stride]
    np.testing.assert_array_equal(shown, expected)


def test_the_interval_given_to_the_noise_is_the_sensors_own():
    intervals = []

    def read(true, dt, random):
        intervals.append(dt)
        return true

    sensor_columns(Sampled(rate=20.0), T, TRUE, random(), read)
    sensor_columns(Sampled(), T, TRUE, random(), read)
    np.testing.assert_allclose(intervals, [0.05, 0.01], rtol=1e-12)


@pytest.mark.parametrize("rate", [30.0, 200.0, 99.0])
def test_a_rate_that_does_not_fit_the_rows_is_refused(rate):
    with pytest.raises(InputError, match=r"rate: found .* Hz, but .* has 100 rows"):
        sensor_columns(Sampled(rate=rate), T, TRUE, random(), exact)


def test_uneven_rows_are_refused():
    t = T.copy()
    t[5] += 1e-3
    with pytest.raises(InputError, match=r"rows are 0.009 to 0.011 s apart"):
        sensor_columns(Sampled(), t, TRUE, random(), exact)


@pytest.mark.parametrize("latency", [0.01, 0.033, 0.25])
def test_latency_shows_what_was(latency):
    shown = sensor_columns(
        Sampled(latency=latency, rate=50.0), T, TRUE, random(), exact
    )[::2]
    then = T[::2] - latency
    known = then >= 0
    expected = np.column_stack([np.sin(then), np.cos(2 * then)])[known]
    # Of a cubic spline: 5/384 h^4 x'''' inside, some times that at its ends.
    np.testing.assert_allclose(shown[known], expected, rtol=0, atol=1e-7)
    assert np.isnan(shown[~known]).all()


def test_latency_needs_some_rows():
    with pytest.raises(InputError, match="latency: needs at least 4 rows, found 3"):
        sensor_columns(Sampled(latency=0.1), T[:3], TRUE[:3], random(), exact)


def test_drop_outs_take_whole_samples_at_their_probability():
    t = np.arange(20_000) / 100.0
    shown = sensor_columns(
        Sampled(drop_out=0.2), t, np.ones((t.size, 3)), random(1), exact
    )
    lost = np.isnan(shown)
    assert (lost.all(axis=1) == lost.any(axis=1)).all()
    # 20 000 samples: std 0.28 %.
    assert lost[:, 0].mean() == pytest.approx(0.2, abs=0.012)
    # Independent: losses follow losses as often as anything else.
    after = lost[1:, 0][lost[:-1, 0]]
    assert after.mean() == pytest.approx(0.2, abs=0.025)


@pytest.mark.parametrize(("drop_out", "left"), [(0.0, 1001), (1.0, 0)])
def test_certain_drop_outs(drop_out, left):
    shown = sensor_columns(Sampled(drop_out=drop_out), T, TRUE, random(), exact)
    assert np.isfinite(shown[:, 0]).sum() == left
