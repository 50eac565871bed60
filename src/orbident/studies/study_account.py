"""What a study found, in words and tables: for the terminal and for its report."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.data_table import Cell, DataTable, Numeric, table_of
from orbident.files.names import counted
from orbident.studies.control import ControlStudy
from orbident.studies.paper_tables import PLANAR_IDENTIFIED, PaperRow
from orbident.studies.run_planar import PlanarStudy, PredictionScores
from orbident.studies.run_table import TableStudy
from orbident.studies.spatial import SpatialStudy

Study = SpatialStudy | PlanarStudy | TableStudy | ControlStudy
"""Which part of the paper, or what its result is good for."""

UNITS = "pi, kg m²; phi, m; M, kg"

WAYS = {
    "paper": "The paper's motion and method",
    "with": "The paper's motion, maximum likelihood",
    "ours": "Our motion, maximum likelihood",
}
"""How each way to the parameters on a real table is headed."""


class StudyAccount(NamedTuple):
    """What is said of a study, under one heading."""

    name: str
    """Unique in a report."""
    title: str
    words: tuple[str, ...]
    tables: tuple[DataTable, ...]
    below: str = ""
    """What the terminal says below the tables."""


def account_of(done: Study) -> StudyAccount:
    """The paper's numbers beside ours, and how well a study's aim is met."""
    match done:
        case SpatialStudy():
            return _spatial(done)
        case PlanarStudy():
            return _planar(done)
        case TableStudy():
            return _real_table(done)
        case ControlStudy():
            return _control(done)


def _spatial(done: SpatialStudy) -> StudyAccount:
    """Table 4, without noise or with it."""
    method, runs = _method(done.method), _runs(done)
    words = f"Table 4 with Section 3.5's noise, by {method}: {runs}."
    if not done.noisy:
        worst = max(abs(row.error_percent) for row in done.rows)
        words = (
            "Table 4 without noise: 80 s, 1601 samples, Table 2's trajectory; worst "
            f"error {worst:.1e} %: "
            + ("every parameter recovered." if done.trusted else "NOT recovered.")
        )
    tables = [_beside_paper(f"Parameters: {UNITS}", done.rows)]
    if done.by_sensor:
        sets = np.array([row.name.partition("_")[0] for row in done.rows])
        rows = (
            (sensor, *(_percent(np.max(rms[sets == k])) for k in ("pi", "phi", "M")))
            for sensor, rms in done.by_sensor.items()
        )
        head = "sensor", "worst pi (%)", "worst phi (%)", "M (%)"
        title = "RMS error by the noise of one sensor alone"
        tables.append(table_of(title, head, rows))
    condition = done.condition_number
    conditions = f"Y {condition['Y']:.1f}, W {condition['W']:.2f}"
    below = f"condition numbers in the paper's basis: {conditions}"
    return StudyAccount("table4", "Table 4", (words,), tuple(tables), below)


def _planar(done: PlanarStudy) -> StudyAccount:
    """Table 6, the burn, and how well Eq. 47's run was predicted."""
    noise = "without noise"
    if done.noisy:
        noise = f"with the noise of encoders and motion capture: {_runs(done)}"
    tables = [
        _beside_paper(
            f"By {_method(name)}: {UNITS}",
            map(_with_table6, method.rows),
            "identified",
            ".4f",
        )
        for name, method in done.methods.items()
    ]
    burn, condition = done.mass, done.condition_number
    weighed = [
        replace(burn.row, name="all samples (weigh)"),
        replace(burn.slopes, name="two slopes (paper)"),
    ]
    tables.append(_beside_paper("Mass by the burn (Eq. 40), kg", weighed, "weighed"))
    return StudyAccount(
        name="table6",
        title="Table 6 and the burn",
        words=(
            f"Table 6 {noise}.",
            "A stand-in for Cepheus on its table; the paper's robot is another one, so "
            "only orders of magnitude can be compared.",
            *(
                _predicted(method.validation, name, done.noisy)
                for name, method in done.methods.items()
            ),
            f"The burn's mass is from {burn.weighing.samples} samples of "
            f"{burn.weighing.signal}; the paper's is 13.56 kg, weighed 13.55 kg.",
        ),
        tables=tuple(tables),
        below=(
            f"condition numbers in the paper's basis: Y {condition['Y']:.1f} (the "
            f"paper's, of Cepheus: {condition['Y_paper']:.0f}), W {condition['W']:.2f}"
        ),
    )


