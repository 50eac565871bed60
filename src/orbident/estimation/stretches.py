"""The samples of a long recording, stretch by stretch."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

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
from orbident.recordings.long_recording import LongRecording, Stretch
from orbident.robot.description import Robot
from orbident.threads import ahead

Rejected = Mapping[str, Mapping[str, int]]
"""How many samples were left out, by column and reason."""

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

    def with_rejected(self) -> Iterator[tuple[Samples, Rejected]]:
        """Consecutive samples, each once; and what was left out of each stretch."""
        return ahead(map(_own, self._with_others()))

    def with_rates(self) -> Iterator[tuple[Samples, Float[np.ndarray, "n 3"]]]:
        """The same, and their smoothed base rates, rad/s."""

        def with_rate(
            part: WithOthers,
        ) -> tuple[Samples, Float[np.ndarray, "n 3"]]:
            rate, _ = smoothed_rate(part.samples, self.settings)
            return cut(part.samples, part.own), rate[part.own].copy()

        return map(with_rate, self._with_others())

    def _with_others(self) -> Iterator["WithOthers"]:
        """All stretches, with the samples beside them.

        Nothing here holds one while the next is read: each takes much memory.
        """
        moved = self._moved()
        stretches = self.recording.stretches(
            lambda name: moved + self.settings.beside(name), self.size
        )
        found: dict[str, list[np.ndarray]] = {}
        yield from map(partial(self._sampled, found), stretches)
        if not self._spikes:
            self._spikes.append({n: np.concatenate(rows) for n, rows in found.items()})

    def _sampled(
        self, found: dict[str, list[np.ndarray]], stretch: Stretch
    ) -> "WithOthers":
        """One stretch; its spikes are added to those found before it."""
        recording, own, first = stretch
        if self._spikes:
            at_hand = spikes_within(self._spikes[0], first, first + recording.t.size)
        else:
            at_hand = spikes(recording)
            for name, rows in spikes_within(at_hand, own.start, own.stop).items():
                found.setdefault(name, []).append(rows + first + own.start)
        clean = without(recording, at_hand, own)
        samples = samples_of(self.robot, clean.recording, self.late, self.settings)
        return WithOthers(samples, own, clean.rejected)

    def _moved(self) -> int:
        """Samples by which clocks are apart, at most."""
        digest = self.recording.digest
        behind = delays(self.robot, digest, self.late).values()
        step = float(np.median(np.diff(digest.t)))
        return int(np.ceil(max(map(abs, behind)) / step))


class WithOthers(NamedTuple):
    """The samples of a stretch, and of rows beside it."""

    samples: Samples
    own: slice
    """Those of the stretch itself."""
    rejected: Rejected


def _own(part: WithOthers) -> tuple[Samples, Rejected]:
    return cut(part.samples, part.own), part.rejected


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
