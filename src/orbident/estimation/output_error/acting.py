"""Tables of what acts from outside, for the core's `acting.hpp`.

With `F`, `tau` (about S) and the pull `a` in inertial axes, and `r` from S to the CM,

    dh_cm/dt = tau - r x F,    M dv_cm/dt = F + M a,    M r = moments beta.

An accelerometer feels `F / M`.
"""

from functools import cached_property

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.followed import Followed, integral
from orbident.estimation.output_error.forms import (
    Disturbance,
    Effect,
    disturbances,
    nothing,
)

ROWS = 15
"""Of a node: h_cm, its rate, r_cm, v_cm and what is felt, three axes each."""


class Acting:
    """What may act along a recording; it is worked out when it is first asked for."""

    def __init__(self, followed: Followed, first: int) -> None:
        """Of a recording.

        Args:
            followed: the motion that was measured.
            first: the place of the first disturbance among the core's calibrations.
        """
        self.followed, self.first = followed, first

    @cached_property
    def disturbances(self) -> tuple[Disturbance, ...]:
        """All that may act."""
        return tuple(disturbances(self.followed))

    @property
    def places(self) -> Float[np.ndarray, " disturbances"]:
        """Of all disturbances."""
        return self.first + np.arange(float(len(self.disturbances)))

    def table(
        self,
        beta: Float[np.ndarray, " beta"],
        gains: Float[np.ndarray, " selected"],
        selected: Float[np.ndarray, " selected"],
    ) -> Float[np.ndarray, "nodes rows columns"]:
        """At these parameters: value, by each selected gain, by `beta`.

        Args:
            beta: base parameters.
            gains: of the selected calibrations and disturbances.
            selected: their places; those before the first are not disturbances.
        """
        chosen = [
            (self.disturbances[int(place) - self.first], float(gain))
            for place, gain in zip(selected, gains, strict=True)
            if place >= self.first
        ]
        if not chosen:
            return np.zeros((0, ROWS, 1 + beta.size))
        r = self.followed.moments @ beta / beta[0]
        total = nothing(self.followed.t.size)
        for each, gain in chosen:
            total = total.plus(each.effect.times(gain))
        table = np.zeros((self.followed.t.size, ROWS, 1 + len(chosen) + beta.size))
        table[:, :, 0] = self._moved(total, r, beta[0])
        for k, (each, _) in enumerate(chosen):
            table[:, :, 1 + k] = self._moved(each.effect, r, beta[0])
        if total.force.any():
            table[:, :, 1 + len(chosen) :] = self._by_beta(total, r, beta[0])
        return table

    def _moved(
        self, effect: Effect, r: Float[np.ndarray, "nodes 3"], M: float
    ) -> Float[np.ndarray, "nodes 15"]:
        rate = effect.torque - np.cross(r, effect.force)
        felt = effect.force / M
        v = integral(self.followed.t, felt + effect.pull)
        h = integral(self.followed.t, rate)
        return np.hstack([h, rate, integral(self.followed.t, v), v, felt])

    def _by_beta(
        self, effect: Effect, r: Float[np.ndarray, "nodes 3"], M: float
    ) -> Float[np.ndarray, "nodes 15 beta"]:
        """Of the lever arm, and of what a force does to the mass."""
        by_r = self.followed.moments / M
        by_r[:, :, 0] -= r / M
        rate = -np.cross(by_r, effect.force[:, :, None], axis=1)
        slopes = np.zeros((self.followed.t.size, ROWS, by_r.shape[2]))
        slopes[:, 0:3], slopes[:, 3:6] = integral(self.followed.t, rate), rate
        felt = -effect.force / M**2
        v = integral(self.followed.t, felt)
        slopes[:, 6:9, 0], slopes[:, 9:12, 0] = integral(self.followed.t, v), v
        slopes[:, 12:15, 0] = felt
        return slopes
