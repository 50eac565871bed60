"""Noise processes of sensors (IEEE Std 952, Annex C), all axes at once.

Conventions. A *rate* sample (angular rate, specific force) is a mean over the interval
`dt` that ends with it. Two-sided spectral densities. The Allan deviation at averaging
time `tau` of white noise is `N / sqrt(tau)`, and that of flicker noise is flat,
`sqrt(2 ln 2 / pi) B = 0.664 B`: that is the floor from which a data sheet's bias
instability `B` is read.

Random numbers: one seed, and a stream of its own for whatever has a name.
"""

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_banded

from orbident.errors import InputError
from orbident.robot.sensor_schema import Coloured


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one sensor.

    A child of `SeedSequence(seed)` whose spawn key is the name, so that a sensor that
    is added, removed or changed leaves every other one's numbers as they were.

    Args:
        seed: of the whole recording, zero or more.
        name: of the sensor.

    Raises:
        InputError: the seed is not a whole number of zero or more.
    """
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"seed {seed!r}: give a whole number of zero or more")
    children = np.random.SeedSequence(int(seed), spawn_key=tuple(name.encode()))
    return np.random.default_rng(children)


MARKOV_PEAK_AT = 1.8926
"""The averaging time of that peak, over the correlation time."""


def gaussian(
    random: np.random.Generator, shape: tuple[int, int], std: float
) -> Float[np.ndarray, "n axes"]:
    """Independent samples `N(0, std^2)`, in the unit of `std`."""
    return std * random.standard_normal(shape)


def bias_drift(
    random: np.random.Generator,
    shape: tuple[int, int],
    std: float,
    correlation_time: float,
    dt: float,
) -> Float[np.ndarray, "n axes"]:
    """How a bias wanders from its value at turn-on: a first-order Gauss-Markov process.

    `b_k = exp(-dt/T) b_{k-1} + s sqrt(1 - exp(-2 dt/T)) n_k`, `b_0 = 0` (IEEE 952,
    C.1.5). The Allan deviation peaks at `0.617 s`, at the averaging time 1.89 T. For
    shorter times it rises as `sqrt(tau)`.

    Args:
        random: the sensor's stream.
        shape: samples and axes.
        std: `s`, rad/s or m/s^2.
        correlation_time: T, s; infinite for a bias that stays.
        dt: from one sample to the next, s.

    Returns:
        In the unit of `std`; zero at the first sample.
    """
    # expm1: T may be long, and infinite.
    kick = std * np.sqrt(-np.expm1(-2 * dt / correlation_time))
    kicks = gaussian(random, shape, float(kick))
    kicks[:1] = 0.0
    # Late: the import takes half a second.
    from scipy.signal import lfilter

    return np.asarray(lfilter([1.0], [1.0, -np.exp(-dt / correlation_time)], kicks, 0))


def markov(
    random: np.random.Generator,
    t: Float[np.ndarray, " n"],
    std: Float[np.ndarray, " axes"],
    correlation_time: Float[np.ndarray, " axes"],
) -> Float[np.ndarray, "n axes"]:
    """A stationary first-order Gauss-Markov process, at any increasing times.

    `x_0 ~ N(0, s^2)`, `x_k = a_k x_{k-1} + s sqrt(1 - a_k^2) n_k` with
    `a_k = exp(-(t_k - t_{k-1}) / T)`: exact, however far apart the samples are.

    Args:
        random: the process's stream.
        t: of the samples, s.
        std: s, by axis.
        correlation_time: T, by axis, s.

    Returns:
        In the unit of `std`.
    """
    steps = np.diff(t)[:, None] / correlation_time
    kicks = gaussian(random, (t.size, std.size), 1.0) * std
    kicks[1:] *= np.sqrt(-np.expm1(-2 * steps))
    # The recursion as equations with one diagonal below the main one.
    bands = np.ones((2, t.size))
    for axis, step in enumerate(steps.T):
        bands[1, :-1] = -np.exp(-step)
        kicks[:, axis] = solve_banded((1, 0), bands, kicks[:, axis])
    return kicks


def random_walk(
    random: np.random.Generator,
    t: Float[np.ndarray, " n"],
    density: Float[np.ndarray, " axes"],
) -> Float[np.ndarray, "n axes"]:
    """A random walk, `var(x(t)) = q^2 (t - t_0)`, at any increasing times.

    Args:
        random: the process's stream.
        t: of the samples, s.
        density: q, by axis, in its unit per square root of a second.
    """
    steps = np.sqrt(np.diff(t, prepend=t[:1]))[:, None] * density
    return np.cumsum(steps * gaussian(random, steps.shape, 1.0), axis=0)


def coloured(
    random: np.random.Generator, t: Float[np.ndarray, " n"], noise: Coloured
) -> Float[np.ndarray, "n 3"]:
    """The parts of a tracker's noise that are not white, from streams of their own."""
    lasting, walking = random.spawn(2)
    return markov(lasting, t, noise.markov_std, noise.correlation_time) + random_walk(
        walking, t, noise.random_walk
    )


def quantised(x: Float[np.ndarray, "*n"], step: float) -> Float[np.ndarray, "*n"]:
    """The nearest multiple of `step` (same unit); unchanged where `step` is zero."""
    return step * np.round(x / step) if step else x
