"""Which sensor's clock, if it ran fast or slow, would explain what the sensors show."""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.recordings.recording import Recording

SMALL = 1e-5
"""A clock that is so much too fast is a millisecond off after 100 s."""

CLOCKS = {
    "joints": ("joint.", "wheel."),
    "position": ("position.",),
}
"""Sensors that may have a clock of their own, and what their columns begin with."""


def fast_clocks(problem: MomentumProblem) -> Iterator[Suspect]:
    """Sensors whose clock runs fast beside the others', from the first sample on."""
    for name, columns in CLOCKS.items():
        if not any(each.startswith(columns) for each in problem.recording.columns):
            continue

        def words(c: Numbers, name: str = name) -> str:
            way = "fast" if c[0] > 0 else "slow"
            return f"the clock of the {name} runs {100 * abs(c[0]):.2g} % {way}"

        def corrected(
            problem: MomentumProblem, c: Numbers, columns: tuple[str, ...] = columns
        ) -> MomentumProblem:
            recording = problem.recording
            return problem.amended(recording=_slower(recording, columns, c[0]))

        yield Suspect(words, np.array([SMALL]), corrected)


def _slower(recording: Recording, columns: tuple[str, ...], part: float) -> Recording:
    """What is recorded at `t` is what was so at `(1 + part) t`; `t_0` is zero.

    A row beyond the ends of the recording is still near enough.
    """
    t = recording.t
    at, row = t[0] + (t - t[0]) / (1 + part), float(np.median(np.diff(t)))
    right = {}
    for name, column in recording.columns.items():
        seen = np.isfinite(column)
        if name.startswith(columns) and np.count_nonzero(seen) > 1:
            first, last = t[seen][[0, -1]]
            near = (at > first - row) & (at < last + row)
            right[name] = np.where(near, CubicSpline(t[seen], column[seen])(at), np.nan)
    return recording.with_columns(right)
