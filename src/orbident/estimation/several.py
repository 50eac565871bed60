"""Several recordings of one robot, identified as one.

Every recording is first identified by itself. Where all show the same robot, each is
fitted again beside what the others say (`output_error/shared.py`), one after another:
the last of these fits has seen all of them.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.special import chdtri

from orbident.errors import InputError
from orbident.estimation.check import Check
from orbident.estimation.estimate import Progress, Solved
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.shared import together
from orbident.estimation.prior_std import exact_std
from orbident.estimation.shared import Shared
from orbident.files.names import listed
from orbident.recordings.recording import Recording

CHANCE = 1e-4
"""Probability that recordings of the same robot seem to differ."""


def check_different(recordings: Sequence[Recording]) -> None:
    """Refuse a recording that is there twice: it would count twice.

    Raises:
        InputError: two of them have the same samples.
    """
    for one, other in combinations(recordings, 2):
        if one.columns.keys() == other.columns.keys() and all(
            np.array_equal(values, other.columns[name], equal_nan=True)
            for name, values in one.columns.items()
        ):
            raise InputError(
                f"{one.source} and {other.source} are the same recording, which would "
                "count twice; give each once"
            )


def labels_of(recordings: Sequence[Recording]) -> list[str]:
    """What the recordings are called: by their files, or by number."""
    names = [Path(recording.source).stem for recording in recordings]
    if len(set(names)) == len(names):
        return names
    return [f"recording {k}" for k in range(1, len(names) + 1)]


def agreement(solved: Sequence[Solved], labels: Sequence[str]) -> Check:
    """Whether the recordings show the same base parameters.

    With `b_k` and `C_k` what each one shows by itself, `b` their weighted mean,

        Q = sum_k (b_k - b)^T C_k^-1 (b_k - b)

    is chi-square distributed where they do (Cochran 1954).
    """
    name, every = "agreement of recordings", range(len(solved))
    Q, limit = _differ(solved), _limit(solved, len(solved))
    if limit >= Q:
        reason = f"all {len(solved)} recordings show the same robot"
        return Check(name, "trust", reason, "", Q, limit)
    reason = f"{listed(labels)} do not show the same robot"
    if len(solved) > 2:
        without = [_differ([solved[j] for j in every if j != k]) for k in every]
        odd = int(np.argmin(without))
        if without[odd] <= _limit(solved, len(solved) - 1):
            reason = f"{labels[odd]} does not show the same robot as the others, which "
            reason += "agree with each other"
    return Check(
        name,
        "do not trust",
        f"{reason}: their base parameters differ by a chi-square of {Q:.3g}, and more "
        f"than {limit:.3g} is no chance",
        "identify each by itself and compare the results: the robot may have changed "
        "in between, by a payload or by propellant, or a recording is in other units",
        Q,
        limit,
    )


def _limit(solved: Sequence[Solved], recordings: int) -> float:
    size = solved[0].estimate.found.base.values.size
    return float(chdtri((recordings - 1) * size, CHANCE))


def _differ(solved: Sequence[Solved]) -> float:
    """`Q`; what interpolation may do to exact recordings is no difference."""
    problem = solved[0].problem
    exact = exact_std(problem.robot, problem.sets)
    bases = [each.estimate.found.base for each in solved]
    # Parameters have units: unit deviations while inverting.
    std = np.min([np.sqrt(np.diag(b.covariance) + exact**2) for b in bases], axis=0)
    weights = [
        np.linalg.inv((b.covariance + np.diag(exact**2)) / np.outer(std, std))
        for b in bases
    ]
    values = [b.values / std for b in bases]
    pulled = sum(W @ b for W, b in zip(weights, values, strict=True))
    mean = np.linalg.solve(np.sum(weights, axis=0), pulled)
    return float(
        sum((b - mean) @ W @ (b - mean) for W, b in zip(weights, values, strict=True))
    )


def solved_together(
    solved: Sequence[Solved], estimator: OutputError, progress: Progress
) -> list[Solved]:
    """Fit each recording again beside what the others say of the robot.

    Args:
        solved: every recording by itself.
        estimator: by output error.
        progress: is called with the fraction of the work that is done.
    """
    found = list(solved)
    said = [_said(each) for each in solved]
    for k, each in enumerate(solved):
        # What was said last was said nearest to the truth.
        others = together([*said[k + 1 :], *said[:k]])
        estimate = replace(estimator, others=others).estimate(
            each.problem, lambda part, k=k: progress((k + part) / len(solved))
        )
        found[k] = each._replace(estimate=estimate, shown=estimate)
        said[k] = _said(found[k])
    return found


def _said(solved: Solved) -> Shared:
    assert solved.estimate.shared is not None
    return solved.estimate.shared()
