import jax
import numpy as np
import pytest

from orbident.excitation.spectra import (
    log_eigenvalues,
    log_objective,
    log_squared_singular_values,
)


@pytest.fixture(scope="module")
def rows():
    random = np.random.default_rng(0)
    return random.standard_normal((50, 6)) * np.array([1, 3, 0.2, 1, 5, 1])


def exact(objective, rows):
    return float(
        np.exp(log_objective(objective, log_eigenvalues(rows.T @ rows), 8.0).exact)
    )


# Gram matrices square the condition number, here 30: 1e-12 of 1e-16.
def test_cond_is_that_of_the_rows(rows):
    assert exact("cond", rows) == pytest.approx(np.linalg.cond(rows), rel=1e-12)


def test_singular_values_are_the_roots(rows):
    ours = log_squared_singular_values(rows)
    np.testing.assert_allclose(ours, log_eigenvalues(rows.T @ rows), rtol=0, atol=1e-12)


@pytest.mark.parametrize("objective", ["d", "a", "e"])
def test_information_criteria(rows, objective):
    """From the covariance itself, which information is the inverse of."""
    C = np.linalg.inv(rows.T @ rows)
    stds = np.sqrt(np.linalg.eigvalsh(C))
    expected = {
        "d": np.linalg.det(C) ** (1 / 12),
        "a": np.sqrt(np.trace(C) / 6),
        "e": stds[-1],
    }
    assert exact(objective, rows) == pytest.approx(expected[objective], rel=1e-12)


@pytest.mark.parametrize("objective", ["cond", "e"])
def test_smooth_is_above_exact_and_tends_to_it(rows, objective):
    gaps = [
        float(value.smooth - value.exact)
        for value in (
            log_objective(objective, log_eigenvalues(rows.T @ rows), p)
            for p in (1.0, 8.0, 64.0)
        )
    ]
    assert gaps[0] > gaps[1] > gaps[2] >= 0.0
    # log(6) / p at most, for six eigenvalues.
    assert gaps[2] < np.log(6) / 64


@pytest.mark.parametrize("objective", ["cond", "d", "a", "e"])
def test_gradients_by_differences(rows, objective):
    def smooth(scale):
        l = log_eigenvalues((rows * scale).T @ (rows * scale))
        return log_objective(objective, l, 8.0).smooth

    at, step = np.ones(6), 1e-5
    found = jax.grad(smooth)(at)
    for k in range(6):
        move = step * np.eye(6)[k]
        difference = float(smooth(at + move) - smooth(at - move)) / (2 * step)
        # Eigenvalues are good to 1e-13, as the Gram matrix is conditioned: 1e-8 after
        # division by the step, whose square is 1e-10.
        assert float(found[k]) == pytest.approx(difference, abs=1e-7)
