"""The report of a RUN: which sections there are, and where it goes."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from orbident.data_table import Cell, Numeric, table_of
from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import SIGNAL_UNITS
from orbident.files.replacing import write_text
from orbident.identified.prediction import WINDOW
from orbident.identified.run_folder import HISTORY, REPORT, VALIDATION
from orbident.identified.validate import SCORED
from orbident.preprocessing.origins import SMOOTHED, WORDS
from orbident.report.conditioning import conditioning, excitation, identifiability
from orbident.report.convergence_section import (
    Trail,
    convergence,
    read_trail,
    recursion,
)
from orbident.report.fit import fits
from orbident.report.page import NONE, Section, page, report_text, short, verdict_of
from orbident.report.parameter_section import (
    masses,
    parameters,
    sensitivities,
    variance_shares,
)
from orbident.report.replay_figure import replay_sections


def provenance(result: Result) -> Section:
    """Settings, input, signals, versions."""
    origins = ((name.replace("_", " "), how) for name, how in result.origins.items())
    clocks = (
        (
            sensor,
            *(f"{short(1e3 * x, 2)} ms" for x in (delay.late, delay.std)),
            "yes" if delay.believed else "no",
        )
        for sensor, delay in result.clocks.items()
    )
    left_out = (
        (column, ", ".join(f"{count} {reason}" for reason, count in reasons.items()))
        for column, reasons in result.rejected.items()
    )
    tables = [
        table_of("Settings", ("", "value"), _settings(result), in_words=True),
        table_of("How signals were obtained", ("signal", "origin"), origins, True),
        table_of("Clocks", ("sensor", "behind", "± std", "corrected"), clocks),
        table_of("Left out", ("column", "samples"), left_out, in_words=True),
    ]
    return Section(
        name="provenance",
        title="Settings and origin",
        tables=tuple(table for table in tables if table.rows),
    )


def references(result: Result) -> Section:
    """References of the methods that were used."""
    ways = {way for origin in result.origins.values() for way in origin.split("; ")}
    known = yaml.safe_load(report_text("references.yaml"))
    words = [known["first"], *known["by_method"].get(result.method, ())]
    if any(WORDS[each] in ways for each in SMOOTHED):
        words.append(known["where_smoothed"])
    return Section("references", "References", (*words, known["last"]))


def _settings(result: Result) -> Iterator[tuple[str, ...]]:
    for name in ("command", "date"):
        if name in result.input:
            yield name, result.input[name]
    yield "method", result.method
    yield "initial momentum", result.initial_momentum
    for file in result.input.get("recordings", [result.input]):
        yield "recording", str(file.get("file", NONE))
        yield "its SHA-256", str(file.get("sha256", NONE))
        for end in ("from", "to"):
            if end in file:
                yield f"used {end}", f"{file[end]:g} s"
    if result.input.get("seed") is not None:
        yield "seed of its noise", str(result.input["seed"])
    yield "samples", str(result.samples)
    yield "computing time", f"{short(result.elapsed_s)} s"
    for name, version in result.versions.items():
        yield f"{name}, version", version


def read_validation(path: Path) -> Section | None:
    """The scores that `validate` has left; None where there are none.

    Raises:
        InputError: the file is not what `validate` writes.
    """
    if not path.is_file():
        return None
    try:
        return validation(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{path}: was altered or cut off; run 'orbident validate' again, or remove "
            "it"
        ) from None


HEAD = "signal", "error, RMS", "% of signal", "by parameters", "by sensors"
"""Of the table of predicted rates and velocities."""


def validation(scores: dict) -> Section:
    """The verdict, and the errors beside what was expected of them."""
    rows = (
        (
            f"{name}, {SIGNAL_UNITS[name]}",
            Numeric(scores["rms"].get(name)),
            Numeric(None if (x := scores["nrmse"].get(name)) is None else 100 * x),
            Numeric(scores["predicted_std"].get(name)),
            Numeric(scores["noise"].get(name)),
        )
        for name in SCORED
    )
    poses = _beside_nominal(scores, "pose", f", over windows of {WINDOW:g} s")
    torques = _beside_nominal(scores, "torques")
    head = "error, % of signal", "by the robot file's numbers, %"
    tables = [table_of("Errors, and what is expected of them", HEAD, rows)]
    if poses:
        title = "Errors of poses, thrust included"
        tables = [table_of(title, ("pose", *head), poses)]
    if torques:
        title = "Errors of torques at joints"
        tables.append(table_of(title, ("torque", *head), torques))
    predicted = "Poses" if poses else "Base rates and velocities"
    by = "thrust" if poses else "the motion of joints and wheels"
    origin = "which was not used to identify"
    if scores.get("used"):
        origin = "from which the parameters were identified, so that it says little"
    words = [
        f"{predicted} of {scores['file']}, {origin}, were predicted from {by}: "
        f"{scores['verdict']}. {scores['reason'].capitalize()}."
    ]
    if scores["degrees_of_freedom"]:
        words.append(
            f"Chi-square {short(scores['chi2'])} with {scores['degrees_of_freedom']} "
            f"degrees of freedom, p = {short(scores['p_value'], 2)}."
        )
    return Section(
        name="validation", title="Validation", words=tuple(words), tables=tuple(tables)
    )


def _beside_nominal(scores: dict, key: str, more: str = "") -> list[tuple[Cell, ...]]:
    """Errors of what was predicted beside those of the nominal bodies, in percent."""
    nominal = scores.get(f"{key}_by_nominal", {})
    return [
        (f"{name}{more}", Numeric(100 * error), Numeric(100 * nominal[name]))
        for name, error in scores.get(key, {}).items()
        if error is not None
    ]


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
    """The report as HTML."""
    first, *others = sections_of(result, trail)
    shown = [] if validated is None else [validated]
    if replay and first.name == "parameters":
        # What is looked at first stands at the top, beside each other.
        replay = [replay[0]._replace(charts=(*replay[0].charts, *first.charts))]
        first = first._replace(charts=())
    return page(
        title=result.robot.name,
        subtitle=f"Identified by {METHODS.get(result.method, result.method)}",
        verdict=verdict_of(result),
        sections=[*replay, first, *shown, *others],
    )


def sections_of(
    result: Result, trail: Trail | None = None, known_as: str = "CAD"
) -> list[Section]:
    """All that is said of a result, in order.

    Nominal values are known as CAD, or as the truth in a simulation.
    """
    signals = tuple(each for each in result.signals() if each.t.size >= FEWEST)
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
