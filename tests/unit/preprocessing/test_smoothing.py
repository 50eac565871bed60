import sys

import numpy as np
import pytest
from processes import finished
from reference.dense_spline import DenseSpline
from scipy.linalg import expm
from scipy.stats import chi2

from orbident.errors import InputError
from orbident.preprocessing.rates import spline_rates
from orbident.preprocessing.smoothing import Column, most_likely, smooth
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

ENCODER = 2.5e-5
"""rad, Section 3.5."""


def random(seed=0):
    return np.random.default_rng(seed)


def irregular(n=60, gap=(2.0, 3.5)):
    t = np.sort(random(1).uniform(0.0, 6.0, n))
    return t[(t < gap[0]) | (t > gap[1])]


def fitted(t, y, std=None):
    """The most likely density of the snap and the noise, per second."""
    h = float(np.quantile(np.diff(t), 0.9))
    fit = most_likely(Column(t, y, h, float(y.mean())), std)
    return fit.ratio * fit.noise_std**2 / h**7, fit.noise_std


def table_2():
    t = np.arange(1601) * 0.05
    q, qd, _ = spatial_trajectory(spatial_robot()).at(t)
    return t, q, qd


@pytest.mark.parametrize("std", [1e-2, None])
def test_equals_dense_regression_at_samples_between_them_and_in_a_gap(std):
    t = irregular()
    y = np.sin(2 * t) + 1e-2 * random(2).standard_normal(t.size)
    at = np.concatenate([t[::-1], random(3).uniform(t[0], t[-1], 30), [2.7]])
    found = smooth(t, y[:, None], std, at)
    q, noise = fitted(t, y, std)
    dense = DenseSpline(t, y, q, noise)
    assert found.noise_std == [noise]
    # The dense matrix has a condition of 1e8 or so; a gap's std is far from zero.
    for a, name in enumerate(("x", "rate", "acceleration")):
        expected = dense.mean(a, at)
        np.testing.assert_allclose(
            getattr(found, name)[:, 0], expected, atol=1e-6 * np.abs(expected).max()
        )
    for a, name in enumerate(("std_x", "std_rate")):
        np.testing.assert_allclose(
            getattr(found, name)[:, 0], dense.std(a, at), rtol=1e-6
        )


def test_the_density_is_the_most_likely_one():
    t = irregular()
    y = np.sin(2 * t) + 1e-2 * random(2).standard_normal(t.size)
    q, _ = fitted(t, y, 1e-2)
    costs = [DenseSpline(t, y, q * 10**k, 1e-2).cost for k in np.linspace(-2, 2, 81)]
    # Costs are -2 log L: 0.05 changes no standard deviation by more than a percent.
    assert DenseSpline(t, y, q, 1e-2).cost < min(costs) + 0.05


def test_the_noise_is_the_most_likely_one():
    t = irregular()
    y = np.sin(2 * t) + 1e-2 * random(2).standard_normal(t.size)
    q, noise = fitted(t, y)
    least = DenseSpline(t, y, q, noise).cost
    for factor in (0.9, 1.1):
        assert DenseSpline(t, y, q * factor**2, noise * factor).cost > least
        assert DenseSpline(t, y, q, noise * factor).cost > least


def test_a_cubic_is_reproduced():
    t = irregular()
    cubic = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.25])
    found = smooth(t, cubic(t)[:, None])
    # Rounding, 1e-16 of values up to 60, through differences of 1e-2 s.
    np.testing.assert_allclose(found.x[:, 0], cubic(t), atol=1e-12)
    np.testing.assert_allclose(found.rate[:, 0], cubic.deriv()(t), atol=1e-11)
    np.testing.assert_allclose(found.acceleration[:, 0], cubic.deriv(2)(t), atol=1e-9)
    assert found.noise_std < 1e-13


def test_without_noise_no_worse_than_a_cubic_spline():
    t, q, qd = table_2()
    found = smooth(t, q)
    np.testing.assert_allclose(found.x, q, atol=1e-12)
    error = np.abs(found.rate - qd).max(axis=0)
    assert (error < np.abs(spline_rates(t, q) - qd).max(axis=0)).all()
    # The encoder that is not there is five orders coarser.
    assert (found.noise_std < 1e-10).all()
    assert np.isfinite(found.std_rate).all()


@pytest.mark.parametrize("std", [ENCODER, None])
def test_encoder_noise_on_table_2(std):
    t, q, qd = table_2()
    y = q + ENCODER * random(4).standard_normal(q.shape)
    found = smooth(t, y, std)

    def rms(error):
        return np.sqrt((error**2).mean(axis=0))

    # 1600 samples know their std to 1.8 %; four times that.
    np.testing.assert_allclose(found.noise_std, ENCODER, rtol=0.07)
    # Measured over 20 seeds: 5.9e-4 rad/s raw, 0.93e-5 to 1.4e-5 smoothed; a factor
    # of 63, 43 and 42 by joint. At the first sample 5.6e-5 to 9.5e-5 rad/s.
    raw = spline_rates(t, y)
    assert (rms(raw - qd) > 35 * rms(found.rate - qd)).all()
    assert (np.abs(found.rate - qd)[0] < 4 * found.std_rate[0]).all()
    # Smoother than white snap: its standard deviation is on the safe side.
    normalised = (((found.rate - qd) / found.std_rate) ** 2).mean()
    assert 0.4 < normalised < 1.0


