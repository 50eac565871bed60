"""Samples that jump from one to the next, as no smooth motion does.

A polynomial and a step at its middle are fitted to the samples around every one. The
step is a fixed filter of them, and where it stands far out of all that it gives over
the recording, the sensor jumped.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.signal import argrelmax
from scipy.special import chdtri

HALF, DEGREE = 10, 4
"""Samples before and after, and of the polynomial through them."""

FAR = 8.0
"""Deviations of the filter's own scatter."""


@dataclass(frozen=True)
class Jump:
    """A jump of one column or vector of the recording."""

    sensor: str
    """As columns of the recording begin."""
    row: int
    """The first after it."""
    times: float
    """Over the filter's scatter."""
    size: Float[np.ndarray, " axes"]
    """SI; of an attitude by its quaternion's components."""
    rate: Float[np.ndarray, " axes"]
    """The change of the shown rate at the jump, SI per second."""


def jumps_of(
    sensor: str, t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"]
) -> list[Jump]:
    """All that stand out, the largest first; none of few samples, or of a rest."""
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    if seen.size < 4 * HALF:
        return []
    k = np.arange(-HALF, HALF) + 0.5
    powers = np.vander(k / HALF, DEGREE + 1, increasing=True)
    by = np.linalg.pinv(np.column_stack([powers, k > 0]))
    # That of the step at the middle of so many samples, and of the slope there.
    step, slope = by[-1], by[1] / HALF
    shown, dt = x[seen], float(np.median(np.diff(t[seen])))
    found = np.array([np.correlate(axis, step, "valid") for axis in shown.T]).T
    slopes = np.array([np.correlate(axis, slope, "valid") for axis in shown.T]).T / dt
    size = np.linalg.norm(found, axis=1)
    scatter = float(np.median(size) / np.sqrt(chdtri(x.shape[1], 0.5)))
    # Around a jump the filter shows the same one again.
    tops = argrelmax(np.pad(size, 1), order=HALF)[0] - 1
    far = [k for k in tops if size[k] > FAR * scatter > 0]
    return [
        Jump(sensor, int(seen[k + HALF]), size[k] / scatter, found[k], slopes[k])
        for k in sorted(far, key=lambda k: -size[k])
    ]
