"""Which sensor's clock, if it ran fast or slow, would explain what the sensors show."""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from orbident.estimation.causes.suspects import Numbers, Suspect
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.recordings.recording import Recording

SMALL_RATE = 1e-5
"""A clock that is so much too fast is a millisecond off after 100 s."""

CLOCKS = {
    "joints": ("joint.", "wheel."),
    "attitude": ("attitude.",),
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

        yield Suspect(words, np.array([SMALL_RATE]), corrected)


def _slower(recording: Recording, columns: tuple[str, ...], part: float) -> Recording:
    """What is recorded at `t` is what was so at `(1 + part) t`; rates go with it."""
    t = recording.t
    at = t[0] + (t - t[0]) / (1 + part)
    right = {}
    for name, column in recording.columns.items():
        seen = np.isfinite(column)
        if name.startswith(columns) and np.count_nonzero(seen) > 1:
            between = CubicSpline(t[seen], column[seen], extrapolate=False)
            right[name] = between(at)
    return recording.with_columns(right)
