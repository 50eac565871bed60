"""The samples of a long recording, stretch by stretch."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.delays import delays
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import Roughness, Settings, fits_of, smooth_rates
from orbident.recordings.long_recording import LongRecording, Stretch
from orbident.robot.description import Robot
from orbident.threads import side_by_side

Taken = TypeVar("Taken")


COLUMNS = ("q", "qd", "w", "x_WB", "qd_rw", "v_S")


class Part(NamedTuple):
    """The samples of a stretch, and of rows beside it."""

    samples: Samples
    own: slice
    """Those of the stretch itself."""
    rejected: Mapping[str, Mapping[str, int]]
    """How many of these were left out, by column and reason."""


@dataclass(frozen=True)
class Stretches:
    """The samples of a long recording, stretch by stretch."""

    robot: Robot
    recording: LongRecording
    late: Mapping[str, float]
    settings: Settings
    size: int

    def each(self, take: Callable[[Part], Taken]) -> Iterator[Taken]:
        """What becomes of each stretch, in order; several are worked on at once."""

        def taken(stretch: Stretch) -> Taken:
            recording, own = stretch
            clean = cleaned(self.robot, recording, self.settings, own)
            samples = samples_of(self.robot, clean.recording, self.late, self.settings)
            return take(Part(samples, own, clean.rejected))

        moved = self._moved()
        stretches = self.recording.stretches(
            lambda name: moved + self.settings.beside(name), self.size
        )
        return side_by_side(taken, stretches)

    def _moved(self) -> int:
        """Samples by which clocks are apart, at most."""
        digest = self.recording.digest
        behind = delays(self.robot, digest, self.late).values()
        step = float(np.median(np.diff(digest.t)))
        return int(np.ceil(max(map(abs, behind)) / step))


def some_rows(samples: Samples, rows: slice) -> Samples:
    """Some rows, not copied."""
    columns = {
        name: tuple(column[rows] for column in getattr(samples, name))
        for name in COLUMNS
    }
    return replace(samples, t=samples.t[rows], **columns)


def smoothed_rate(samples: Samples, settings: Settings) -> Float[np.ndarray, "n 3"]:
    """The base rate as smooth as joint rates are, rad/s.

    Args:
        samples: consecutive ones.
        settings: of the whole recording.
    """
    w = np.column_stack(samples.w)
    if samples.origins["base_rate"] is Origin.SMOOTHED_ATTITUDE:
        return w
    fits = _roughness(samples, w, settings)
    return smooth_rates(samples.t, w, samples.t, _gyro_of(samples), fits).x


def rate_scatter(samples: Samples, settings: Settings) -> float:
    """How far the gyro's samples scatter about the smoothed rate, rad/s.

    Args:
        samples: of the whole recording, or of a digest of it.
        settings: of the whole recording.
    """
    if samples.origins["base_rate"] is Origin.SMOOTHED_ATTITUDE:
        return 0.0
    fits = _roughness(samples, np.column_stack(samples.w), settings)
    return float(np.nan_to_num([fit.noise_std for fit in fits]).max())


def _roughness(
    samples: Samples, w: Float[np.ndarray, "n 3"], settings: Settings
) -> list[Roughness]:
    find = partial(fits_of, samples.t, w, name=_gyro_of(samples))
    return settings.smoothers("gyro", find)


def _gyro_of(samples: Samples) -> str:
    return f"{samples.source}: gyro"
