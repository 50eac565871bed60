"""One sample of what estimation needs, as it comes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Shaped

from orbident.signals.samples import Samples

SIZE = 1024
"""Samples taken from a recording at once."""


class Sample(NamedTuple):
    """What was measured at one time, float32 or float64; NaN where nothing was.

    Without its velocity a sample counts for the momentum alone; without anything else
    it does not count.
    """

    t: float
    q: Shaped[np.ndarray, " joints"]
    qd: Shaped[np.ndarray, " joints"]
    w: Shaped[np.ndarray, "3"]
    """Gyro, base axes, rad/s."""
    x_WB: Shaped[np.ndarray, "4"]
    qd_rw: Shaped[np.ndarray, " wheels"]
    v_S: Shaped[np.ndarray, "3"]
    """Of S, inertial axes, m/s."""
    w_smooth: Shaped[np.ndarray, "3"]
    """The rate with less noise, where regressors are evaluated; or the gyro again."""
    drift: Shaped[np.ndarray, "3 3"]
    """Of `v_S` by a bias of the accelerometer it was integrated from; else zero, s."""

    @property
    def packed(self) -> Float[np.ndarray, " all"]:
        """Everything but the time in one vector of float64."""
        return np.concatenate([*self[1:8], self.drift.ravel()], dtype=np.float64)

    @property
    def complete(self) -> bool:
        """Whether all is there but, perhaps, the velocity."""
        needed = (self.q, self.qd, self.w, self.x_WB, self.qd_rw, self.w_smooth)
        return bool(np.isfinite(np.concatenate(needed)).all())


def stream(
    samples: Samples, w_smooth: Float[np.ndarray, "samples 3"] | None = None
) -> Iterator[Sample]:
    """The samples of a recording, one by one.

    Args:
        samples: of a recording.
        w_smooth: the smoothed base rate; the gyro's samples where it is None.
    """
    nothing = np.full(3, np.nan)
    for start in range(0, samples.t.size, SIZE):
        batch = samples.batch(start, SIZE)
        for k, t in enumerate(samples.t[start : start + SIZE]):
            w = batch.w[k] if batch.turning[k] else nothing
            yield Sample(
                t=float(t),
                q=batch.q[k],
                qd=batch.qd[k],
                w=w,
                x_WB=batch.x_WB[k],
                qd_rw=batch.qd_rw[k],
                v_S=batch.v_S[k] if batch.moving[k] else nothing,
                w_smooth=w if w_smooth is None else w_smooth[start + k],
                drift=batch.drift[k],
            )
