"""`orbident report RUN`."""

import orbident as oi
from orbident.cli.options import Force, RunFolder
from orbident.cli.output import Output
from orbident.files.replacing import check_free, locked


def report(output: Output, run: RunFolder, force: Force = False) -> None:
    """Write RUN/report.html, one page that needs no network.

    It says whether to trust the result, and why.
    """
    from orbident.identified.run_folder import REPORT
    from orbident.report.page import verdict_of
    from orbident.report.write import write_report

    if run.is_dir():
        check_free(run / REPORT, force)
    result = oi.load_result(run)
    with locked(run):
        path = write_report(result, run)
    output.say(f"the report of {run} says: {verdict_of(result).headline.lower()}")
    output.say(f"written: {path}")
    output.write_json({"report": str(path)})
