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
    from orbident.cli.output import Output, check_json_place, prepare_jax, progress
    from orbident.estimation.identify import identify as identified
    from orbident.identified.run_folder import check_absent, save_result
    from orbident.recordings.tables import read_recording
    from orbident.robot.robot_file import load_robot

    check_json_place(json)
    if out is not None:
        check_absent(out, force)
    output = Output(json, quiet)
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
    output.write_json(result.to_json())
    if result.status == "rejected":
        raise typer.Exit(1)


def _summary(result: Any, out: Path | None) -> list[Any]:
    from rich.table import Table

    lines: list[Any] = [
        f"{result.robot.name}: {result.status}, {result.samples} samples, "
        f"{result.elapsed_s:.2f} s",
        f"mass {_pm(result.mass.value, result.mass.std)} kg, from "
        f"{len(result.mass_forms.names)} forms of Eq. 32",
    ]
    for title, estimates in (
        ("pi", result.pi),
        ("phi (m)", result.phi),
        ("base parameters", result.base),
    ):
        table = Table("", "value", "std", "formula", box=None, pad_edge=False)
        table.columns[3].no_wrap = True
        for name, formula, value, std in estimates:
            table.add_row(name, _number(value, ".6g"), _number(std, ".2g"), formula)
        lines += ["", title, table]
    condition = ", ".join(
        f"{name} {value:.4g}" for name, value in result.condition_number.items()
    )
    lines += ["", f"condition numbers: {condition}"]
    lines += [f"warning: {warning}" for warning in result.warnings]
    if out is not None:
        lines.append(f"written: {out}")
    return lines


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if value == value else "-"


def _pm(value: float, std: float) -> str:
    return f"{value:.6g} +- {std:.2g}" if value == value else "not determined:"
