"""Noise at rest: every parameter inside its interval, and no part that is not there."""

import numpy as np
import pytest
from scipy.stats import binom, multivariate_normal

from orbident.noise.noise_model import (
    MARKOV,
    PARTS,
    WALK,
    best_model,
    noise_model,
)
from orbident.simulation.sensor import markov, random_walk

TRUE = {
    "white": 8e-6,
    "markov_std": 4e-5,
    "correlation_time": 0.3,
    "random_walk": 5e-5,
}
SEEDS = 25


def times(seed, n=1200):
    """Uneven, with a gap."""
    random = np.random.default_rng(1000 + seed)
    t = 0.02 * np.arange(n) + random.uniform(-5e-3, 5e-3, n)
    return np.delete(t, slice(n // 3, n // 3 + 50))


def drawn(seed, parts, t):
    random = np.random.default_rng(seed)
    y = 3.0 + TRUE["white"] * random.standard_normal(t.size)
    if "markov_std" in parts:
        s, T = (np.array([TRUE[name]]) for name in MARKOV)
        y += markov(random, t, s, T)[:, 0]
    if "random_walk" in parts:
        y += random_walk(random, t, np.array([TRUE["random_walk"]]))[:, 0]
    return y


def test_the_likelihood_is_that_of_the_whole_covariance():
    t = times(0, 300)
    y = drawn(0, MARKOV + WALK, t)
    found = noise_model(t, y, MARKOV + WALK)
    assert found is not None
    w, s, T, q = (found.value(name) for name in TRUE)
    between = np.abs(t[:, None] - t)
    C = w**2 * np.eye(t.size) + s**2 * np.exp(-between / T)
    C += q**2 * (np.minimum(t[:, None], t) - t[0])
    # What differs from the mean has no unknown constant.
    A = np.diff(np.eye(t.size), axis=0) / y.std()
    log = multivariate_normal(np.zeros(t.size - 1), A @ C @ A.T).logpdf(A @ y)
    misfit = -2 * log - (t.size - 1) * np.log(2 * np.pi)
    assert found.misfit == pytest.approx(misfit, abs=1e-6)


@pytest.mark.parametrize("parts", [WALK, MARKOV + WALK])
def test_every_parameter_is_inside_its_interval_as_often_as_it_says(parts):
    inside = 0
    names = ("white", *parts)
    for seed in range(SEEDS):
        t = times(seed)
        found = noise_model(t, drawn(seed, parts, t), parts)
        assert found is not None
        for name in names:
            low, high = found.levels[name].interval
            inside += low < TRUE[name] < high
    # A chance of one in a thousand on either side.
    low, high = binom.ppf([1e-3, 1 - 1e-3], SEEDS * len(names), 0.95)
    assert low <= inside <= high


@pytest.mark.parametrize("parts", PARTS)
def test_the_parts_that_are_there_are_found_and_no_others(parts):
    for seed in range(2):
        t = times(seed)
        found = best_model(t, drawn(seed, parts, t))
        assert set(found.levels) == {"white", *parts}


def test_innovations_of_the_right_model_are_white():
    t = times(0)
    v = best_model(t, drawn(0, MARKOV + WALK, t)).innovations
    assert v.std() == pytest.approx(1.0, rel=0.05)
    for lag in (1, 5, 50):
        # 1150 samples: 3 %.
        assert abs(np.mean(v[lag:] * v[:-lag])) < 0.1
