"""Single samples that are off what their neighbours show: spikes within the motion.

Screening leaves out only what leaps out of the motion. What is smaller than the steps
of a joint that moves is far beyond noise all the same.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import maximum_filter1d, median_filter

from orbident import _core
from orbident.diagnosis.shown import shown_by, without
from orbident.diagnosis.trial import Trial, amended_trial
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import NORMAL
from orbident.threads import processors

OFF = 8.0
"""Times the scatter of what neighbours predict."""

AROUND, NEIGHBOURS = 101, 5
"""Samples that tell the scatter, and that one spike spoils."""

ROUNDS = 8
"""Rounds, at most; each leaves out samples that are the worst of their neighbours."""

MOST = 0.1
"""Part of a sensor's samples: more are no exceptions."""


def spikes(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again without such samples."""
    left, found = problem.recording, dict[str, int]()
    for sensor, shown in shown_by(problem.robot, problem.recording).items():
        off = np.logical_or.reduce([outlying(left.t, x) for x in shown.T])
        if 0 < off.sum() < MOST * off.size:
            left, found[sensor] = without(left, sensor, off), int(off.sum())
    if not found:
        return
    which = max(found, key=lambda sensor: found[sensor])
    words = (
        f"spikes (outliers): {found[which]} samples of {which.replace('.', ' ')} are "
        "far from what their neighbours show"
    )
    yield amended_trial(words, problem, recording=left)


def outlying(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """Samples that a cubic through two neighbours on either side does not expect."""
    kept, off = np.flatnonzero(np.isfinite(x)), np.zeros(x.size, dtype=bool)
    for _ in range(ROUNDS):
        if kept.size < AROUND:
            break
        inner = kept[2:-2]
        # At the ends all neighbours would be on one side.
        expected = _core.expected_samples(t[kept], x[kept], 1, processors())
        r = np.abs(x[inner] - expected[2:-2])
        worst = (r == maximum_filter1d(r, NEIGHBOURS)) & (
            r > OFF * NORMAL * median_filter(r, AROUND)
        )
        if not worst.any():
            break
        off[inner[worst]] = True
        kept = kept[~off[kept]]
    return off
