"""The studies' results as tables for people.

The control study as a table for people.

The study of a real table as tables for people.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from rich.table import Table

FILTERED = "compared with the filtered record, as in the paper"
MEASURED = "compared with the record as measured, whose noise is part of these errors"


def spatial_lines(done: Any) -> list[Any]:
    """Table 4, without noise or with it."""
    condition = done.condition_number
    worst = max(abs(row.error_percent) for row in done.rows)
    conditions = (
        f"condition numbers in the paper's basis: Y {condition['Y']:.1f}, "
        f"W {condition['W']:.2f}"
    )
    if not done.noisy:
        return [
            "Table 4 without noise: 80 s, 1601 samples, Table 2's trajectory",
            "",
            _exact_table(done.rows),
            "",
            conditions,
            f"worst error {worst:.1e} %, {done.elapsed_s:.1f} s: "
            + ("every parameter recovered" if done.trusted else "NOT recovered"),
        ]
    method = "the paper's method" if done.method == "paper" else done.method
    sensors = ["RMS error by the noise of one sensor alone", "", _sensor_table(done)]
    return [
        f"Table 4 with Section 3.5's noise, by {method}: {_runs(done)}",
        "",
        _noisy_table(done.rows),
        "",
        *([*sensors, ""] if done.by_sensor else []),
        conditions,
        f"{done.elapsed_s:.1f} s",
    ]


def planar_lines(done: Any) -> list[Any]:
    """Table 6, the burn, and how well Eq. 47's run was predicted."""
    noise = (
        f"with the noise of encoders and motion capture: {_runs(done)}"
        if done.noisy
        else "without noise"
    )
    lines: list[Any] = [f"Table 6 {noise}"]
    for name, method in done.methods.items():
        words = "the paper's method (M by Eq. 32)" if name == "paper" else name
        lines += ["", f"by {words}", "", _identified_table(method.rows)]
        lines += ["", _validation_line(method.validation, done.noisy)]
        if done.noisy:
            lines.append(FILTERED if name == "paper" else MEASURED)
    weighing, condition = done.mass.weighing, done.condition_number
    return [
        *lines,
        "",
        f"mass by the burn (Eq. 40), from {weighing.samples} samples of "
        f"{weighing.signal}; the paper's 13.56 kg, weighed 13.55 kg",
        "",
        _mass_table(done),
        "",
        f"condition numbers in the paper's basis: Y {condition['Y']:.1f} (the paper's, "
        f"of Cepheus: {condition['Y_paper']:.0f}), W {condition['W']:.2f}",
        f"{done.elapsed_s:.1f} s",
    ]


def _runs(done: Any) -> str:
    return (
        f"{done.seeds} seed{'' if done.seeds == 1 else 's'}, the first one's estimate"
    )


def _table(*names: str) -> Table:
    table = Table(*names, box=None)
    for column in table.columns[1:]:
        column.justify = "right"
    return table


def _exact_table(rows: Iterable[Any]) -> Table:
    names = ("paper: true", "paper: error (%)", "true", "estimate", "error (%)")
    table = _table("parameter", *names)
    for row in rows:
        table.add_row(
            row.name,
            "" if row.paper_true is None else f"{row.paper_true:.2f}",
            "" if row.paper_error_percent is None else f"{row.paper_error_percent:.0e}",
            f"{row.true:.2f}",
            f"{row.estimate:.2f}",
            f"{row.error_percent:.0e}",
        )
    return table


def _noisy_table(rows: Iterable[Any]) -> Table:
    paper, own = ("paper: true", "paper: error (%)"), ("estimate", "error (%)")
    over = "RMS error (%)", "worst (%)", "Cramér-Rao (%)"
    table = _table("parameter", *paper, *own, *over)
    for row in rows:
        table.add_row(
            row.name,
            "" if row.paper_true is None else f"{row.paper_true:.2f}",
            _percent(row.paper_error_percent),
            f"{row.estimate:.2f}",
            *_errors(row),
            _percent(row.cramer_rao_percent),
        )
    return table


def _sensor_table(done: Any) -> Table:
    table = _table("sensor", "worst pi (%)", "worst phi (%)", "M (%)")
    sets = np.array([row.name.partition("_")[0] for row in done.rows])
    for sensor, rms in done.by_sensor.items():
        worst = (np.max(rms[sets == name]) for name in ("pi", "phi", "M"))
        table.add_row(sensor, *map(_percent, worst))
    return table


