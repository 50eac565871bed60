"""Eq. 41: a finite Fourier series plus the quintic that meets the ends."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from orbident.precision import require_float64

Histories = tuple[
    Float[Array, "samples joints"],
    Float[Array, "samples joints"],
    Float[Array, "samples joints"],
]


def fourier_quintic(
    a: Float[Array, "joints harmonics"],
    b: Float[Array, "joints harmonics"],
    start: Float[Array, "joints 3"],
    end: Float[Array, "joints 3"],
    duration: float | Float[Array, ""],
    t: Float[Array, " samples"],
) -> Histories:
    r"""Joint positions, rates and accelerations of the exciting trajectory.

    q_i(t) = sum_l a_il/(w_f l) sin(w_f l t) - b_il/(w_f l) cos(w_f l t)
             + sum_{j=0..5} c_ij t^j,      w_f = 2 pi / t_f      (Eq. 41)

    with c_i such that the boundary values hold whatever a and b are. Pure JAX:
    it can be differentiated, compiled and batched.

    Args:
        a: Cosine amplitudes of the rate, rad/s or m/s.
        b: Sine amplitudes of the rate, rad/s or m/s.
        start: Position, velocity and acceleration of each joint at t = 0.
        end: The same at t = t_f.
        duration: t_f, s.
        t: Times, s, within [0, t_f].

    Raises:
        InputError: The numbers are not float64.
    """
    require_float64("fourier_quintic", a=a, b=b, start=start, end=end, t=t)
    # In s = t / t_f both series stay of order one: T d/dt = d/ds.
    T = duration
    s = t / T
    rates = T ** jnp.arange(3)
    harmonic = 2.0 * jnp.pi * jnp.arange(1, a.shape[1] + 1)
    phase = s[:, None] * harmonic
    sin, cos = jnp.sin(phase), jnp.cos(phase)
    a, b = T * a, T * b
    f = sin @ (a / harmonic).T - cos @ (b / harmonic).T
    f_s = cos @ a.T + sin @ b.T
    f_ss = cos @ (b * harmonic).T - sin @ (a * harmonic).T

    # The series has the same values at both ends.
    ends = jnp.stack(
        [-(b / harmonic).sum(1), a.sum(1), (b * harmonic).sum(1)],
        axis=1,
    )
    c = _quintic(start * rates - ends, end * rates - ends)
    p, p_s, p_ss = _powers(s)
    return (
        f + p @ c,
        (f_s + p_s @ c) / T,
        (f_ss + p_ss @ c) / T**2,
    )


def _quintic(
    start: Float[Array, "joints 3"], end: Float[Array, "joints 3"]
) -> Float[Array, "6 joints"]:
    """Coefficients in s from value and two derivatives at s = 0 and s = 1."""
    p0, v0, a0 = start.T
    p1, v1, a1 = end.T
    p = p1 - p0 - v0 - a0 / 2
    v = v1 - v0 - a0
    acc = a1 - a0
    return jnp.stack(
        [
            p0,
            v0,
            a0 / 2,
            10 * p - 4 * v + acc / 2,
            -15 * p + 7 * v - acc,
            6 * p - 3 * v + acc / 2,
        ]
    )


def _powers(s: Float[Array, " samples"]) -> tuple[Float[Array, "samples 6"], ...]:
    """s^0 to s^5, and their first and second derivatives."""
    one, zero = jnp.ones_like(s), jnp.zeros_like(s)
    s2, s3, s4, s5 = s**2, s**3, s**4, s**5
    value = jnp.stack([one, s, s2, s3, s4, s5], axis=1)
    first = jnp.stack([zero, one, 2 * s, 3 * s2, 4 * s3, 5 * s4], axis=1)
    second = jnp.stack([zero, zero, 2 * one, 6 * s, 12 * s2, 20 * s3], axis=1)
    return value, first, second
