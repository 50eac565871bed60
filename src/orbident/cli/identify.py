"""`orbident identify ROBOT REC -o RUN`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import Json, Quiet, RecordingFile, RobotName


class Method(StrEnum):
    """How parameters are estimated."""

    least_squares = "least-squares"


class InitialMomentum(StrEnum):
    """What is known of the momentum (Section 3.1)."""

    unknown = "unknown"
    at_rest = "at-rest"
    first_sample = "first-sample"


def identify(
    robot: RobotName,
    recording: RecordingFile,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="RUN", help="Keep the result there.")
    ] = None,
    method: Annotated[
        Method, typer.Option(help="How parameters are estimated.")
    ] = Method.least_squares,
    initial_momentum: Annotated[
        InitialMomentum,
        typer.Option(
            help="unknown: estimated too; at-rest: all was at rest before the wheels "
            "spun up; first-sample: Eq. 24, the first sample subtracted."
        ),
    ] = InitialMomentum.unknown,
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite an existing RUN.")
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Identify pi, phi and the total mass from a recording."""
    from orbident.cli.output import Output, prepare_jax, progress
    from orbident.estimation.identify import identify as identified
    from orbident.identified.run_folder import check_absent, save_result
    from orbident.recordings.tables import read_recording
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    if out is not None:
        check_absent(out, force)
    described = load_robot(robot)
    with progress("reading"):
        table = read_recording(recording)
    prepare_jax()
    with progress("identifying") as done:
        result = identified(
            described, table, method.value, initial_momentum.value, progress=done
        )
    if out is not None:
        save_result(result, out, force)
    output.say(*_summary(result, out))
    output.warn(result.warnings)
    output.write_json(result.to_json())
    if result.status == "rejected":
        raise typer.Exit(1)


def _summary(result: Any, out: Path | None) -> list[str]:
    lines = [
        f"{result.robot.name}: {result.status}, {result.samples} samples, "
        f"{result.elapsed_s:.2f} s",
        _mass(result),
    ]
    for title, estimates in (
        ("pi, kg m^2", result.pi),
        ("phi, m", result.phi),
        ("base parameters: M, kg; sigma, kg m; iota, kg m^2", result.base),
    ):
        lines += ["", title, f"  {'':8} {'value':>12} {'std':>8}   formula"]
        for name, formula, value, std in estimates:
            numbers = f"{_number(value, '.6g'):>12} {_number(std, '.2g'):>8}"
            lines.append(f"  {name:8} {numbers}   {formula}")
    condition = ", ".join(
        f"{name} {value:.4g}" for name, value in result.condition_number.items()
    )
    lines += ["", f"condition numbers: {condition}"]
    if out is not None:
        lines.append(f"written: {out}")
    return lines


def _mass(result: Any) -> str:
    mass, forms = result.mass, len(result.mass_forms.names)
    if mass.value != mass.value:
        return "mass not determined"
    source = f"{forms} form{'' if forms == 1 else 's'} of Eq. 32"
    return f"mass {mass.value:.6g} +- {mass.std:.2g} kg, from {source}"


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if value == value else "-"
