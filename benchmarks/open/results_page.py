"""The page of results."""

import datetime
import os
import pathlib
import platform
from collections.abc import Mapping, Sequence

from open_scores import Score
from problem_folder import Problem

import orbident as oi

HEAD = """\
| method | error / bound | coverage | refused | rate, % | velocity, % | CPU s |
|---|---|---|---|---|---|---|
"""
LEGEND = """\
- *error / bound*: RMS of all errors over the Cramér-Rao bound. An unbiased method that
  uses all sensors has 1.
- *coverage*: share of the true values within 1.96 of the method's own deviations; 95 %
  is right. Less is too sure, more too modest.
- *refused*: recordings for which the method gives no result. All can be identified.
- *rate*, *velocity*: error of what is predicted of a run that was not used, without
  noise, in percent of its RMS about the mean; median of the recordings.
- *CPU s*: median seconds of processor for one recording.
"""


def page(problems: Sequence[Problem], table: Mapping[str, Mapping[str, Score]]) -> str:
    """All scores as Markdown, with machine and date."""
    sections = [_section(problem, table[problem.name]) for problem in problems]
    return "\n".join(
        [
            "# The open benchmark: results",
            "",
            f"Orbident {oi.__version__}, {datetime.date.today():%Y-%m-%d}; "
            f"{_processor()}, {os.cpu_count()} processors, Python "
            f"{platform.python_version()}, {platform.system()}. Made by "
            "`python benchmarks/open`; what it means is in "
            "[docs/open-benchmark.md](../../docs/open-benchmark.md).",
            "",
            LEGEND,
            *sections,
        ]
    )


def _section(problem: Problem, scores: Mapping[str, Score]) -> str:
    rows = "".join(_row(name, score) for name, score in scores.items())
    return f"## {problem.name}\n\n{problem.description['about']}\n\n{HEAD}{rows}"


def _row(name: str, s: Score) -> str:
    cells = (
        name,
        _number(s.error),
        _number(100 * s.coverage, " %"),
        f"{s.refused} of {s.of}",
        _number(100 * s.rate),
        _number(100 * s.velocity),
        _number(s.seconds),
    )
    return f"| {' | '.join(cells)} |\n"


def _number(x: float, unit: str = "") -> str:
    if x != x:
        return "-"
    return f"{x:.0f}{unit}" if 99.5 <= abs(x) < 1e5 else f"{x:.2g}{unit}"


def _processor() -> str:
    try:
        with pathlib.Path("/proc/cpuinfo").open() as file:
            names = [line for line in file if line.startswith("model name")]
        return names[0].partition(":")[2].strip()
    except (OSError, IndexError):
        return platform.processor() or "unknown processor"
