"""The Allan deviation of a model, against closed forms."""

import numpy as np
import pytest

from orbident.noise.noise_model import Level, NoiseModel
from orbident.report.allan import allan_deviation, model_deviation


def model(**values):
    levels = {name: Level(value, 0.1) for name, value in values.items()}
    return NoiseModel(levels, 0.0, 100, np.zeros(100))


def test_white_noise_falls_with_the_root_of_the_time():
    white = model(white=2.0)
    for m in (1, 7, 400):
        assert model_deviation(white, m, 0.1) == pytest.approx(2.0 / np.sqrt(m))


def test_a_walk_rises_with_the_root_of_the_time():
    # q sqrt(tau / 3); of samples, times 1 + 1/(2 m^2) in the variance.
    walk = model(white=0.0, random_walk=0.3)
    found = model_deviation(walk, 200, 0.1)
    assert found == pytest.approx(0.3 * np.sqrt(20.0 / 3), rel=1e-4)


def test_markov_noise_is_largest_at_1_9_of_its_times():
    lasting = model(white=0.0, markov_std=1.0, correlation_time=1.0)
    m = np.arange(100, 300)
    found = [model_deviation(lasting, int(each), 0.01) for each in m]
    assert m[np.argmax(found)] * 0.01 == pytest.approx(1.8926, abs=0.02)
    assert max(found) == pytest.approx(0.617364, rel=1e-3)


def test_the_definition():
    x = np.array([1.0, 2.0, 4.0, 3.0, 5.0, 9.0])
    means = [(x[k : k + 2].mean(), x[k + 2 : k + 4].mean()) for k in range(3)]
    expected = np.sqrt(np.mean([(b - a) ** 2 for a, b in means]) / 2)
    assert allan_deviation(x, 2) == pytest.approx(expected)