def white_snap(columns, n, h, q):
    """Draws of the model itself, its transition from matrix exponentials (Van Loan)."""
    A, zero = np.eye(4, k=1), np.zeros((4, 4))
    noise = np.zeros((4, 4))
    noise[3, 3] = q
    both = expm(np.block([[-A, noise], [zero, A.T]]) * h)
    F = both[4:, 4:].T
    root = np.linalg.cholesky(F @ both[:4, 4:])
    states = [np.zeros((4, columns))]
    draws = random(5).standard_normal((n, 4, columns))
    for k in range(1, n):
        states.append(F @ states[-1] + root @ draws[k])
    return np.array(states)


@pytest.mark.parametrize("std", [ENCODER, None])
def test_a_fast_logger_and_slow_motion(std):
    """At 1250 Hz a thousand samples show next to nothing of Table 2's motion."""
    t = np.linspace(0.0, 80.0, 100_001)
    q, qd, _ = spatial_trajectory(spatial_robot()).at(t)
    smoothed = smooth(t, q + ENCODER * random().standard_normal(q.shape), std)
    inner = slice(1000, -1000)
    # Hundreds of samples are averaged; of 1600 in the same time, tens.
    errors = np.std((smoothed.x - q)[inner], axis=0)
    assert errors.max() < ENCODER / 15
    np.testing.assert_allclose(smoothed.std_x[inner].mean(axis=0), errors, rtol=0.3)
    assert np.std((smoothed.rate - qd)[inner], axis=0).max() < 5e-6
    # Found from 4096 samples, within four of its own deviations.
    rtol = 4 / np.sqrt(2 * 4096)
    np.testing.assert_allclose(smoothed.noise_std, ENCODER, rtol=rtol)


def test_a_gap_in_a_fast_log_is_not_averaged_over():
    t = np.linspace(0.0, 80.0, 100_001)
    t = t[(t < 30.0) | (t > 42.0003)]
    q, _, _ = spatial_trajectory(spatial_robot()).at(t)
    smoothed = smooth(t, q + ENCODER * random().standard_normal(q.shape))
    errors = np.std((smoothed.x - q)[1000:-1000], axis=0)
    assert errors.max() < ENCODER / 10


def test_standard_deviations_cover_the_errors():
    columns, n, h, std = 96, 200, 0.1, 0.02
    states = white_snap(columns, n, h, q=4.0)
    t = np.arange(n) * h
    found = smooth(t, states[:, 0] + std * random(6).standard_normal((n, columns)))
    low, high = chi2.ppf([1e-4, 1 - 1e-4], columns)
    for k in (0, 20, 100, 199):
        for error, deviation in (
            (found.x - states[:, 0], found.std_x),
            (found.rate - states[:, 1], found.std_rate),
        ):
            # Density and noise are estimated too, from 200 samples: 5 % beyond chi^2.
            assert low < ((error[k] / deviation[k]) ** 2).sum() < 1.05 * high


def test_columns_are_independent_and_nothing_is_extrapolated():
    t = np.arange(300) * 0.05
    x = np.stack([np.sin(t + k) for k in range(10)], axis=1)
    x += 1e-3 * random(7).standard_normal(x.shape)
    x[:20, 3], x[250:, 3], x[100:180, 3], x[::2, 4] = np.nan, np.nan, np.nan, np.nan
    found = smooth(t, x)
    for k in (0, 3, 9):
        alone = smooth(t, x[:, [k]])
        for name in ("x", "rate", "acceleration", "std_x", "std_rate"):
            np.testing.assert_allclose(
                getattr(found, name)[:, [k]], getattr(alone, name), rtol=1e-9
            )
    outside = (t < t[20]) | (t > t[249])
    for values in (found.x, found.rate, found.acceleration, found.std_x):
        np.testing.assert_array_equal(np.isnan(values[:, 3]), outside)
        assert np.isfinite(values[:, [0, 9]]).all()
    # 80 missing samples of a sine leave far less known in their middle.
    assert found.std_x[140, 3] > 10 * found.std_x[60, 3]


def test_blocks_do_not_show():
    n = 2 * 1024 + 100
    t = np.arange(n) * 0.01
    x = (np.sin(t) + 1e-3 * random(8).standard_normal(n))[:, None]
    once = smooth(t, x)
    # Times between the samples move every boundary.
    again = smooth(t, x, at=np.concatenate([t, t[:1500] + 0.004]))
    for one, other in zip(once[:5], again[:5], strict=True):
        np.testing.assert_allclose(other[:n], one, rtol=1e-7, atol=1e-9)


