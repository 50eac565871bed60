import numpy as np
import pytest
from fixed_sensor import Exact

from orbident.errors import InputError

T = np.arange(1001) / 100.0
TRUE = np.column_stack([np.sin(T), np.cos(2 * T)])


def random(seed=0):
    return np.random.default_rng(seed)


def test_a_sensor_without_a_rate_samples_every_row():
    np.testing.assert_array_equal(Exact().sample(T, TRUE, random()), TRUE)


@pytest.mark.parametrize(("rate", "stride"), [(100.0, 1), (50.0, 2), (100 / 7, 7)])
def test_a_sample_on_every_kth_row_and_nan_elsewhere(rate, stride):
    shown = Exact(rate=rate).sample(T, TRUE, random())
    expected = np.full_like(TRUE, np.nan)
    expected[::stride] = TRUE[::stride]
    np.testing.assert_array_equal(shown, expected)


def test_the_interval_given_to_the_noise_is_the_sensors_own():
    intervals = []

    def read(true, dt, random):
        intervals.append(dt)
        return true

    Exact(rate=20.0).sample(T, TRUE, random(), read)
    Exact().sample(T, TRUE, random(), read)
    np.testing.assert_allclose(intervals, [0.05, 0.01], rtol=1e-12)


@pytest.mark.parametrize("rate", [30.0, 200.0, 99.0])
def test_a_rate_that_does_not_fit_the_rows_is_refused(rate):
    with pytest.raises(InputError, match=r"rate: found .* Hz, but .* has 100 rows"):
        Exact(rate=rate).sample(T, TRUE, random())


def test_uneven_rows_are_refused():
    t = T.copy()
    t[5] += 1e-3
    with pytest.raises(InputError, match=r"rows are 0.009 to 0.011 s apart"):
        Exact().sample(t, TRUE, random())


@pytest.mark.parametrize("latency", [0.01, 0.033, 0.25])
def test_latency_shows_what_was(latency):
    shown = Exact(latency=latency, rate=50.0).sample(T, TRUE, random())[::2]
    then = T[::2] - latency
    known = then >= 0
    expected = np.column_stack([np.sin(then), np.cos(2 * then)])[known]
    # Of a cubic spline: 5/384 h^4 x'''' inside, some times that at its ends.
    np.testing.assert_allclose(shown[known], expected, rtol=0, atol=1e-7)
    assert np.isnan(shown[~known]).all()


def test_latency_needs_some_rows():
    with pytest.raises(InputError, match="latency: needs at least 4 rows, found 3"):
        Exact(latency=0.1).sample(T[:3], TRUE[:3], random())


def test_drop_outs_take_whole_samples_at_their_probability():
    t = np.arange(20_000) / 100.0
    shown = Exact(drop_out=0.2).sample(t, np.ones((t.size, 3)), random(1))
    lost = np.isnan(shown)
    assert (lost.all(axis=1) == lost.any(axis=1)).all()
    # 20 000 samples: std 0.28 %.
    assert lost[:, 0].mean() == pytest.approx(0.2, abs=0.012)
    # Independent: losses follow losses as often as anything else.
    after = lost[1:, 0][lost[:-1, 0]]
    assert after.mean() == pytest.approx(0.2, abs=0.025)


@pytest.mark.parametrize(("drop_out", "left"), [(0.0, 1001), (1.0, 0)])
def test_certain_drop_outs(drop_out, left):
    shown = Exact(drop_out=drop_out).sample(T, TRUE, random())
    assert np.isfinite(shown[:, 0]).sum() == left


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rate": 0.0}, "rate: found 0.0; give a number above zero"),
        ({"latency": -0.1}, "latency: found -0.1; give a number of zero or more"),
        ({"latency": np.inf}, "latency: found inf; give a finite number"),
        ({"latency": np.nan}, "latency: found nan"),
        ({"drop_out": 1.5}, "drop_out: found 1.5; give a probability"),
        ({"drop_out": True}, "drop_out: found True"),
    ],
)
def test_bad_values_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Exact(**given)
