"""`orbident study spatial|planar|table|control`."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import orbident as oi
from orbident.choices import StudyNoise
from orbident.cli.options import Force, Workers, as_typed
from orbident.cli.output import Output, progress, unless_missing
from orbident.files.replacing import check_free, replacing, replacing_files
from orbident.files.text import sha256

TRAJECTORY = "trajectory.yaml"
RUN = "run"
CUT_OFFS = "cut_offs"
REPORT = "report.html"
FIGURES = tuple(f"fig{number:02}" for number in range(6, 14))


Study = Literal["spatial", "planar", "table", "control"]
"""Which part of the paper; or what its result is good for."""

StudyMethod = Literal["paper", "maximum-likelihood", "structured", "least-squares"]
"""How parameters are estimated from noisy recordings."""

RECORDINGS = {
    "spatial": ("recording",),
    "planar": ("identification", "burn", "validation"),
    "table": ("recording",),
    "control": ("recording",),
}


def study(
    output: Output,
    name: Annotated[
        Study,
        typer.Argument(
            metavar="spatial|planar|table|control",
            help="spatial: Section 4. planar: Section 5, on an ideal table. table: "
            "Section 5 on a table that is tilted and uneven and has an air film. "
            "control: tracking with what Section 4 identifies.",
        ),
    ],
    noise: Annotated[
        StudyNoise,
        typer.Option(
            help="none: ideal sensors. paper: the noise of the paper's sensors. "
            "'table' always has the noise of motion capture."
        ),
    ] = "none",
    seeds: Annotated[
        int,
        typer.Option(
            help="Number of runs with noise, for RMS and worst errors.", min=1
        ),
    ] = 1,
    seed: Annotated[int, typer.Option(help="Random seed of the first run.", min=0)] = 0,
    workers: Workers = None,
    method: Annotated[
        StudyMethod,
        typer.Option(
            help="paper, or a method of 'identify', which gets the recordings "
            "unfiltered. planar always runs the paper's and one other, by default "
            "maximum-likelihood."
        ),
    ] = "paper",
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="DIR",
            help="Keep trajectory, recordings, RUN, the figures' data, and pictures of "
            "how the filters' cut-offs were chosen.",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Repeat a study of the paper beside the paper's own numbers."""
    from orbident.campaigns.executors import local
    from orbident.campaigns.seeds import SeedRuns
    from orbident.threads import at_hand

    if out is not None:
        from orbident.identified.run_folder import check_absent

        check_absent(out / RUN, force)
        _check_free(out, name, force)
    noisy = noise == "paper" or name == "table"
    if not noisy and seeds > 1:
        output.warn([f"--seeds {seeds}: without noise all are alike, so 1 is run"])
        seeds = 1
    run = _runner(name, method)
    executors = local(min(workers or at_hand(), seeds))
    with progress(f"study {name}") as show:
        done = run(noise, SeedRuns(seeds, seed, show, executors))
    if out is not None:
        output.warn(_keep(done, name, out, force, seed if noisy else None))
    if done.rejected:
        output.warn([f"{done.rejected} of {done.seeds} runs were refused"])
    if not done.trusted:
        output.warn(done.result.warnings)
    output.say(*_lines(done))
    if out is not None:
        output.say(f"written: {out}")
    output.write_json(done.to_json())
    if not done.trusted:
        raise typer.Exit(1)


def _runner(name: Study, method: StudyMethod) -> Callable[..., Any]:
    if name == "spatial":
        from orbident.studies.spatial import run_spatial

        return partial(run_spatial, method=method)
    if name == "table":
        from orbident.studies.run_table import run_table

        return lambda _, runs: run_table(runs)
    if name == "control":
        from orbident.studies.control import run_control

        return run_control
    from orbident.studies.run_planar import run_planar

    return run_planar if method == "paper" else partial(run_planar, method=method)


def _lines(done: Any) -> list[Any]:
    from orbident.studies.study_account import account_of

    account = account_of(done)
    tables = (part for table in account.tables for part in ("", table))
    below = [account.below] if account.below else []
    return [*account.words, *tables, "", *below, f"{done.elapsed_s:.1f} s"]


def _files(name: Study, cut_offs: Iterable[str] = ()) -> tuple[str, ...]:
    """What a study leaves beside its RUN; the report last."""
    tables = (*RECORDINGS[name], *(FIGURES if name == "planar" else ()))
    pictures = {"planar": FIGURES, "spatial": ("table4",)}.get(name, ())
    return (
        TRAJECTORY,
        *(f"{table}.csv" for table in tables),
        *(f"{picture}.{kind}" for picture in pictures for kind in ("png", "svg")),
        *(f"{CUT_OFFS}/{signal}.png" for signal in cut_offs),
        REPORT,
    )


def _check_free(out: Path, name: Study, force: bool) -> None:
    for file in _files(name) if out.exists() else ():
        check_free(out / file, force)


def _keep(
    done: Any, name: Study, out: Path, force: bool, seed: int | None
) -> list[str]:
    """Write the study's files and its RUN; a warning where pictures were not made."""
    unmade = []
    cut_offs = {} if name == "control" else done.cut_offs
    with replacing_files(out, _files(name, cut_offs)) as new:
        # Another process may have been faster.
        _check_free(out, name, force)
        recording = _write_data(done, name, new)
        known = {"file": recording.name, "sha256": sha256(recording), "seed": seed}
        result = replace(done.result, input=known | as_typed())
        with unless_missing(unmade, f"{out} is kept without its report and pictures"):
            _draw(done, result, f"Study: {name}", cut_offs, new)
        oi.save_result(result, out / RUN, force)
    return unmade


def _write_data(done: Any, name: Study, folder: Path) -> Path:
    """Write what was flown and the figures' data; the path of what was identified."""
    oi.save_trajectory(done.trajectory, folder / TRAJECTORY)
    if name != "planar":
        recordings = (done.recording,)
    else:
        from orbident.studies.run_planar import write_figures

        recordings = done.recordings
        write_figures(done.figures, folder)
    files = [folder / f"{file}.csv" for file in RECORDINGS[name]]
    for file, recording in zip(files, recordings, strict=True):
        oi.write_recording(recording, file)
    return files[0]


def _draw(
    done: Any, result: Any, title: str, cut_offs: Mapping[str, Any], folder: Path
) -> None:
    from orbident.report.study_page import drawn_cut_off, write_study_report

    write_study_report(done, result, title, folder)
    if cut_offs:
        (folder / CUT_OFFS).mkdir(exist_ok=True)
    for signal, cut_off in cut_offs.items():
        drawing = drawn_cut_off(cut_off, signal)
        with replacing(folder / CUT_OFFS / f"{signal}.png") as path:
            drawing.savefig(path, format="png", dpi=150)
