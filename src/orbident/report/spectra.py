"""Are residuals white? Their correlation in time, and their spectrum."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.signals import Signal

LAGS = 40
"""Samples."""

LINES = 2048
"""Lines of a spectrum, before it is thinned."""

DRAWN = 160
"""Bands of a spectrum, evenly spaced by logarithm."""


class AmplitudeSpectrum(NamedTuple):
    """The spectrum of one axis's residuals."""

    f: Float[np.ndarray, " lines"]
    """Hz."""
    density: Float[np.ndarray, " lines"]
    """Amplitude, the signal's unit per square root of Hz."""


def residuals(signal: Signal) -> Float[np.ndarray, "n axes"]:
    """Measured less predicted."""
    return signal.measured - signal.predicted


def autocorrelation(x: Float[np.ndarray, " n"]) -> Float[np.ndarray, " lags"]:
    """Autocorrelation, at lags of 1, 2, .. samples, of what is about zero."""
    lags = min(LAGS, x.size - 1)
    power = float(x @ x) or 1.0
    return np.array([x[:-k] @ x[k:] for k in range(1, lags + 1)]) / power


def spectrum(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> AmplitudeSpectrum:
    """As if the samples came evenly (Welch 1967): the mean of each band."""
    rate = 1 / float(np.median(np.diff(t)))
    f, power = power_density(x, rate)
    f, power = f[1:], power[1:]
    if f.size > DRAWN:
        starts = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], DRAWN)))
        counts = np.diff(starts, append=f.size)
        f, power = (np.add.reduceat(part, starts) / counts for part in (f, power))
    return AmplitudeSpectrum(f, np.sqrt(power))


def power_density(
    x: Float[np.ndarray, " n"], rate: float
) -> tuple[Float[np.ndarray, " lines"], Float[np.ndarray, " lines"]]:
    """Frequencies, Hz, and power per Hz by Welch's method.

    Stretches without their mean, half of each shared with the next, under Hann's
    window. `scipy.signal` has the same, and its import takes a third of a second.
    """
    size = min(x.size, 2 * LINES)
    parts = np.lib.stride_tricks.sliding_window_view(x, size)[:: -(-size // 2)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
    parts = (parts - parts.mean(axis=1, keepdims=True)) * window
    power = np.mean(np.abs(np.fft.rfft(parts)) ** 2, axis=0) / (rate * window @ window)
    # Both signs of a frequency share a line, but for zero and half the rate.
    power[1 : (size + 1) // 2] *= 2
    return np.fft.rfftfreq(size, 1 / rate), power