def _identified_table(rows: Iterable[Any]) -> Table:
    from orbident.studies.paper_tables import PLANAR_IDENTIFIED

    names = ("paper: identified", "true", "estimate", "error (%)")
    table = _table("parameter", *names, "RMS error (%)", "worst (%)")
    for row in rows:
        paper = PLANAR_IDENTIFIED[row.name]
        table.add_row(
            row.name,
            f"{paper:.4f}" if row.name != "M" else "",
            f"{row.true:.6g}",
            _number(row.estimate, ".6g"),
            *_errors(row),
        )
    return table


def _mass_table(done: Any) -> Table:
    names = ("true (kg)", "estimate (kg)", "error (%)", "RMS error (%)", "worst (%)")
    table = _table("from", *names)
    for words, row in (
        ("all samples (weigh)", done.mass.row),
        ("two slopes (paper)", done.mass.slopes),
    ):
        numbers = f"{row.true:.2f}", _number(row.estimate, ".4f")
        table.add_row(words, *numbers, *_errors(row))
    return table


def _validation_line(validation: Any, noisy: bool) -> str:
    if validation.first is None:
        return "Eq. 47's run: not predicted"
    words = []
    for name, what in (("gyro", "angular velocity"), ("velocity", "linear velocity")):
        first = 100 * validation.first.nrmse[name]
        over = 100 * validation.rms_nrmse[name], 100 * validation.worst_nrmse[name]
        rest = f" (RMS {over[0]:.2g} %, worst {over[1]:.2g} %)" if noisy else ""
        words.append(f"{what} {first:.2g} %{rest}")
    return f"Eq. 47's run predicted: NRMSE of {', of '.join(words)}"


def _errors(row: Any) -> tuple[str, str, str]:
    return (
        _percent(row.error_percent),
        _percent(row.rms_error_percent),
        _percent(row.worst_error_percent),
    )


def _percent(number: float | None) -> str:
    return "" if number is None or number != number else f"{number:.2g}"


def _number(number: float, form: str) -> str:
    return f"{number:{form}}" if number == number else "-"


def control_lines(done: Any) -> list[Any]:
    """Tracking errors with either model, and by how much they differ."""
    table = Table("torques computed from", box=None)
    for name in ("joints, rad RMS", "base, rad RMS"):
        table.add_column(name, justify="right")
    for name, tracked in done.errors.items():
        cells = (f"{tracked.joints:.3g}", f"{tracked.base:.3g}")
        table.add_row(f"the {name} model", *cells)
    runs = "1 run" if done.seeds == 1 else f"{done.seeds} seeds"
    return [
        "arm and base tracked in free flight, CAD off by 20 % in masses, first moments "
        f"and inertias: {runs}",
        "",
        table,
        "",
        f"at least {done.factor:.3g} times better with the identified model, "
        f"{done.elapsed_s:.1f} s",
    ]


WORDS = {
    "paper": "the paper's",
    "without": "likelihood without",
    "with": "likelihood with",
}
"""The heading of each way of reading a recording, with what acts or without it."""


def real_table_lines(done: Any) -> list[Any]:
    """Table 6 by three ways of reading, and what acted."""
    runs = "1 seed" if done.seeds == 1 else f"{done.seeds} seeds, the first one's below"
    return [
        "Section 5 on a table that is tilted and uneven, with an air film, by motion "
        f"capture: {runs}",
        "",
        _parameters(done),
        "",
        "what acted, by maximum likelihood",
        "",
        _acted(done.acted),
        "",
        _verdicts(done),
        f"{done.elapsed_s:.1f} s",
    ]


def _parameters(done: Any) -> Table:
    table = Table("parameter", "true", box=None)
    for words in WORDS.values():
        table.add_column(f"{words} (%)", justify="right")
        table.add_column("sigmas", justify="right")
    many = done.seeds > 1
    for rows in zip(*(done.methods[name] for name in WORDS), strict=True):
        cells = [rows[0].name, f"{rows[0].true:.6g}"]
        for row in rows:
            percent = f"{row.error_percent:.2g}"
            over = f" (RMS {row.rms_error_percent:.2g})" if many else ""
            cells += [percent + over, f"{row.sigmas:.1f}"]
        table.add_row(*cells)
    return table


def _acted(acted: Any) -> Table:
    table = Table("name", "unit", "true", "estimate", "std", "sigmas", box=None)
    for each in acted:
        numbers = (f"{x:.3g}" for x in (each.true, each.estimate, each.std))
        table.add_row(each.name, each.unit, *numbers, f"{each.sigmas:.1f}")
    return table


def _verdicts(done: Any) -> str:
    paper = "refuses its first result" if done.refused else "accepts its first result"
    return (
        f"the paper's method {paper}; maximum likelihood refuses "
        f"{done.rejected} of {done.seeds}"
    )
