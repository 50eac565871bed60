"""A position driven by white snap and measured in noise: one least-squares problem.

The state `s = (x, x', x'', x''')` moves by `s+ = F(dt) s + B(dt) w`, `w ~ N(0, 1)`, and
a sample shows `y = x + e`, `e ~ N(0, 1)`: the unit is the standard deviation of the
measurement, and `ratio` is the spectral density of `x''''` in that unit, squared, and
the unit of time. The posterior mean is the smoothing spline of degree 7 (Wahba 1978).

All unknowns `(w_1 .. w_n, s_n)` solve one sparse least-squares problem, whose QR
factors are found step by step (square-root information filter; Bierman 1977, chapters
V and X). No covariance is inverted or subtracted, so nothing at all need be known at
the start, gaps may be long, and the samples may be free of noise but for rounding.

Arrays have one lane a problem, last. A lane waits while its `dt` and weight are zero.
"""

from math import factorial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.spatial.arrays import AnyArray

ORDER = 4
"""Components of the state. With 3, white jerk, the natural end conditions cost the
rate at the ends of noise-free data three digits, and rates of smooth motion are three
times noisier."""

BLOCK = 1024
"""Steps taken at once."""

LANES = 8
"""Problems solved at once; with `BLOCK`, one compiled size for everything."""

_LEVELS = range(ORDER)
_SIDE = 2 * ORDER + 1

# Covariance of the state after unit time from a known one, and its upper square root:
# s_i = int u^(p_i) / p_i! dW with p_i = ORDER - 1 - i.
_Q = np.array(
    [
        [1 / ((i + j + 1) * factorial(i) * factorial(j)) for j in reversed(_LEVELS)]
        for i in reversed(_LEVELS)
    ]
)
_B = np.linalg.cholesky(_Q[::-1, ::-1])[::-1, ::-1]


class Information(NamedTuple):
    """What the samples so far say: `R s = z + N(0, 1)`, and how likely they were."""

    R: Float[AnyArray, "order order lanes"]
    """Upper triangular; zero where nothing is known."""
    z: Float[AnyArray, "order lanes"]
    misfit: Float[AnyArray, " lanes"]
    """Sum of squares of the residuals."""
    log_det: Float[AnyArray, " lanes"]
    """Log of the determinant of all eliminated triangles."""


class Estimate(NamedTuple):
    """Mean and covariance of the state, given all samples."""

    mean: Float[AnyArray, "*n order lanes"]
    covariance: Float[AnyArray, "*n order order lanes"]


NOTHING_KNOWN = Information(
    np.zeros((ORDER, ORDER, LANES)),
    np.zeros((ORDER, LANES)),
    np.zeros(LANES),
    np.zeros(LANES),
)
"""Before the first sample."""


@compiled
def forward(
    start: Information,
    dt: Float[AnyArray, "n lanes"],
    y: Float[AnyArray, "n lanes"],
    weight: Float[AnyArray, "n lanes"],
    ratio: Float[AnyArray, " lanes"],
) -> tuple[Information, Float[AnyArray, "n order side lanes"]]:
    """Move by each `dt`, then take in the sample there.

    Args:
        start: what is known before.
        dt: time since the step before.
        y: samples.
        weight: 1 where there is a sample, else 0.
        ratio: spectral density of the snap.

    Returns:
        What is known in the end, and of each step the eliminated rows
        `U w + T s+ = b` as `[U T b]`.
    """

    def step(known, sample):
        F_inv, G, y, weight = sample
        # w = 0 + N(0, 1) and R (F^-1 s+ - G w) = z + N(0, 1).
        V, M = -_product(known.R, G), _product(known.R, F_inv)
        noise = [_row({j: 1.0}, y) for j in _LEVELS]
        state = [jnp.concatenate([V[i], M[i], known.z[i, None]]) for i in _LEVELS]
        # From the bottom row up, so that M stays a triangle.
        for j in _LEVELS:
            for i in range(j, -1, -1):
                noise[j], state[i] = _rotated(noise[j], state[i], j)
        left = [row[ORDER:] for row in state]
        measured = weight * _row({ORDER: 1.0, _SIDE - 1: y}, y)[ORDER:]
        for i in _LEVELS:
            left[i], measured = _rotated(left[i], measured, i)
        rows = jnp.stack(noise)
        diagonal = jnp.stack([rows[j, j] for j in _LEVELS])
        after = Information(
            jnp.stack([row[:-1] for row in left]),
            jnp.stack([row[-1] for row in left]),
            known.misfit + measured[-1] ** 2,
            known.log_det + jnp.log(jnp.abs(jnp.prod(diagonal, axis=0))),
        )
        return after, rows

    return jax.lax.scan(step, start, (*_motion(dt, ratio), y, weight))


