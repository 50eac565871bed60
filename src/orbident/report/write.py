"""The report of a RUN: which sections there are, and where it goes."""

from collections.abc import Sequence
from pathlib import Path

from orbident.estimation.result import Result
from orbident.estimation.signals import Signals
from orbident.files.text import write_text
from orbident.identified.run_folder import HISTORY, REPORT, VALIDATION
from orbident.report.budget_section import variance_shares
from orbident.report.conditioning import conditioning, excitation, identifiability
from orbident.report.convergence_section import (
    Trail,
    convergence,
    read_trail,
    recursion,
)
from orbident.report.fit import fits
from orbident.report.page import Section, page, verdict_of
from orbident.report.parameter_section import masses, parameters
from orbident.report.provenance import provenance, references
from orbident.report.replay_figure import replay_sections
from orbident.report.sensitivity_figure import sensitivities
from orbident.report.validation_section import read_validation

METHODS = {
    "least-squares": "least squares",
    "structured": "structured least squares",
    "maximum-likelihood": "maximum likelihood",
    "recursive": "recursion",
}

FEWEST = 16
"""Samples of a signal that says anything."""


def write_report(result: Result, folder: Path) -> Path:
    """Write `report.html` into a RUN folder.

    Args:
        result: that is kept there.
        folder: that exists.

    Raises:
        InputError: a file of the folder is damaged, or it cannot be written.
    """
    path = folder / REPORT
    trail, replay = read_trail(folder / HISTORY), replay_sections(folder)
    validated = read_validation(folder / VALIDATION)
    write_text(path, report_page(result, trail, replay, validated))
    return path


def report_page(
    result: Result,
    trail: Trail | None = None,
    replay: Sequence[Section] = (),
    validated: Section | None = None,
) -> str:
    """The report as HTML.

    Args:
        result: of an identification.
        trail: of a recursive one.
        replay: of the motion, where the folder keeps it.
        validated: how it predicted another recording, if it did.
    """
    sections = sections_of(result, seen(result), trail)
    if validated is not None:
        sections.insert(1, validated)
    return page(
        title=result.robot.name,
        subtitle=f"Identified by {METHODS.get(result.method, result.method)}",
        verdict=verdict_of(result),
        sections=[*sections, *replay],
    )


def seen(result: Result) -> Signals:
    """The signals of which there are enough samples to look at."""
    return tuple(signal for signal in result.signals() if signal.t.size >= FEWEST)


def sections_of(
    result: Result,
    signals: Signals,
    trail: Trail | None = None,
    known_as: str = "CAD",
) -> list[Section]:
    """All that is said of a result, in order.

    Args:
        result: of an identification.
        signals: `seen` of it.
        trail: of a recursive one.
        known_as: what the robot's own inertia is.
    """
    sections = [
        parameters(result, known_as),
        masses(result, known_as),
        variance_shares(result),
        fits(result, signals),
        convergence(result.convergence),
        recursion(trail),
        conditioning(result),
        sensitivities(result),
        identifiability(result),
        excitation(result),
        provenance(result),
        references(result),
    ]
    return [section for section in sections if section is not None]
