"""A recording's samples one by one, as a loop of one's own has them."""

from collections.abc import Iterator

import numpy as np

from orbident.estimation.recursive.filter import Sample
from orbident.preprocessing.samples import Samples


def stream(samples: Samples, w_smooth: np.ndarray | None = None) -> Iterator[Sample]:
    """All samples; NaN where something was not measured.

    Args:
        samples: of a recording.
        w_smooth: the smoothed base rate; the gyro's samples where it is None.
    """
    at, nothing = samples.batch(0, samples.t.size), np.full(3, np.nan)
    for k, t in enumerate(samples.t):
        w = at.w[k] if at.turning[k] else nothing
        yield Sample(
            t=float(t),
            q=at.q[k],
            qd=at.qd[k],
            w=w,
            x_WB=at.x_WB[k],
            qd_rw=at.qd_rw[k],
            v_S=at.v_S[k] if at.moving[k] else nothing,
            w_smooth=w if w_smooth is None else w_smooth[k],
            h_given=np.zeros(3),
        )
