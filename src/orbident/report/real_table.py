"""The section of the study of a real table."""

from orbident.report.numbers import short
from orbident.report.section import ReportTable, Section, TableRow
from orbident.studies.run_table import Acted, TableStudy
from orbident.studies.run_table import MethodParameter as Parameter

WAYS = {
    "paper": "The paper's method",
    "without": "Maximum likelihood, as if nothing acted",
    "with": "Maximum likelihood, with what acts",
}
"""How each way of reading is headed."""

PARAMETER = "parameter", "true", "estimate", "error (%)", "RMS (%)", "sigmas"
DISTURBANCE = "disturbance", "true", "estimate", "deviation", "sigmas"


def real_table(done: TableStudy) -> Section:
    """Table 6 by three ways of reading, and what acted."""
    paper = "accepts its first result"
    if done.refused:
        paper = f"refuses its first result: {done.refused}"
    parameters = [
        ReportTable(
            f"{words}: pi, kg m²; phi, m; M, kg",
            PARAMETER,
            tuple(_parameter(row) for row in done.methods[way]),
        )
        for way, words in WAYS.items()
    ]
    acted = tuple(_disturbance(each) for each in done.acted)
    return Section(
        name="table",
        title="A real table",
        words=(
            "Section 5 on a table that is tilted and uneven, with an air film below "
            "base and elbow, by encoders and motion capture.",
            f"Maximum likelihood refuses {done.rejected} of {done.seeds} results; the "
            f"paper's method {paper}.",
        ),
        tables=(*parameters, ReportTable("What acted", DISTURBANCE, acted)),
    )


def _parameter(row: Parameter) -> TableRow:
    percent = short(row.error_percent, 2), short(row.rms_error_percent, 2)
    numbers = short(row.true, 4), short(row.estimate, 4)
    return TableRow((row.name, *numbers, *percent, short(row.sigmas, 2)))


def _disturbance(each: Acted) -> TableRow:
    numbers = (short(x, 3) for x in (each.true, each.estimate, each.std))
    return TableRow((f"{each.name}, {each.unit}", *numbers, short(each.sigmas, 2)))
