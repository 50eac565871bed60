"""`orbident report RUN`."""

from typing import Annotated

import typer

from orbident.cli.options import Json, Quiet, RunFolder
from orbident.errors import InputError


def report(
    run: RunFolder,
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite the report that is there.")
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Write RUN/report.html: one page to look at, which needs no network."""
    from orbident.cli.output import Output
    from orbident.files.locking import locked
    from orbident.identified.run_folder import REPORT, load_result
    from orbident.report.write import write_report

    output = Output(json, quiet)
    result = load_result(run)
    if (run / REPORT).exists() and not force:
        raise InputError(f"{run / REPORT}: exists already; use --force")
    with locked(run):
        path = write_report(result, run)
    output.say(f"written: {path}")
    output.write_json({"report": str(path)})
