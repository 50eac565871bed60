"""Runs of a campaign, one after the other: what a worker does."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.campaign_table import Row
from orbident.campaigns.case import Case
from orbident.campaigns.folder import Campaign, versions
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.threads import one_thread


@dataclass(frozen=True)
class Failure:
    """A run that could not be made."""

    k: int
    document: dict[str, Any]
    """What was drawn, and why it failed, as JSON has it."""


class Chunk(NamedTuple):
    """What a worker gives back."""

    rows: tuple[Row, ...]
    failures: tuple[Failure, ...]
    versions: dict[str, str]
    """The versions of the libraries that computed the chunk."""


@one_thread
def run_chunk(campaign: Campaign, runs: range) -> Chunk:
    """Make these runs; one that raises is a failure, and the rest go on.

    Args:
        campaign: its spec, robots and trajectories.
        runs: their numbers.
    """
    rows: list[Row] = []
    failures: list[Failure] = []
    for k in runs:
        case = campaign.case(k)
        try:
            results = identified_by_method(campaign, case, case.recording())
            rows += result_rows(case, results)
        # Whatever it is: thousands of other runs are not to be lost for it.
        except Exception as error:
            failures.append(_failure(case, error))
    return Chunk(tuple(rows), tuple(failures), versions())


def identified_by_method(
    campaign: Campaign, case: Case, recording: Recording
) -> dict[str, Result]:
    """What each method of the campaign makes of a run's recording.

    Raises:
        InputError: the robot cannot be identified from it.
    """
    return {
        method: identify(case.subject.robot, recording, method)
        for method in campaign.spec.methods
    }


def result_rows(case: Case, results: Mapping[str, Result]) -> list[Row]:
    """A row for each method: its numbers, and the true ones."""
    sets = minimal_sets(case.subject.robot)
    # Of the formulas that an estimator is given, evaluated for the true bodies.
    true = sets.beta(case.robot.theta)
    return [_row(case, method, result, true) for method, result in results.items()]


def _row(
    case: Case, method: str, result: Result, true: Float[np.ndarray, " beta"]
) -> Row:
    refused = (c.name for c in result.checks if c.level == "do not trust")
    base = result.base
    row: Row = {
        "run": case.k,
        "robot": case.subject.robot.name,
        "method": method,
        "level": result.level,
        "refused_by": next(refused, None),
    }
    row |= {f"draw.{name}": value for name, value in case.draws.items()}
    for name, value, std, truth in zip(
        base.names, base.values, base.std, true, strict=True
    ):
        row[f"{name}.value"] = float(value)
        row[f"{name}.std"] = float(std)
        row[f"{name}.true"] = float(truth)
    return row


def _failure(case: Case, error: Exception) -> Failure:
    kind = type(error).__name__
    document = {
        "run": case.k,
        "robot": case.subject.robot.name,
        "draws": _draws(case),
        "error": kind,
        "reason": " ".join(str(error).split()) or kind,
        "traceback": traceback.format_exception(error),
    }
    return Failure(case.k, document)


def _draws(case: Case) -> dict[str, float]:
    try:
        return case.draws
    # A failure is to be reported even where what failed is the drawing.
    except Exception:
        return {}
