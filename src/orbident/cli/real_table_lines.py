"""The study of a real table as tables for people."""

from typing import Any

from rich.table import Table

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