@compiled
def backward(
    end: Estimate,
    dt: Float[AnyArray, "n lanes"],
    rows: Float[AnyArray, "n order side lanes"],
    ratio: Float[AnyArray, " lanes"],
) -> tuple[Estimate, Estimate]:
    """From the state after the last step back to the state before the first.

    `s = F^-1 s+ - G w` with `w = U^-1 (b - T s+ + N(0, 1))`.

    Args:
        end: the state after the last step, given all samples.
        dt: as `forward` had it.
        rows: what `forward` returned.
        ratio: as `forward` had it.

    Returns:
        The state before the first step, and those after each step.
    """

    def step(after, eliminated):
        F_inv, G, rows = eliminated
        N, T, b = _solved(rows)
        L, N = F_inv + _product(G, T), _product(G, N)
        mean = _product(L, after.mean[:, None]) - _product(G, b)
        PLT = _product(after.covariance, jnp.swapaxes(L, 0, 1))
        covariance = _product(L, PLT) + _product(N, jnp.swapaxes(N, 0, 1))
        return Estimate(mean[:, 0], covariance), after

    return jax.lax.scan(step, end, (*_motion(dt, ratio), rows), reverse=True)


def final_estimate(known: Information) -> Estimate:
    """The last state from all that is known: `R^-1 z` and `(R^T R)^-1`."""
    R_inv = np.linalg.inv(np.moveaxis(np.asarray(known.R), -1, 0))
    mean = np.einsum("lij,jl->il", R_inv, known.z)
    return Estimate(mean, np.einsum("lik,ljk->ijl", R_inv, R_inv))


def _rotated(a: jax.Array, b: jax.Array, k: int) -> tuple[jax.Array, jax.Array]:
    """Givens: two rows turned so that `b[k]` vanishes."""
    norm = jnp.sqrt(a[k] ** 2 + b[k] ** 2)
    safe = jnp.where(norm > 0, norm, 1.0)
    c, s = jnp.where(norm > 0, a[k] / safe, 1.0), b[k] / safe
    return c * a + s * b, c * b - s * a


def _row(entries: dict[int, float | jax.Array], dt: jax.Array) -> jax.Array:
    row = jnp.zeros((_SIDE, dt.size))
    for k, value in entries.items():
        row = row.at[k].set(value)
    return row


def _motion(dt: AnyArray, ratio: AnyArray) -> tuple[jax.Array, jax.Array]:
    """`F^-1` and `G = F^-1 B` of every step, `n order order lanes`.

    `F_ij = dt^(j-i) / (j-i)!`, and its inverse is that of `-dt`; `B B^T` is the
    covariance of the noise over `dt`.
    """
    each = jnp.asarray(dt)[:, None, None]
    diagonals = [jnp.eye(ORDER, k=k)[..., None] / factorial(k) for k in _LEVELS]
    terms = [diagonals[k] * (-each) ** k for k in _LEVELS]
    F_inv = sum(terms, start=jnp.zeros(()))
    D = jnp.stack([dt**k for k in reversed(_LEVELS)], axis=1)
    B = (D * jnp.sqrt(ratio * dt)[:, None])[:, :, None] * _B[..., None]
    return F_inv, jax.vmap(_product)(F_inv, B)


def _product(A: jax.Array, B: jax.Array) -> jax.Array:
    """`A B` in every lane, written out: it fuses."""
    terms = [A[:, k, None] * B[k] for k in _LEVELS]
    return sum(terms, start=jnp.zeros(()))


def _solved(rows: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """`U^-1`, `U^-1 T` and `U^-1 b` of `[U T b]`."""
    right = [
        jnp.concatenate([_row({i: 1.0}, rows[0, 0])[:ORDER], rows[i, ORDER:]])
        for i in _LEVELS
    ]
    for i in reversed(_LEVELS):
        for k in range(i + 1, ORDER):
            right[i] = right[i] - rows[i, k] * right[k]
        right[i] = right[i] / rows[i, i]
    X = jnp.stack(right)
    return X[:, :ORDER], X[:, ORDER:-1], X[:, -1:]
