import numpy as np
import pytest

from orbident import _core
from orbident.trajectories.trajectory import FourierQuintic

DURATION = 7.0


@pytest.fixture
def parameters():
    rng = np.random.default_rng(0)
    shapes = [(2, 3), (2, 3), (2, 3), (2, 3)]
    return [rng.normal(size=shape) for shape in shapes]


def evaluate(parameters, t):
    return FourierQuintic(*parameters, duration=DURATION).at(t)


def test_is_eq_41(parameters):
    a, b, start, end = parameters
    t = np.linspace(0, DURATION, 11)
    w_f = 2 * np.pi / DURATION
    harmonic = w_f * np.arange(1, 4)

    def series(t):
        arg = np.outer(t, harmonic)
        sin, cos = np.sin(arg), np.cos(arg)
        return (
            sin @ (a / harmonic).T - cos @ (b / harmonic).T,
            cos @ a.T + sin @ b.T,
            cos @ (b * harmonic).T - sin @ (a * harmonic).T,
        )

    def powers(t, order):
        basis = [np.polynomial.Polynomial.basis(j) for j in range(6)]
        return np.array([(p.deriv(order) if order else p)(t) for p in basis])

    # The slow way: the six conditions as a linear system in c, unscaled.
    A = np.array([powers(end_t, k) for end_t in (0.0, DURATION) for k in range(3)])
    ends = np.stack([f[[0, -1]] for f in series(t)], axis=1).reshape(6, -1)
    c = np.linalg.solve(A, np.concatenate([start.T, end.T]) - ends)
    expected = [f + powers(t, k).T @ c for k, f in enumerate(series(t))]
    for got, want in zip(evaluate(parameters, t), expected, strict=True):
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-11)


def test_boundary_values_are_exact(parameters):
    q, qd, qdd = evaluate(parameters, np.array([0.0, DURATION]))
    for k, history in enumerate((q, qd, qdd)):
        for row, ends in zip(history, parameters[2:], strict=True):
            np.testing.assert_allclose(row, ends[:, k], rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", range(1, 8))
def test_derivatives_by_differences(parameters, order):
    motion, step = FourierQuintic(*parameters, duration=DURATION), 1e-4
    t = np.linspace(1.0, 6.0, 50)
    below = [motion.derivative(order - 1, t + s) for s in (-step, step)]
    difference = (below[1] - below[0]) / (2 * step)
    found = motion.derivative(order, t)
    # Truncation step^2 w^2 / 6, with w = 2.7 rad/s: 1e-8; rounding 1e-16 / step.
    np.testing.assert_allclose(
        found, difference, rtol=0, atol=1e-7 * np.abs(found).max()
    )


def test_linear_in_a_and_b(parameters):
    """With the ends fixed, motions are linear in the coefficients."""
    a, b, start, end = parameters
    t, none = np.linspace(0, DURATION, 9), np.zeros_like(a)
    once, twice, never = (
        FourierQuintic(s * a, s * b, start, end, DURATION).at(t) for s in (1, 2, 0)
    )
    still = FourierQuintic(none, none, start, end, DURATION).at(t)
    for one, two, zero, rest in zip(once, twice, never, still, strict=True):
        np.testing.assert_allclose(two - one, one - zero, rtol=0, atol=1e-11)
        np.testing.assert_array_equal(zero, rest)


def test_late_derivatives_are_bounded(parameters):
    motion = FourierQuintic(*parameters, duration=DURATION)
    t = np.linspace(0, DURATION, 1000)
    for order in (6, 7):
        # The highest harmonic alone reaches its share of the bound.
        largest = np.abs(motion.derivative(order, t)).max(axis=0)
        assert (largest <= motion.bound(order)).all()


def test_without_harmonics_it_is_the_quintic():
    none = np.zeros((1, 0))
    start, end = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    s = np.linspace(0, 1, 7)
    q, _, _ = FourierQuintic(none, none, start, end, 2.0).at(2 * s)
    np.testing.assert_allclose(q[:, 0], 10 * s**3 - 15 * s**4 + 6 * s**5, atol=1e-14)


@pytest.mark.core
def test_threads_change_no_bit():
    random = np.random.default_rng(1)
    coefficients, s = random.standard_normal((3, 4, 16)), random.uniform(0, 1, 1001)
    one, two = (_core.fourier_quintic(coefficients, s, k) for k in (1, 2))
    np.testing.assert_array_equal(one, two)
    alone = _core.fourier_quintic(coefficients, s[-1:])
    np.testing.assert_array_equal(alone[:, 0], one[:, -1])


@pytest.mark.core
@pytest.mark.parametrize("functions", [4, 7])
def test_functions_that_are_not_those_of_eq_41_are_refused(functions):
    with pytest.raises(ValueError, match="2 N_f"):
        _core.fourier_quintic(np.zeros((1, 2, functions)), np.zeros(3))
