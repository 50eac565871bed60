"""What the base is commanded to do while it is tracked: a slew."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float


class Slew(NamedTuple):
    """The base turns by an angle about an axis, from rest to rest, by a quintic."""

    start: Float[np.ndarray, "4"]
    """Attitude at the start, unit quaternion, scalar last."""
    axis: Float[np.ndarray, "3"]
    """Unit vector, base axes."""
    angle: float
    """rad."""
    duration: float
    """s."""

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]
    ]:
        """Attitude `x_WD`, rate and acceleration in D's axes, rad and s."""
        s = np.clip(t / self.duration, 0.0, 1.0)[:, None]
        turned = self.angle * s**3 * (10 - 15 * s + 6 * s**2)
        rate = self.angle * 30 * s**2 * (1 - s) ** 2 / self.duration
        faster = self.angle * 60 * s * (1 - s) * (1 - 2 * s) / self.duration**2
        v, w = self.start[:3], self.start[3]
        e, c = np.sin(turned / 2) * self.axis, np.cos(turned / 2)
        x_WD = np.hstack([w * e + c * v + np.cross(v, e), w * c - (e @ v)[:, None]])
        return x_WD, rate * self.axis, faster * self.axis
