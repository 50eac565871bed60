"""`orbident study spatial`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import Json, Quiet
from orbident.errors import InputError

TRAJECTORY = "trajectory.yaml"
RECORDING = "recording.csv"


class Study(StrEnum):
    """Which part of the paper."""

    spatial = "spatial"


class Noise(StrEnum):
    """What sensors add."""

    none = "none"


def study(
    name: Annotated[Study, typer.Argument(metavar="spatial", help="Section 4.")],
    noise: Annotated[Noise, typer.Option(help="What sensors add.")] = Noise.none,
    out: Annotated[
        Path | None,
        typer.Option("-o", metavar="DIR", help="Keep trajectory, recording and RUN."),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite what DIR holds of it.")
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Run a study of the paper, beside the paper's own numbers."""
    from orbident.cli.output import Output, prepare_jax, progress
    from orbident.identified.run_folder import check_absent, save_result
    from orbident.recordings.tables import write_recording
    from orbident.studies.runner import run_spatial
    from orbident.trajectories.trajectory_file import save_trajectory

    output = Output(json, quiet)
    if out is not None:
        check_absent(out / "run", force)
        _check_free(out, force)
    prepare_jax()
    with progress(f"study {name}"):
        done = run_spatial()
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        save_trajectory(done.trajectory, out / TRAJECTORY)
        write_recording(done.recording, out / RECORDING)
        save_result(done.result, out / "run", force)
    output.say(*_lines(done))
    if out is not None:
        output.say(f"written: {out}")
    output.write_json(done.to_json())
    if not done.trusted:
        raise typer.Exit(1)


def _check_free(out: Path, force: bool) -> None:
    for name in (TRAJECTORY, RECORDING):
        if (out / name).exists() and not force:
            raise InputError(
                f"{out / name}: exists already; name another DIR, or use --force"
            )


def _lines(done: Any) -> list[Any]:
    from rich.table import Table

    table = Table(
        "parameter",
        "paper: true",
        "paper: error (%)",
        "true",
        "estimate",
        "error (%)",
        box=None,
    )
    for column in table.columns[1:]:
        column.justify = "right"
    for row in done.rows:
        table.add_row(
            row.name,
            "" if row.paper_true is None else f"{row.paper_true:.2f}",
            "" if row.paper_error_percent is None else f"{row.paper_error_percent:.0e}",
            f"{row.true:.2f}",
            f"{row.estimate:.2f}",
            f"{row.error_percent:.0e}",
        )
    condition = done.condition_number
    worst = max(abs(row.error_percent) for row in done.rows)
    return [
        "Table 4 without noise: 80 s, 1601 samples, Table 2's trajectory",
        "",
        table,
        "",
        f"condition numbers in the paper's basis: Y {condition['Y']:.1f}, "
        f"W {condition['W']:.2f}",
        f"worst error {worst:.1e} %, {done.elapsed_s:.1f} s: "
        + ("every parameter recovered" if done.trusted else "NOT recovered"),
    ]
