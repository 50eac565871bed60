"""Spikes: samples that have nothing to do with the motion."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import median_filter, percentile_filter

from orbident import _core
from orbident.errors import InputError
from orbident.threads import processors

FARTHEST = 12
"""How far away neighbours are that predict a sample, in samples, at most. A burst of
five bad ones spoils less than half of them."""

NEIGHBOURHOOD = 101
"""Samples around one that tell how well samples are predicted there."""

SUSPECT = 6.0
"""Times the local scatter: one sample in five hundred million of Gaussian noise."""

USUAL = 90
"""Percentile of the steps from sample to sample around."""

LEAP = 4.0
"""Times that step: the sharpest turns of a joint that is sampled well stay below it."""

LONGEST = 10
"""Samples in a row that may be a burst; what lasts longer is motion."""

BESIDE = NEIGHBOURHOOD // 2 + 4 * FARTHEST
"""Samples beside one that tell how well it and those around it are predicted."""

ENDS = 6
"""Samples at either end that are left alone: with neighbours on one side only, what a
filter does there and a spike look the same."""

BLOCK = 16_384
"""Samples that are looked at together, and as many beside them as are needed."""

SIGMA = 1.4826
"""Std over median absolute value, of Gaussian noise."""

BIT = 1e-14
"""Rounding of the predictions, over the largest sample."""


@dataclass(frozen=True, eq=False)
class Spikes:
    """Which samples are spikes, and how many; they are reported, not removed."""

    mask: Bool[np.ndarray, " samples"]
    count: int


def find_spikes(
    t: Float[np.ndarray, " samples"], x: Float[np.ndarray, " samples"], name: str = "x"
) -> Spikes:
    """Samples that their neighbours do not expect, and that leap out of the motion.

    A spike is more than 6 times the local scatter off the median of 12 cubics, each
    through four neighbours at one distance (Hampel's identifier, on residuals), and by
    4 times more than samples around it usually move from one to the next: what does not
    leap is left for the estimator's statistics. Next to an impact, a step of the rate
    itself, samples may be taken for spikes.

    Args:
        t: times, s, strictly increasing.
        x: any unit; NaN where there is no sample.
        name: what `x` is, for messages.

    Raises:
        InputError: there are fewer than 5 valid samples, infinite values, or times that
            do not increase.
    """
    valid = np.flatnonzero(~np.isnan(x))
    if valid.size < 5:
        raise InputError(
            f"{name} has {valid.size} samples; spikes show among 5 or more"
        )
    mask = np.zeros(x.size, dtype=bool)
    for start in range(0, valid.size, BLOCK):
        around = valid[max(start - NEIGHBOURHOOD, 0) : start + BLOCK + NEIGHBOURHOOD]
        found = around[_spiky(t[around], x[around])]
        own = valid[start : start + BLOCK]
        mask[found[(own[0] <= found) & (found <= own[-1])]] = True
    mask[valid[:ENDS]] = mask[valid[-ENDS:]] = False
    return Spikes(mask, int(mask.sum()))


def _spiky(t: np.ndarray, x: np.ndarray) -> Bool[np.ndarray, " n"]:
    steps = np.abs(np.diff(x, prepend=x[0], append=x[-1]))
    leap = LEAP * percentile_filter(steps, USUAL, NEIGHBOURHOOD, mode="reflect")
    leaps, least = steps > leap / 2, BIT * np.abs(x).max()
    spiky = np.zeros(x.size, dtype=bool)
    for own in _eventful(leaps):
        around = slice(max(own.start - BESIDE, 0), own.stop + BESIDE)
        there = slice(own.start - around.start, own.stop - around.start)
        expected = _core.expected_samples(t[around], x[around], FARTHEST, processors())
        residual = np.abs(x[around] - expected)
        scatter = SIGMA * median_filter(residual, NEIGHBOURHOOD, mode="reflect")
        beyond = np.maximum(SUSPECT * np.maximum(scatter, least)[there], leap[:-1][own])
        spiky[own] = _bursts(residual[there] > beyond, leaps[own.start : own.stop + 1])
    return spiky


def _eventful(leaps: Bool[np.ndarray, " edges"]) -> Iterator[slice]:
    """Samples that may be in a burst, which two leaps close to each other enclose.

    Most of a recording is far from any, and need not be looked at.
    """
    at = np.flatnonzero(leaps)
    before, after = np.diff(at, prepend=-np.inf), np.diff(at, append=np.inf)
    at = at[np.minimum(before, after) <= LONGEST]
    apart = np.flatnonzero(np.diff(at) > 2 * (LONGEST + 1 + BESIDE)) + 1
    for every in np.split(at, apart) if at.size else ():
        first, last = int(every[0]) - LONGEST - 1, int(every[-1]) + LONGEST + 1
        yield slice(max(first, 0), min(last, leaps.size - 1))


def _bursts(
    suspect: Bool[np.ndarray, " n"], leaps: Bool[np.ndarray, " n+1"]
) -> Bool[np.ndarray, " n"]:
    """Suspects in runs that are no longer than a burst, with a leap at either end.

    Args:
        suspect: samples that were not expected.
        leaps: whether the signal leaps from the sample before each one, and after all.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], suspect.view(np.int8), [0]])))
    result = suspect.copy()
    for start, end in edges.reshape(-1, 2):
        if end - start > LONGEST or not (leaps[start] and leaps[end]):
            result[start:end] = False
    return result
