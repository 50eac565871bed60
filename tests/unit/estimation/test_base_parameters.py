"""What an estimate of the base parameters leaves undetermined."""

import numpy as np
import pytest

import orbident as oi
from orbident.estimation.base_parameters import (
    WIDE,
    BetaEstimate,
    hidden_of,
    parameters_of_beta,
    prior_std,
)
from orbident.model.minimal_sets import minimal_sets

ROBOT = oi.load_robot("paper-spatial")


def estimate(std: np.ndarray, hidden: np.ndarray | None = None) -> BetaEstimate:
    """The truth, with these deviations."""
    beta = minimal_sets(ROBOT).beta(ROBOT.theta)
    nothing = np.zeros((beta.size, 0))
    return BetaEstimate(beta, np.diag(std**2), nothing if hidden is None else hidden)


def test_hidden_directions_are_the_null_space():
    scale = np.array([1e3, 1.0, 1e-3])
    # Only x / 1e3 + z / 1e-3 and y show.
    factor = np.array([[1e-3, 0.0, 1e3], [0.0, 5.0, 0.0]])
    hidden = hidden_of(factor, scale)
    assert hidden.shape == (3, 1)
    np.testing.assert_allclose(factor @ hidden, 0.0, atol=1e-12)
    assert hidden_of(np.eye(3), scale).shape == (3, 0)
    assert hidden_of(np.zeros((2, 3)), scale).shape == (3, 3)


def test_sure_parameters_are_determined():
    sets = minimal_sets(ROBOT)
    scale = prior_std(ROBOT, sets) / WIDE
    found = parameters_of_beta(ROBOT, sets, estimate(1e-3 * scale))
    pi, phi = sets.pi_and_phi(sets.beta(ROBOT.theta))
    for known, expected in ((found.pi, pi), (found.phi, phi)):
        np.testing.assert_array_equal(known.values, expected)
        assert known.determined.all()
    assert found.base.determined.all()
    both = np.sqrt(np.diag(found.covariance))
    apart = np.concatenate(
        [np.diag(found.pi.covariance), np.diag(found.phi.covariance)]
    )
    np.testing.assert_allclose(both, np.sqrt(apart))


def test_as_unsure_as_the_prior_is_not_determined():
    sets = minimal_sets(ROBOT)
    found = parameters_of_beta(ROBOT, sets, estimate(prior_std(ROBOT, sets)))
    for known in (found.pi, found.phi, found.base):
        assert not known.determined.any()


@pytest.mark.parametrize("k", [1, 7, 17])
def test_what_is_hidden_is_not_determined_however_small_its_deviation(k: int):
    sets = minimal_sets(ROBOT)
    scale = prior_std(ROBOT, sets)
    hidden = np.zeros((scale.size, 1))
    hidden[k] = scale[k]
    found = parameters_of_beta(ROBOT, sets, estimate(1e-9 * scale, hidden))
    np.testing.assert_array_equal(found.base.determined, np.arange(scale.size) != k)
    assert not found.pi.determined.all()