def test_a_joint_that_stands_still():
    t = np.arange(400) * 0.05
    for value in (0.0, 0.7):
        found = smooth(t, np.full((400, 1), value))
        np.testing.assert_allclose(found.x, value, rtol=1e-14)
        assert (np.abs(found.rate) < 1e-14).all()
        assert (found.std_x < 1e-15).all()
    found = smooth(t, np.full((400, 1), 0.7), std=ENCODER)
    # Four numbers of a cubic from 400 samples: std sqrt(4 / 400), more at the ends.
    assert np.sqrt((found.std_x**2).mean()) == pytest.approx(0.1 * ENCODER, rel=0.05)


def test_a_coarse_encoder():
    t = np.arange(2000) * 0.01
    resolution = 2 * np.pi / 4096
    x = np.round(0.8 * np.sin(t)[:, None] / resolution) * resolution
    found = smooth(t, x, std=resolution / np.sqrt(12))
    error = found.rate[:, 0] - 0.8 * np.cos(t)
    # One count a sample is 0.15 rad/s.
    assert np.sqrt((error**2).mean()) < 3e-3


def test_samples_that_all_but_coincide_and_a_gap_of_many_samples():
    even = np.arange(500) * 0.05
    for t in (np.union1d(even, even + 1e-9), np.append(even, even + 5000.0)):
        x = 1e6 + np.sin(t)
        found = smooth(t, (x + 1e-3 * random(10).standard_normal(t.size))[:, None])
        assert found.noise_std == pytest.approx(1e-3, rel=0.1)
        # The largest of 1000 correlated ones.
        assert np.abs((found.x[:, 0] - x) / found.std_x[:, 0]).max() < 4.5
        assert np.abs((found.rate[:, 0] - np.cos(t)) / found.std_rate[:, 0]).max() < 4.5


def test_four_samples_do_not_tell_their_noise():
    t = np.arange(4.0)
    found = smooth(t, t[:, None] ** 2)
    np.testing.assert_allclose(found.rate[:, 0], 2 * t, atol=1e-12)
    assert np.isnan(found.noise_std).all()
    assert np.isnan(found.std_x).all()
    known = smooth(t, t[:, None] ** 2, std=0.1)
    # A cubic through four samples passes each.
    np.testing.assert_allclose(known.std_x, 0.1, rtol=1e-9)


MEMORY = """
import resource, sys
import numpy as np
from orbident.preprocessing.smoothing import smooth
t = np.arange(400_000) * 0.01
x = (np.sin(t) + 1e-3 * np.random.default_rng(9).standard_normal(t.size))[:, None]
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
smooth(t[:5000], x[:5000])
before = peak()
smooth(t, x)
print((peak() - before) * (1 if sys.platform == "darwin" else 1024) / t.nbytes)
"""


def test_memory_does_not_hold_the_factors():
    done = finished(sys.executable, "-c", MEMORY)
    assert (done.returncode, done.stderr) == (0, "")
    # Results and working copies are less than 20 columns; the factors would be 40.
    assert float(done.stdout) < 20


@pytest.mark.parametrize(
    ("t", "x", "std", "at", "message"),
    [
        (np.arange(5.0), np.full(5, np.nan), None, None, "q has 0 samples; "),
        (np.arange(5.0), [0, 1, np.nan, 0, np.nan], None, None, "needs at least 4"),
        (np.arange(5.0), [0, 1, np.inf, 0, 1], None, None, "infinite values; give"),
        (np.zeros(5), np.arange(5.0), None, None, "q: time 2 is 0.0 s; give finite"),
        (np.array([0, 1, np.nan, 3, 4]), np.arange(5.0), None, None, "time 3 is nan"),
        (np.arange(5.0), np.arange(5.0), 0.0, None, "q: std 0.0; give positive"),
        (np.arange(5.0), np.arange(5.0), None, np.array([np.nan]), "not finite"),
    ],
)
def test_refusals(t, x, std, at, message):
    with pytest.raises(InputError, match=message):
        smooth(t, np.array(x, dtype=float)[:, None], std, at, "q")


def test_a_column_that_was_changed_in_place_is_another_one():
    """Roughness is known again by the samples, not by the array that holds them."""
    t = np.arange(200) * 0.05
    x = np.sin(t)[:, None] + 1e-3 * random().standard_normal((200, 1))
    before = smooth(t, x).noise_std
    x += 1e-1 * random(1).standard_normal((200, 1))
    # The std of the std of 200 samples is 5 %.
    assert smooth(t, x).noise_std == pytest.approx(0.1, rel=0.25)
    assert before == pytest.approx(1e-3, rel=0.25)
