"""Are residuals white? Their correlation in time, and their spectrum."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.predicted import Signal

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
    # Late: the import takes half a second.
    from scipy.signal import welch

    f, power = welch(x, rate, nperseg=min(x.size, 2 * LINES), detrend="constant")
    f, power = f[1:], power[1:]
    if f.size > DRAWN:
        starts = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], DRAWN)))
        counts = np.diff(starts, append=f.size)
        f, power = (np.add.reduceat(part, starts) / counts for part in (f, power))
    return AmplitudeSpectrum(f, np.sqrt(power))