def _real_table(done: TableStudy) -> StudyAccount:
    """Mass and worst parameter of three ways, Table 6 by each, and what acted."""
    paper = "accepts its first result"
    if done.refused:
        paper = f"refuses its first result: {done.refused}"
    head = "parameter", "true", "estimate", "error (%)", "RMS (%)", "sigmas"
    tables = [
        table_of(
            f"{words}: {UNITS}",
            head,
            (
                (
                    row.name,
                    *(Numeric(x, ".4g") for x in (row.true, row.estimate)),
                    _percent(row.error_percent),
                    _percent(row.rms_error_percent),
                    Numeric(row.sigmas, ".1f"),
                )
                for row in done.methods[way]
            ),
        )
        for way, words in WAYS.items()
    ]
    masses = [done.methods[way][-1] for way in WAYS]
    worst = [
        max(done.methods[way], key=lambda row: row.rms_error_percent) for way in WAYS
    ]
    lines = (
        ("mass: RMS error (%)", *(_percent(row.rms_error_percent) for row in masses)),
        ("mass: deviation (%)", *(_percent(row.std_percent) for row in masses)),
        ("worst parameter", *(row.name for row in worst)),
        ("worst: RMS error (%)", *(_percent(row.rms_error_percent) for row in worst)),
        ("worst: deviation (%)", *(_percent(row.std_percent) for row in worst)),
    )
    summary = table_of("Mass and worst parameter", ("", *WAYS.values()), lines)
    acted = (
        (
            f"{each.name}, {each.unit}",
            *(Numeric(x) for x in (each.true, each.estimate, each.std)),
            Numeric(each.sigmas, ".1f"),
        )
        for each in done.acted
    )
    head = "disturbance", "true", "estimate", "deviation", "sigmas"
    return StudyAccount(
        name="table",
        title="A real table",
        words=(
            "Section 5 on a table that is tilted and uneven, with an air film below "
            "base and elbow and a slow torque, by encoders and motion capture: "
            f"{_runs(done)}. Our motion is designed for a table, with the same ends, "
            "limits and duration.",
            f"Maximum likelihood refuses {done.rejected} of {done.seeds} seeds; the "
            f"paper's method {paper}.",
        ),
        tables=(summary, *tables, table_of("What acted on our motion", head, acted)),
    )


def _control(done: ControlStudy) -> StudyAccount:
    """Tracking errors with either model, and by how much they differ."""
    rows = (
        (f"the {name} model", Numeric(tracked.joints), Numeric(tracked.base))
        for name, tracked in done.errors.items()
    )
    head = "torques computed from", "joints, rad RMS", "base, rad RMS"
    return StudyAccount(
        name="tracking",
        title="Tracking",
        words=(
            "Arm and base tracked in free flight, CAD off by 20 % in masses, first "
            f"moments and inertias, {counted(done.seeds, 'run')}: "
            f"at least {done.factor:.3g} times better with the identified model.",
        ),
        tables=(table_of("Tracking errors", head, rows),),
    )


def _runs(done: SpatialStudy | PlanarStudy | TableStudy) -> str:
    return f"{counted(done.seeds, 'seed')}, the first one's estimate"


def _method(name: str) -> str:
    return "the paper's method" if name == "paper" else name


def _beside_paper(
    title: str, rows: Iterable[PaperRow], paper: str = "true", form: str = ".2f"
) -> DataTable:
    """The paper's numbers and ours, without columns in which nothing stands.

    The paper's numbers are what `paper` says, in the form in which it prints them.
    """
    head = (
        *("parameter", f"paper: {paper}", "paper: error (%)", "true", "estimate"),
        *("error (%)", "RMS (%)", "worst (%)", "Cramér-Rao (%)"),
    )
    cells = (
        (
            row.name,
            *_printed(row.paper_true, form),
            *_printed(row.paper_error_percent, ".2g"),
            Numeric(row.true, ".6g", row.estimate - row.true),
            Numeric(row.estimate, ".6g", row.estimate - row.true),
            _percent(row.error_percent),
            _percent(row.rms_error_percent),
            _percent(row.worst_error_percent),
            _percent(row.cramer_rao_percent),
        )
        for row in rows
    )
    return table_of(title, head, cells).without_empty_columns()


def _percent(number: float) -> Numeric:
    return Numeric(number, ".2g")


def _printed(number: float | None, form: str) -> tuple[Cell]:
    """A number of the paper; nothing where it prints none."""
    return ("",) if number is None else (Numeric(number, form),)


def _with_table6(row: PaperRow) -> PaperRow:
    """The row with what the paper identified, but for M: the paper's is the burn's."""
    paper = None if row.name == "M" else PLANAR_IDENTIFIED[row.name]
    return replace(row, paper_true=paper)


def _predicted(scores: PredictionScores, method: str, noisy: bool) -> str:
    if scores.first is None:
        return f"Eq. 47's run was not predicted by {_method(method)}."
    words = []
    for name, what in (("gyro", "angular velocity"), ("velocity", "linear velocity")):
        first = 100 * scores.first.nrmse[name]
        over = 100 * scores.rms_nrmse[name], 100 * scores.worst_nrmse[name]
        rest = f" (RMS {over[0]:.2g} %, worst {over[1]:.2g} %)" if noisy else ""
        words.append(f"{what} {first:.2g} %{rest}")
    record = ""
    if noisy and method == "paper":
        record = ", beside the filtered record, as in the paper"
    elif noisy:
        record = ", beside the record as measured, whose noise is part of these errors"
    return (
        f"Eq. 47's run predicted by {_method(method)}: NRMSE of "
        f"{', of '.join(words)}{record}."
    )
