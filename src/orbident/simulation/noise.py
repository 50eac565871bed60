"""Noise processes of sensors (IEEE Std 952, Annex C), all axes at once.

Conventions. A *rate* sample (angular rate, specific force) is a mean over the interval
`dt` that ends with it. Two-sided spectral densities. The Allan deviation at averaging
time `tau` of white noise is `N / sqrt(tau)`, and that of flicker noise is flat,
`sqrt(2 ln 2 / pi) B = 0.664 B`: that is the floor from which a data sheet's bias
instability `B` is read.
"""

import numpy as np
from jaxtyping import Float

from orbident.robot.sensor_bias import markov_std

MARKOV_PEAK_AT = 1.8926
"""The averaging time of that peak, over the correlation time."""


def gaussian(
    random: np.random.Generator, shape: tuple[int, int], std: float
) -> Float[np.ndarray, "n axes"]:
    """Independent samples `N(0, std^2)`, in the unit of `std`."""
    return std * random.standard_normal(shape)


def random_walk_rate(
    random: np.random.Generator, shape: tuple[int, int], N: float, dt: float
) -> Float[np.ndarray, "n axes"]:
    """White noise of rate samples whose integral is a random walk.

    The integral over `dt` has std `N sqrt(dt)`, so its mean, the sample, has
    `N / sqrt(dt)`. IEEE 952, C.1.1: `S(f) = N^2`.

    Args:
        random: the sensor's stream.
        shape: samples and axes.
        N: angle random walk, rad/sqrt(s), or velocity random walk, m/s/sqrt(s).
        dt: from one sample to the next, s.

    Returns:
        rad/s, or m/s^2.
    """
    return gaussian(random, shape, N / np.sqrt(dt))


def bias_drift(
    random: np.random.Generator,
    shape: tuple[int, int],
    B: float,
    correlation_time: float,
    dt: float,
) -> Float[np.ndarray, "n axes"]:
    """How a bias wanders from its value at turn-on: a first-order Gauss-Markov process.

    `b_k = exp(-dt/T) b_{k-1} + s sqrt(1 - exp(-2 dt/T)) n_k`, `b_0 = 0` (IEEE 952,
    C.1.5), with `s` as `orbident.robot.sensor_bias` has it: the Allan deviation peaks
    at flicker's floor, `0.664 B`, at the averaging time 1.89 T. For shorter times it
    rises as `sqrt(tau)`.

    Args:
        random: the sensor's stream.
        shape: samples and axes.
        B: bias instability, rad/s or m/s^2.
        correlation_time: T, s; infinite for a bias that stays.
        dt: from one sample to the next, s.

    Returns:
        In the unit of `B`; zero at the first sample.
    """
    # expm1: T may be long, and infinite.
    kick = markov_std(B) * np.sqrt(-np.expm1(-2 * dt / correlation_time))
    kicks = gaussian(random, shape, float(kick))
    kicks[:1] = 0.0
    # Late: the import takes half a second.
    from scipy.signal import lfilter

    return np.asarray(lfilter([1.0], [1.0, -np.exp(-dt / correlation_time)], kicks, 0))


def quantised(x: Float[np.ndarray, "*n"], step: float) -> Float[np.ndarray, "*n"]:
    """The nearest multiple of `step` (same unit); unchanged where `step` is zero."""
    return step * np.round(x / step) if step else x
