"""What of a topic's samples is no measurement, and is left empty."""

from collections import Counter, defaultdict
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from orbident.recordings.no_measurements import no_measurements, sensor_groups
from orbident.recordings.topics.timing import Timed

_BLOCK_ROWS = 65_536
"""Samples that are looked at together: of what is held, some are kept where they meet.
"""


@dataclass(frozen=True, eq=False)
class Emptied:
    """The samples of one entry that are left empty."""

    empty: Bool[np.ndarray, "used columns"]
    reasons: dict[str, dict[str, int]]
    """How many samples, by sensor and reason."""

    @classmethod
    def of(cls, timed: Timed) -> "Emptied":
        """What is found among all samples, in the order of their times."""
        names = timed.values.entry.columns
        groups = [
            (sensor, [names.index(name) for name in columns])
            for sensor, columns in sensor_groups(names).items()
        ]
        empty = np.zeros((timed.order.size, len(names)), dtype=bool)
        reasons = defaultdict[str, Counter[str]](Counter)
        if timed.values.zeros:
            reasons["attitude"]["quaternion of zeros"] = timed.values.zeros
        for start in range(0, timed.order.size, _BLOCK_ROWS):
            rows = slice(start, start + _BLOCK_ROWS)
            block = timed.values.rows.gather(timed.order[rows])
            for sensor, columns in groups:
                for reason, mask in no_measurements(sensor, block[:, columns]).items():
                    empty[start + np.flatnonzero(mask)[:, None], columns] = True
                    reasons[sensor][reason] += int(mask.sum())
        return cls(empty, {sensor: dict(why) for sensor, why in reasons.items()})

    def without(
        self, values: Float[np.ndarray, "n columns"], rows: slice
    ) -> Float[np.ndarray, "n columns"]:
        """These samples, those that are no measurement as NaN."""
        return np.where(self.empty[rows], np.nan, values)
