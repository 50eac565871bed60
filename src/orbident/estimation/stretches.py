"""The samples of a long recording, stretch by stretch."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.base_motion import SMOOTHED
from orbident.preprocessing.delays import delays
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import (
    FoundSpikes,
    spikes,
    spikes_within,
    without,
)
from orbident.preprocessing.settings import Settings
from orbident.preprocessing.smoothing import fits_of, smooth
from orbident.recordings.long_recording import LongRecording
from orbident.robot.description import Robot
from orbident.threads import ahead

COLUMNS = ("q", "qd", "w", "x_WB", "qd_rw", "v_S")


@dataclass(frozen=True)
class Stretches:
    """The samples of a long recording, stretch by stretch, again and again."""

    robot: Robot
    recording: LongRecording
    late: Mapping[str, float]
    settings: Settings
    size: int
    _spikes: list[FoundSpikes] = field(default_factory=list)
    """Of the whole recording, once it has been read: to look for them takes longer than
    all else."""

    def with_rejected(
        self,
    ) -> Iterator[tuple[Samples, Mapping[str, Mapping[str, int]]]]:
        """Consecutive samples, each once; and what was left out of each stretch."""
        return ahead(
            (cut(samples, own), rejected)
            for samples, own, rejected in self._with_others()
        )

    def with_rates(self) -> Iterator[tuple[Samples, Float[np.ndarray, "n 3"]]]:
        """The same, and their smoothed base rates, rad/s."""
        for samples, own, _ in self._with_others():
            rate, _ = smoothed_rate(samples, self.settings)
            yield cut(samples, own), rate[own]

    def _with_others(
        self,
    ) -> Iterator[tuple[Samples, slice, Mapping[str, Mapping[str, int]]]]:
        """Samples of a stretch and beside it; which are its own; what was rejected."""
        moved = self._moved()
        stretches = self.recording.stretches(
            lambda name: moved + self.settings.beside(name), self.size
        )
        found: dict[str, list[np.ndarray]] = {}
        for recording, own, first in stretches:
            if self._spikes:
                at_hand = spikes_within(
                    self._spikes[0], first, first + recording.t.size
                )
            else:
                at_hand = spikes(recording)
                for name, rows in spikes_within(at_hand, own.start, own.stop).items():
                    found.setdefault(name, []).append(rows + first + own.start)
            clean = without(recording, at_hand, own)
            every = samples_of(self.robot, clean.recording, self.late, self.settings)
            yield every, own, clean.rejected
        if not self._spikes:
            self._spikes.append({n: np.concatenate(rows) for n, rows in found.items()})

    def _moved(self) -> int:
        """Samples by which clocks are apart, at most."""
        digest = self.recording.digest
        behind = delays(self.robot, digest, self.late).values()
        step = float(np.median(np.diff(digest.t)))
        return int(np.ceil(max(map(abs, behind)) / step))


def cut(samples: Samples, rows: slice) -> Samples:
    """Some rows, copied: the others' memory is free again."""
    columns = {
        name: tuple(column[rows].copy() for column in getattr(samples, name))
        for name in COLUMNS
    }
    return replace(samples, t=samples.t[rows].copy(), **columns)


def smoothed_rate(
    samples: Samples, settings: Settings
) -> tuple[Float[np.ndarray, "samples 3"], float]:
    """The base rate as smooth as joint rates are, and the gyro's scatter, rad/s.

    Args:
        samples: consecutive ones.
        settings: of the whole recording.
    """
    w = np.column_stack(samples.w)
    if samples.origins["base_rate"] == SMOOTHED:
        return w, 0.0
    t, name = samples.t, f"{samples.source}: gyro"
    fits = settings.smoothers("gyro", lambda: fits_of(t, w, name=name))
    smoothed = smooth(t, w, name=name, fits=fits)
    return smoothed.x, float(np.nan_to_num(smoothed.noise_std).max())
