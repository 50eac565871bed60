"""A recording with other columns, fewer columns, or fewer rows."""

from collections.abc import Callable, Mapping

import numpy as np

from orbident.recordings.recording import Recording


def changed(
    recording: Recording,
    columns: Mapping[str, np.ndarray] | None = None,
    keep: Callable[[str], bool] = lambda _: True,
    rows: slice | np.ndarray = slice(None),
) -> Recording:
    merged = {**recording.columns, **(columns or {})}
    kept = {name: column[rows] for name, column in merged.items() if keep(name)}
    return Recording(recording.t[rows], kept)
