"""One number from the eigenvalues of an information matrix, and its gradient."""

import numpy as np
import pytest

from orbident.excitation.criterion import (
    by_matrix,
    log_criterion,
    spectrum_of,
    spectrum_of_rows,
)


@pytest.fixture(scope="module")
def rows():
    random = np.random.default_rng(0)
    return random.standard_normal((50, 6)) * np.array([1, 3, 0.2, 1, 5, 1])


def exact(objective, rows):
    return np.exp(log_criterion(objective, spectrum_of(rows.T @ rows).l, 8.0).exact)


# Gram matrices square the condition number, here 30: 1e-12 of 1e-16.
def test_cond_is_that_of_the_rows(rows):
    assert exact("cond", rows) == pytest.approx(np.linalg.cond(rows), rel=1e-12)


def test_singular_values_are_the_roots(rows):
    ours, theirs = spectrum_of_rows(rows), spectrum_of(rows.T @ rows)
    np.testing.assert_allclose(ours.l, theirs.l, rtol=0, atol=1e-12)


@pytest.mark.parametrize("objective", ["d", "a", "e"])
def test_information_criteria(rows, objective):
    """Expected values are from the covariance, which information is the inverse of."""
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
        value.smooth - value.exact
        for value in (
            log_criterion(objective, spectrum_of(rows.T @ rows).l, p)
            for p in (1.0, 8.0, 64.0)
        )
    ]
    assert gaps[0] > gaps[1] > gaps[2] >= 0.0
    # log(6) / p at most, for six eigenvalues.
    assert gaps[2] < np.log(6) / 64


@pytest.mark.parametrize("objective", ["cond", "d", "a", "e"])
def test_gradients_by_differences(rows, objective):
    def at(rows):
        spectrum = spectrum_of_rows(rows)
        return spectrum, log_criterion(objective, spectrum.l, 8.0)

    spectrum, value = at(rows)
    found = 2 * rows @ by_matrix(spectrum, value.by_l)
    direction, step = np.random.default_rng(1).standard_normal(rows.shape), 1e-5
    more, less = (at(rows + s * step * direction)[1].smooth for s in (1, -1))
    # The square of the step, 1e-10, times a third derivative of some ten.
    assert (found * direction).sum() == pytest.approx(
        (more - less) / (2 * step), rel=1e-6
    )
