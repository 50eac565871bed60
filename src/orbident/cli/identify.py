"""`orbident identify ROBOT REC... -o RUN`."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.choices import CauseSearch, DisturbanceGroup, Method
from orbident.cli.options import (
    End,
    Force,
    MomentumKnown,
    RobotName,
    Start,
    as_typed,
    cut_to_times,
)
from orbident.cli.output import Output, progress, unless_missing
from orbident.files.text import name_of, sha256


def identify(
    output: Output,
    robot: RobotName,
    recordings: Annotated[
        list[Path],
        typer.Argument(
            metavar="REC...",
            help="A recording: CSV or Parquet. Several of one robot are identified as "
            "one; each has its own momentum, biases and clocks.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="RUN",
            help="The folder to write: result, robot, signals and report.html.",
        ),
    ] = None,
    method: Annotated[
        Method,
        typer.Option(
            help="maximum-likelihood: fits all sensors at once. structured: solves "
            "Eqs. 24 and 31 for the base parameters. least-squares: the paper's. "
            "recursive: a filter, sample by sample, that watches for changes (RUN has "
            "history.csv)."
        ),
    ] = "maximum-likelihood",
    initial_momentum: MomentumKnown = "unknown",
    disturbance: Annotated[
        list[DisturbanceGroup] | None,
        typer.Option(
            metavar="GROUP",
            help="Something that is known to act from outside, such as 'pull' on a "
            "table that is not level; may be given several times. All others are "
            "tested for. The how-to 'What acts from outside' explains the names.",
        ),
    ] = None,
    start: Start = None,
    end: End = None,
    burn: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="A recording of a thruster burn with locked joints: its mass (Eq. 40) "
            "is compared with the others.",
        ),
    ] = None,
    everything: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Print formulas, pi, phi, the mass by every route and the residuals "
            "of every sensor too.",
        ),
    ] = False,
    causes: Annotated[
        CauseSearch,
        typer.Option(
            help="How long to look for the cause of a refusal: some seconds (quick), "
            "until all is tried, or not at all."
        ),
    ] = "quick",
    force: Force = False,
) -> None:
    """Identify a robot's inertial parameters from recordings.

    Prints the total mass and the parameters that free floating can identify, with
    standard deviations, beside the nominal (CAD) values.
    """
    from orbident.cli.identify_tables import summary, warnings_of
    from orbident.recordings.tables import open_recording
    from orbident.robot.may_act import may_act

    if out is not None:
        from orbident.identified.run_folder import check_absent

        check_absent(out, force)
    described = oi.load_robot(robot)
    if disturbance:
        asked = {**(described.disturbances or {}), **(may_act(disturbance) or {})}
        described = replace(described, disturbances=asked)
    with progress("reading"):
        tables = [cut_to_times(open_recording(each), start, end) for each in recordings]
        pushed = None if burn is None else oi.read_recording(burn)
    with progress("identifying") as done:
        result = oi.identify(
            described, tables, method, initial_momentum, pushed, progress=done
        )
    if result.status == "rejected":
        with progress("looking for the cause"):
            result = result.with_causes(causes)
    used = {"from": start, "to": end}
    files = [
        {"file": name_of(recording), "sha256": sha256(recording)}
        | {key: value for key, value in used.items() if value is not None}
        for recording in recordings
    ]
    origin = files[0] if len(files) == 1 else {"recordings": files}
    result = replace(result, input=origin | as_typed())
    shown = tables[0] if isinstance(tables[0], oi.Recording) else tables[0].digest
    unmade = [] if out is None else keep(result, described, shown, out, force)
    output.warn([*unmade, *warnings_of(result, everything)])
    output.say(*summary(result, out, everything))
    output.write_json(result.to_json())
    if result.status == "rejected":
        raise typer.Exit(1)


def keep(result: Any, robot: Any, table: Any, out: Path, force: bool) -> list[str]:
    """Write a RUN with its report; a warning where that could not be made."""
    from orbident.identified.run_folder import REPORT, saving
    from orbident.report.replay_figure import write_replay
    from orbident.report.write import write_report

    unmade = []
    with saving(result, out, force) as new:
        write_replay(robot, table, new)
        with unless_missing(unmade, f"{out / REPORT} is not written"):
            write_report(result, new)
    return unmade
