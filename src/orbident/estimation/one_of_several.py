"""One result of several recordings: what is each one's own begins with its name."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

from orbident.estimation.check import Check
from orbident.estimation.quantities import Identified
from orbident.estimation.result import Result
from orbident.estimation.signals import Signals

T = TypeVar("T")


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
    refused = next((one for one in results if one.status == "rejected"), last)

    def every(name: str) -> dict[str, Any]:
        return _every(labels, [getattr(one, name) for one in results])

    one = replace(
        last,
        checks=(agreement, *_checks(results, labels)),
        notes=_notes(results, labels),
        residual=_residual(results, labels),
        biases=every("biases"),
        disturbances=every("disturbances"),
        clocks=every("clocks"),
        rejected=every("rejected"),
        origins=every("origins"),
        samples=sum(one.samples for one in results),
        solved=refused.solved,
        signals=lambda: _signals(results, labels),
    )
    if one.status == "ok" or last.status == "rejected":
        return one
    whole = Identified(
        **{each.name: getattr(last, each.name) for each in fields(Identified)}
    )
    return replace(one, **vars(whole.nothing()), diagnostics=whole)


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
                yield replace(
                    check,
                    name=f"{label}: {check.name}",
                    reason=f"{label}: {check.reason}",
                )


def _notes(results: Sequence[Result], labels: Sequence[str]) -> tuple[str, ...]:
    common = set.intersection(*(set(one.notes) for one in results))
    own = (
        f"{label}: {note}"
        for label, one in zip(labels, results, strict=True)
        for note in one.notes
        if note not in common
    )
    return (*(note for note in results[-1].notes if note in common), *own)


def _residual(results: Sequence[Result], labels: Sequence[str]) -> dict[str, Any]:
    """The residuals of every sensor, and chi-square as if all were one recording."""
    parts = [one.residual for one in results]
    known = [
        (part["chi2_per_dof"], one.samples)
        for part, one in zip(parts, results, strict=True)
        if part["chi2_per_dof"] is not None
    ]
    chi2, samples = (sum(c * n for c, n in known), sum(n for _, n in known))
    return {
        "rms": _every(labels, [part["rms"] for part in parts]),
        "chi2_per_dof": chi2 / samples if samples else None,
        "sensors": _every(labels, [part.get("sensors", {}) for part in parts]),
    }


def _signals(results: Sequence[Result], labels: Sequence[str]) -> Signals:
    return tuple(
        signal._replace(name=f"{label}: {signal.name}")
        for label, one in zip(labels, results, strict=True)
        for signal in one.signals()
    )
