"""What the noise of attitude and position has beside white noise.

The cameras of motion capture and the markers that they see are not white: their errors
last. Each axis has two processes of its own, and all are independent. A first-order
Gauss-Markov process has a standard deviation `s` and a correlation time `T`:

    cov(x(t), x(t + tau)) = s^2 exp(-|tau| / T)

A random walk has a density `q`, and is zero at the first sample:

    var(x(t)) = q^2 t
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

PerAxis = float | tuple[float, float, float]
"""One number for all axes, or one for each."""


class Coloured(NamedTuple):
    """The parts that are not white, by axis; zero where there are none."""

    markov_std: Float[np.ndarray, "3"]
    """`s`, m or rad."""
    correlation_time: Float[np.ndarray, "3"]
    """`T`, s; 1 where there is no such part."""
    random_walk: Float[np.ndarray, "3"]
    """`q`, m/sqrt(s) or rad/sqrt(s)."""

    @property
    def absent(self) -> bool:
        """Whether the noise is white."""
        return not (self.markov_std.any() or self.random_walk.any())


WHITE = Coloured(np.zeros(3), np.ones(3), np.zeros(3))
"""Nothing lasts."""


def coloured_noise(section: Mapping[str, Any]) -> Coloured:
    """The parts that the robot file declares.

    Args:
        section: of attitude or position; empty where the file has none.
    """
    std, time, walk = (
        np.broadcast_to(np.asarray(section.get(name) or default, np.float64), 3)
        for name, default in (
            ("markov_std", 0.0),
            ("correlation_time", 1.0),
            ("random_walk", 0.0),
        )
    )
    return Coloured(std, np.where(std > 0, time, 1.0), walk)
