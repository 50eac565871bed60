"""When did the robot change? The generalised likelihood ratio of the innovations.

While nothing changes, whitened innovations are independent with zero mean. A capture,
a release or a loss gives them a mean, unknown and from an unknown sample on; twice the
logarithm of the likelihood ratio is then (Willsky and Jones 1976; Basseville and
Nikiforov 1993, section 4.4)

    g = max over j of |white_j + ... + white_k|^2 / (k - j + 1)

and each of its terms is chi-square with as many degrees of freedom as there are rows
(the core's `change_detection.hpp`). The probability that any of them exceeds a
threshold in a whole run is at most the sum over all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.special import chdtrc, chdtri

from orbident import _core
from orbident.estimation.levels import LEVELS
from orbident.estimation.recursion import Change

COLOUR = 2.0
"""Smoothed joint rates keep an encoder's error for half a second: sums of innovations
vary by up to so much more than white ones."""


FEW = 3
"""Changes that are named one by one: a recording hardly has more."""


@dataclass(frozen=True)
class Detector:
    """The test, and how often it may be wrong."""

    rows: int
    """Size of an innovation."""
    window: int = 20
    """Samples that the onset may lie back."""
    false_alarms: float = LEVELS["change"]
    """Probability of one in a run of so many samples without a change, at most."""
    samples: int = 1600

    @cached_property
    def threshold(self) -> float:
        """Threshold of `g`."""
        each = self.false_alarms / (self.samples * self.window)
        return COLOUR * float(chdtri(self.rows, each))

    def start(self) -> _core.Watch:
        """Nothing seen."""
        return _core.Watch(self.rows, self.window)

    def step(
        self, watch: _core.Watch, t: float, white: Float[np.ndarray, " e"]
    ) -> tuple[_core.Watch, float, Change | None]:
        """Take one innovation in.

        Args:
            watch: what was seen before; it is not changed.
            t: of the sample, s.
            white: its whitened innovation.

        Returns:
            What is remembered, `g` over its threshold, and the change if there is one.
        """
        after, g, onset = watch.step(t, np.ascontiguousarray(white, dtype=float))
        change = self.change(t, onset, g) if g > self.threshold else None
        return after, g / self.threshold, change

    def change(self, t: float, onset: float, g: float) -> Change:
        """The change that a statistic above the threshold tells."""
        tests = self.samples * self.window
        alarm = min(1.0, tests * float(chdtrc(self.rows, g / COLOUR)))
        return Change(t, onset, g / self.threshold, 1.0 - alarm)


def changes_in_words(changes: Sequence[Change]) -> tuple[str, ...]:
    """The first ones, a sentence each, and how many more there are."""
    first = tuple(
        f"the robot changed at t = {change.onset:.4g} s (found at {change.t:.4g} s; by "
        f"chance with a probability of {1 - change.confidence:.1g}): the estimates are "
        "those after that"
        for change in changes[:FEW]
    )
    more = changes[FEW:]
    if not more:
        return first
    return (
        *first,
        f"the robot seems to have changed {len(more)} more times, last at t = "
        f"{more[-1].onset:.4g} s: check the robot file, the signs and units of the "
        "recording, and --initial-momentum",
    )
