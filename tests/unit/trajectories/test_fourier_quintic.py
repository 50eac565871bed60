import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

from orbident.errors import InputError
from orbident.trajectories.fourier_quintic import fourier_quintic

DURATION = 7.0


@pytest.fixture(autouse=True)
def x64():
    with jax.enable_x64(True):
        yield


@pytest.fixture
def parameters():
    rng = np.random.default_rng(0)
    shapes = [(2, 3), (2, 3), (2, 3), (2, 3)]
    return [jnp.array(rng.normal(size=shape)) for shape in shapes]


def evaluate(parameters, t):
    a, b, start, end = parameters
    return fourier_quintic(a, b, start, end, DURATION, t)


def test_is_eq_41(parameters):
    a, b, start, end = (np.asarray(x) for x in parameters)
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
    for got, want in zip(evaluate(parameters, jnp.array(t)), expected, strict=True):
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-11)


def test_boundary_values_are_exact(parameters):
    q, qd, qdd = evaluate(parameters, jnp.array([0.0, DURATION]))
    for k, history in enumerate((q, qd, qdd)):
        for row, ends in zip(history, parameters[2:], strict=True):
            np.testing.assert_allclose(row, ends[:, k], rtol=0, atol=1e-12)


def test_rates_are_derivatives(parameters):
    def at(t, order):
        return evaluate(parameters, t[None])[order][0]

    for t in jnp.array([0.0, 1.3, 6.9]):
        for order in (0, 1):
            derivative = jax.jacfwd(at)(t, order)
            np.testing.assert_allclose(at(t, order + 1), derivative, atol=1e-11)


def test_gradients_with_respect_to_a_and_b(parameters):
    a, b, start, end = parameters
    t = jnp.linspace(0, DURATION, 9)

    def histories(a, b):
        return fourier_quintic(a, b, start, end, DURATION, t)

    check_grads(jax.jit(histories), (a, b), order=1, rtol=1e-6)


def test_batches(parameters):
    a, b, start, end = parameters
    t = jnp.linspace(0, DURATION, 5)
    stacked = jax.vmap(lambda a: fourier_quintic(a, b, start, end, DURATION, t))(
        jnp.stack([a, 2 * a])
    )
    single = fourier_quintic(2 * a, b, start, end, DURATION, t)
    for many, one in zip(stacked, single, strict=True):
        np.testing.assert_allclose(many[1], one, atol=1e-13)


def test_without_harmonics_it_is_the_quintic():
    none = jnp.zeros((1, 0))
    start, end = jnp.zeros((1, 3)), jnp.array([[1.0, 0.0, 0.0]])
    s = jnp.linspace(0, 1, 7)
    q, _, _ = fourier_quintic(none, none, start, end, 2.0, 2 * s)
    np.testing.assert_allclose(q[:, 0], 10 * s**3 - 15 * s**4 + 6 * s**5, atol=1e-14)


def test_float32_refused(parameters):
    a, b, start, end = parameters
    with pytest.raises(
        InputError, match=r"b is float32; give float64, .*jax_enable_x64"
    ):
        fourier_quintic(
            a, b.astype(jnp.float32), start, end, DURATION, jnp.array([0.0])
        )
