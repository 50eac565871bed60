"""The samples of a long recording, stretch by stretch; packed, in a temporary file."""

import tempfile
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import IO, NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.delays import delays
from orbident.preprocessing.origins import ENCODED, Origin
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import Roughness, Settings, fits_of, smooth_rates
from orbident.recordings.long_recording import LongRecording, Stretch
from orbident.robot.description import Robot
from orbident.threads import side_by_side


class Piece(NamedTuple):
    """Consecutive samples."""

    t: Float[np.ndarray, " n"]
    """s."""
    samples: Float[np.ndarray, "n all"]
    """Packed, one a row."""


class KeptPieces:
    """Pieces of a long recording, one after another, again and again.

    They are kept in a file without a name, which is gone when the process is. Where
    there is no room for it, each pass works them out anew.
    """

    def __init__(self, anew: Callable[[], Iterator[Piece]]) -> None:
        """`anew` works all pieces out, from the first one on."""
        self._anew = anew
        self._shapes: list[tuple[int, ...]] = []
        self._file = _without_name()
        if self._file is not None:
            weakref.finalize(self, _close, self._file)

    def keep(self, piece: Piece) -> None:
        """Keep one more, which comes after the others."""
        if self._file is None:
            return
        try:
            for table in piece:
                self._file.write(np.ascontiguousarray(table).data)
            self._file.flush()
            self._shapes.append(piece.samples.shape)
        except OSError:
            _close(self._file)
            self._file = None

    def __call__(self) -> Iterator[Piece]:
        """All pieces, from the first one on."""
        return self._anew() if self._file is None else self._read(self._file)

    def _read(self, file: IO[bytes]) -> Iterator[Piece]:
        file.seek(0)
        for n, width in self._shapes:
            t = np.frombuffer(file.read(8 * n))
            yield Piece(t, np.frombuffer(file.read(8 * n * width)).reshape(n, width))


def _without_name() -> IO[bytes] | None:
    with suppress(OSError):
        return tempfile.TemporaryFile()
    return None


def _close(file: IO[bytes]) -> None:
    # What the disk refused before is refused here again.
    with suppress(OSError):
        file.close()


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


ENDS = 0.5
"""s: so near to the ends of a recording a smoothed rate is ten times as wrong."""

PACKED = 4096
"""Samples that are packed at once: all of them at once take their memory four times."""


def packed_piece(
    samples: Samples,
    rate: Float[np.ndarray, "samples 3"],
    times: tuple[float, float],
    more: Float[np.ndarray, "samples more"] | None = None,
) -> Piece:
    """The samples that are complete and as good as they are said to be, one a row.

    Args:
        samples: consecutive ones.
        rate: the smoothed base rate, rad/s.
        times: between these they are that good, s.
        more: columns that need not be complete.
    """
    good = np.isfinite(rate).all(axis=1)
    good &= (samples.t >= times[0]) & (samples.t <= times[1])
    kept, tables = [], []
    for k, at in enumerate(samples.batches(PACKED)):
        own = slice(k * PACKED, (k + 1) * PACKED)
        complete = at.turning & good[own]
        v_S = np.where(at.moving[:, None], at.v_S, np.nan)
        every = [at.q, at.qd, at.w, at.x_WB, at.qd_rw, v_S, rate[own], at.h_given]
        every += [] if more is None else [more[own]]
        kept.append(samples.t[own][complete])
        tables.append(np.hstack(every)[complete])
    return Piece(np.concatenate(kept), np.concatenate(tables))


def trusted(samples: Samples) -> tuple[float, float]:
    """First and last time at which rates are as good as they are said to be, s.

    Args:
        samples: of the whole recording, or of a digest of it.
    """
    start, end = float(samples.t[0]), float(samples.t[-1])
    derived = samples.origins["joint_rates"] & ENCODED
    margin = ENDS if derived and end - start > 4 * ENDS else 0.0
    return start + margin, end - margin
