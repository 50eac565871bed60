"""`orbident campaign SPEC -o DIR`, `campaign status DIR`, `campaign rerun DIR RUN`."""

import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from orbident.cli.identify import keep
from orbident.cli.options import Workers
from orbident.cli.output import Output, progress, unless_missing, with_output
from orbident.data_table import Numeric, table_of

if TYPE_CHECKING:
    from orbident.campaigns.conduct import Done

RUN = "run"


class _RunsByDefault(TyperGroup):
    """`campaign SPEC` is `campaign run SPEC`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0] not in {*self.commands, "-h", "--help"}:
            args = [RUN, *args]
        return super().parse_args(ctx, args)


campaign = typer.Typer(
    cls=_RunsByDefault,
    rich_markup_mode=None,
    no_args_is_help=True,
    help="Make many runs, with random robots, states and noise.",
)

Folder = Annotated[
    Path, typer.Argument(metavar="DIR", help="A folder that 'campaign -o' wrote.")
]


@campaign.command(RUN, epilog="Example: orbident campaign run spec.yaml -o campaign")
@with_output
def run(
    output: Output,
    spec: Annotated[
        Path, typer.Argument(metavar="SPEC", help="A campaign file (YAML).")
    ],
    out: Annotated[
        Path,
        typer.Option(
            "-o",
            metavar="DIR",
            help="The folder that keeps everything. If it holds a campaign of the same "
            "SPEC, that is continued.",
        ),
    ],
    workers: Workers = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS|FILE|slurm",
            help="Run on a Dask cluster: a scheduler's address (tcp://host:8786, or "
            "tls://), its scheduler file, or as many Slurm jobs as --workers says.",
        ),
    ] = None,
) -> None:
    """Make the runs that are missing; the word 'run' may be left out."""
    from orbident.campaigns.conduct import conduct
    from orbident.campaigns.executors import cluster as on_cluster
    from orbident.campaigns.executors import local
    from orbident.campaigns.folder import begin
    from orbident.campaigns.spec import load_spec
    from orbident.report.campaign_page import write_campaign_report
    from orbident.studies.spatial import paper_case
    from orbident.threads import at_hand

    if cluster is None:
        executors = local(workers or at_hand())
    else:
        executors = on_cluster(cluster, workers or 1)
    begun = begin(load_spec(spec), out, lambda robot: paper_case(robot).trajectory)
    with progress("campaign") as show:
        done = conduct(begun, out, executors, _Rate(show))
    unmade = list[str]()
    with unless_missing(unmade, f"{out} is complete without it"):
        write_campaign_report(begun, out)
    output.warn([*unmade, *([_failures(out, done)] if done.failed else [])])
    _tell(output, begun, out, done)
    if done.failed == done.of:
        raise typer.Exit(1)


@campaign.command(epilog="Example: orbident campaign status campaign")
@with_output
def status(output: Output, folder: Folder) -> None:
    """Show how far a campaign is.

    This works on any machine that sees its folder.
    """
    from orbident.campaigns.conduct import campaign_progress as status_of
    from orbident.campaigns.folder import opened

    begun = opened(folder)
    _tell(output, begun, folder, status_of(begun, folder))


@campaign.command(epilog="Example: orbident campaign rerun campaign 17")
@with_output
def rerun(
    output: Output,
    folder: Folder,
    number: Annotated[
        int, typer.Argument(metavar="RUN", help="Number of the run, from 0.")
    ],
) -> None:
    """Repeat one run exactly, and keep what it makes.

    These are its recording, and a RUN for each method.
    """
    from orbident.campaigns.conduct import repeat_run as made_again
    from orbident.campaigns.folder import check_versions, opened, versions
    from orbident.cli.identify_tables import summary

    begun = opened(folder)
    check_versions(folder, versions())
    with progress(f"run {number}"):
        again = made_again(begun, folder, number)
    output.say(f"written: {again.path}")
    for method, result in again.results.items():
        run = again.path.parent / method
        robot = again.case.subject.robot
        unmade = keep(result, robot, again.recording, run, force=True)
        output.warn([*unmade, *result.warnings])
        output.say("", *summary(result, run, False))
    if again.same is False:
        output.warn([f"run {number} is not what the campaign has of it"])
    output.write_json(
        {
            "run": number,
            "recording": str(again.path),
            "draws": again.case.draws,
            "same": again.same,
            "results": {m: result.to_json() for m, result in again.results.items()},
        }
    )
    if again.same is False:
        raise typer.Exit(1)


class _Rate:
    """Runs so far, and how many a second since this command began."""

    def __init__(self, show: Any) -> None:
        self.show = show
        self.first: tuple[float, int] | None = None

    def __call__(self, done: "Done") -> None:
        now = time.monotonic()
        began, before = self.first = self.first or (now, done.runs)
        words = f"{done.runs} of {done.of} runs"
        if done.runs > before:
            words += f", {(done.runs - before) / (now - began):.3g} a second"
        if done.failed:
            words += f", {done.failed} failed"
        self.show(done.runs / done.of, words)


def _tell(output: Output, begun: Any, folder: Path, done: "Done") -> None:
    """How far a campaign is, in words and as JSON."""
    from orbident.campaigns.conduct import failed_runs

    output.say(
        f"{folder}: {done.runs} of {done.of} runs made, {done.failed} of them failed",
        *(["", _levels(begun, folder)] if done.runs else []),
    )
    output.write_json(
        {
            "folder": str(folder),
            "runs": done.of,
            "made": done.runs,
            "failed": [int(path.stem) for path in failed_runs(folder)],
            "entropy": begun.spec.entropy,
        }
    )


def _levels(begun: Any, folder: Path) -> Any:
    """How many results of each robot and method may be trusted."""
    from orbident.campaigns.folder import read_rows
    from orbident.estimation.checks import LEVELS

    rows = read_rows(begun, folder, ("robot", "method", "level"))
    columns = (rows[name].to_pylist() for name in ("robot", "method", "level"))
    seen = Counter(zip(*columns, strict=True))
    counted = (
        (*key, *(Numeric(seen[*key, level], "d") for level in LEVELS))
        for key in dict.fromkeys(key[:2] for key in seen)
    )
    return table_of("", ("robot", "method", *LEVELS), counted)


def _failures(folder: Path, done: "Done") -> str:
    from orbident.campaigns.conduct import failed_runs, reason_in

    first = next(failed_runs(folder))
    return (
        f"{done.failed} of {done.of} runs failed; the first is run {first.stem}: "
        f"{reason_in(first)}; see {first}, or 'orbident campaign rerun {folder} "
        f"{first.stem}'"
    )
