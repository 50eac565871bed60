"""`orbident identify ROBOT REC -o RUN`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import (
    InitialMomentum,
    Json,
    MomentumKnown,
    Quiet,
    RecordingFile,
    RobotName,
)

NINETY_FIVE = 1.96
"""Standard deviations: the 95 % interval."""


class Method(StrEnum):
    """How parameters are estimated."""

    maximum_likelihood = "maximum-likelihood"
    structured = "structured"
    least_squares = "least-squares"
    recursive = "recursive"


def identify(
    robot: RobotName,
    recording: RecordingFile,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", metavar="RUN", help="Keep the result there, and a report of it."
        ),
    ] = None,
    method: Annotated[
        Method,
        typer.Option(
            help="maximum-likelihood: all sensors at once; structured: Eqs. 24 and 31 "
            "for the base parameters; least-squares: the paper's; recursive: sample by "
            "sample, watching for changes (RUN has history.csv)."
        ),
    ] = Method.maximum_likelihood,
    initial_momentum: MomentumKnown = InitialMomentum.unknown,
    burn: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="A thruster burn with locked joints: what it weighs (Eq. 40) is put "
            "beside the other masses.",
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite an existing RUN.")
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Identify pi, phi and the total mass from a recording."""
    from dataclasses import replace

    from orbident.cli.output import Output, progress
    from orbident.estimation.identify import identify as identified
    from orbident.files.checksum import sha256
    from orbident.files.text import name_of
    from orbident.recordings.tables import read_recording
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    if out is not None:
        from orbident.identified.run_folder import check_absent

        check_absent(out, force)
    described = load_robot(robot)
    with progress("reading"):
        table = read_recording(recording)
        pushed = None if burn is None else read_recording(burn)
    with progress("identifying") as done:
        result = identified(
            described,
            table,
            method.value,
            initial_momentum.value,
            pushed,
            progress=done,
        )
    if result.status == "rejected":
        with progress("looking for the cause"):
            result = result.with_causes()
    file = {"file": name_of(recording), "sha256": sha256(recording)}
    result = replace(result, input=file)
    unmade = [] if out is None else _keep(result, described, table, out, force)
    output.warn([*unmade, *result.warnings])
    output.say(*_summary(result, out))
    output.write_json(result.to_json())
    if result.status == "rejected":
        raise typer.Exit(1)


def _keep(result: Any, robot: Any, table: Any, out: Path, force: bool) -> list[str]:
    """Write the RUN.

    Returns:
        A warning where its report could not be made.
    """
    from orbident.extras import MissingLibraryError
    from orbident.identified.run_folder import REPORT, saving
    from orbident.report.replay_figure import write_replay
    from orbident.report.write import write_report

    unmade = []
    with saving(result, out, force) as new:
        write_replay(robot, table, new)
        try:
            write_report(result, new)
        except MissingLibraryError as refusal:
            unmade.append(f"{refusal}; {out / REPORT} is not written")
    return unmade


def _summary(result: Any, out: Path | None) -> list[str]:
    lines = [
        f"{result.robot.name}: {result.status}, {result.samples} samples, "
        f"{result.elapsed_s:.2f} s",
        _mass(result),
    ]
    lines += _masses(result)
    for title, estimates in (
        ("pi, kg m^2", result.pi),
        ("phi, m", result.phi),
        ("base parameters: M, kg; sigma, kg m; iota, kg m^2", result.base),
    ):
        lines += ["", title, f"  {'':8} {'value':>12} {'std':>8}   formula"]
        for name, formula, value, std in estimates:
            numbers = f"{_number(value, '.6g'):>12} {_number(std, '.2g'):>8}"
            lines.append(f"  {name:8} {numbers}   {formula}")
    lines += _sensors(result)
    lines += _calibration(result)
    condition = ", ".join(
        f"{name} {value:.4g}" for name, value in result.condition_number.items()
    )
    lines += ["", f"condition numbers: {condition}"]
    if out is not None:
        lines.append(f"written: {out}")
    return lines


def _mass(result: Any) -> str:
    mass = result.mass
    if mass.value != mass.value:
        return "mass not determined"
    low, high = mass.value - NINETY_FIVE * mass.std, mass.value + NINETY_FIVE * mass.std
    return (
        f"mass {mass.value:.6g} +- {mass.std:.2g} kg by {result.method} "
        f"(95 %: {low:.6g} to {high:.6g})"
    )


def _masses(result: Any) -> list[str]:
    """The mass by every route."""
    lines = [
        f"  {name:24} {value:12.6g} {std:8.2g}   {formula}".rstrip()
        for name, formula, value, std in result.mass_forms
    ]
    return ["", "mass by every route, kg", *lines] if lines else []


def _sensors(result: Any) -> list[str]:
    """How well every sensor was predicted."""
    fits = result.residual.get("sensors", {})
    if not fits:
        return []
    chi2 = result.residual["chi2_per_dof"]
    lines = [
        "",
        f"residuals, SI; chi-square per degree of freedom {chi2:.3g}",
        f"  {'':14} {'noise':>9} {'declared':>9} {'whiteness':>9} {'samples':>8}",
    ]
    for name, fit in fits.items():
        declared = "-" if fit["declared"] is None else f"{fit['declared']:.2g}"
        lines.append(
            f"  {name:14} {fit['noise']:9.2g} {declared:>9} {fit['whiteness']:9.2f} "
            f"{fit['samples']:8.0f}"
        )
    return lines


def _calibration(result: Any) -> list[str]:
    """Errors of instruments: those estimated, and what the others may do."""
    lines = [
        f"  {name:24} {fit.value:10.2g} +- {fit.std:.2g}   "
        f"tolerance {fit.tolerance:.2g}"
        for name, fit in result.calibration.items()
    ]
    lines = ["", "calibration errors, SI or relative", *lines] if lines else []
    table = result.sensitivity()
    if table is not None:
        name, unit, parameter, shift = table.worst()
        lines += [
            "",
            f"{len(table.errors)} errors of instruments are taken for zero; worst, 1 "
            f"{unit} of {name} would shift {parameter} by {shift:.2g} of its "
            "deviations (all: 'sensitivity' in the JSON; declare 'tolerances')",
        ]
    return lines


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if value == value else "-"
