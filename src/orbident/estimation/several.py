"""Several recordings of one robot, identified as one.

Every recording is first identified by itself. Where all show the same robot, each is
fitted again beside what the others say (`solution.py`), one after another:
the last of these fits has seen all of them.

One result of several recordings: what is each one's own begins with its name.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, compress
from pathlib import Path
from typing import TypeVar

import numpy as np

from orbident.errors import InputError
from orbident.estimation.base_parameters import RANK, Known, exact_std, prior_std
from orbident.estimation.checks import Check
from orbident.estimation.estimate import Progress, Solved
from orbident.estimation.levels import ChiSquare, chi_square, limit
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.result import OWN, Result
from orbident.estimation.signals import Residual, Signals
from orbident.estimation.solution import Shared, together
from orbident.files.names import listed
from orbident.model.minimal_sets import MinimalSets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


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
    name = "agreement of recordings"
    # What is plainly wrong, or has no scale, is refused by itself.
    told = [
        not x.hindered and np.isfinite(x.estimate.parameters.base.covariance).all()
        for x in solved
    ]
    labels = [*compress(labels, told)]
    solved = [*compress(solved, told)]
    every = range(len(solved))
    if len(solved) < 2:
        return Check(name, "trust", "there are no two recordings that tell a robot")
    Q = _differ(solved)
    most = limit("same robot", Q.dof)
    if Q.value <= most:
        reason = f"all {len(solved)} recordings show the same robot"
        return Check(name, "trust", reason, "", Q.value, most)
    reason = f"{listed(labels)} do not show the same robot"
    if len(solved) > 2:
        without = [_differ([solved[j] for j in every if j != k]) for k in every]
        odd = int(np.argmin([one.value for one in without]))
        if not without[odd].is_no_chance("same robot"):
            reason = f"{labels[odd]} does not show the same robot as the others, which "
            reason += "agree with each other"
    return Check(
        name,
        "do not trust",
        f"{reason}: their base parameters differ by a chi-square of {Q.value:.3g}, and "
        f"more than {most:.3g} is no chance",
        "identify each by itself and compare the results: the robot may have changed "
        "in between, by a payload or by propellant, or a recording is in other units",
        Q.value,
        most,
    )


def _differ(solved: Sequence[Solved]) -> ChiSquare:
    """`Q`; what interpolation may do to exact recordings is no difference.

    Each recording is compared with the weighted mean of those before it, which adds up
    to the same. Beside recordings with positions those without show `pi` alone.
    """
    problem = solved[0].problem
    tracked = [each.problem.samples.tracked for each in solved]
    if any(tracked) and not all(tracked):
        whole = [*compress(solved, tracked)]
        pis = [each.estimate.parameters.pi for each in solved]
        first = pis[tracked.index(True)]
        found = [
            difference_in_pi(problem.robot, problem.sets, first, pi)
            for pi, shows in zip(pis, tracked, strict=True)
            if not shows
        ]
        found += [_differ(whole)] if len(whole) > 1 else []
        return ChiSquare(sum(x.value for x in found), sum(x.dof for x in found))
    exact = np.diag(exact_std(problem.robot, problem.sets) ** 2)
    bases = [each.estimate.parameters.base for each in solved]
    # Parameters have units: unit deviations while inverting.
    std = np.min([np.sqrt(np.diag(b.covariance + exact)) for b in bases], axis=0)
    (mean, P), *others = (
        (b.values / std, (b.covariance + exact) / np.outer(std, std)) for b in bases
    )
    Q, dof = 0.0, 0
    for values, C in others:
        apart = chi_square(values - mean, P + C)
        Q, dof = Q + apart.value, dof + apart.dof
        K = np.linalg.solve(P + C, P).T
        mean, P = mean + K @ (values - mean), K @ C
    return ChiSquare(Q, dof)


def difference_in_pi(
    robot: Robot, sets: MinimalSets, one: Known, other: Known
) -> ChiSquare:
    """Chi-square of the difference of two `pi`, as far as both are determined.

    There are more of `pi` than numbers that they depend on: of their covariance's
    eigenvalues no more than these count.
    """
    known = one.determined & other.determined
    of_pi = sets.derivatives(sets.beta(robot.theta))[0][known]
    free = np.linalg.matrix_rank(of_pi * prior_std(robot, sets), rtol=RANK)
    exact = of_pi * exact_std(robot, sets)
    C = (one.covariance + other.covariance)[np.ix_(known, known)] + exact @ exact.T
    std = np.sqrt(np.diag(C))
    values, vectors = np.linalg.eigh(C / np.outer(std, std))
    d = (other.values - one.values)[known] / std
    z = vectors.T[-free:] @ d / np.sqrt(values[-free:])
    return ChiSquare(float(z @ z), int(free))


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


def as_one(
    results: Sequence[Result], labels: Sequence[str], agreement: Check
) -> Result:
    """The result of all recordings.

    Args:
        results: of each; the last has seen all of them.
        labels: the names of the recordings.
        agreement: whether they show the same robot.
    """
    last = results[-1]
    named = [
        each.solved and each.solved._replace(label=label)
        for label, each in zip(labels, results, strict=True)
    ]
    own = {
        name: _every(labels, [getattr(one, name) for one in results]) for name in OWN
    }
    one = replace(
        last,
        **own,
        checks=(agreement, *_checks(results, labels)),
        notes=_notes(results, labels),
        residual=_residual(results, labels),
        samples=sum(one.samples for one in results),
        solved=next(filter(None, named), None),
        signals=lambda: _signals(results, labels),
    )
    return one if one.status == last.status else one.withheld()


T = TypeVar("T")


def _every(labels: Sequence[str], parts: Sequence[Mapping[str, T]]) -> dict[str, T]:
    return {
        f"{label}: {name}": value
        for label, part in zip(labels, parts, strict=True)
        for name, value in part.items()
    }


def _checks(results: Sequence[Result], labels: Sequence[str]) -> Iterator[Check]:
    """What holds for all of them alike is said once."""
    common = set.intersection(*({c.words for c in one.checks} for one in results))
    yield from (check for check in results[-1].checks if check.words in common)
    for label, one in zip(labels, results, strict=True):
        for check in one.checks:
            if check.words not in common:
                yield check.of(label)


def _notes(results: Sequence[Result], labels: Sequence[str]) -> tuple[str, ...]:
    common = set.intersection(*(set(one.notes) for one in results))
    own = (
        f"{label}: {note}"
        for label, one in zip(labels, results, strict=True)
        for note in one.notes
        if note not in common
    )
    return (*(note for note in results[-1].notes if note in common), *own)


def _residual(results: Sequence[Result], labels: Sequence[str]) -> Residual:
    """The residuals of every sensor, and chi-square as if all were one recording."""
    parts = [one.residual for one in results]
    ratios = [part.get("chi2_per_dof") for part in parts]
    known = [
        (r, one.samples)
        for r, one in zip(ratios, results, strict=True)
        if r is not None
    ]
    chi2, samples = (sum(c * n for c, n in known), sum(n for _, n in known))
    return {
        "rms": _every(labels, [part.get("rms", {}) for part in parts]),
        "chi2_per_dof": chi2 / samples if samples else None,
        "sensors": _every(labels, [part.get("sensors", {}) for part in parts]),
    }


def _signals(results: Sequence[Result], labels: Sequence[str]) -> Signals:
    return tuple(
        signal._replace(name=f"{label}: {signal.name}")
        for label, one in zip(labels, results, strict=True)
        for signal in one.signals()
    )
