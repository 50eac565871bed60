"""The report of a campaign: how good each method's estimates and intervals are."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from shlex import quote

import numpy as np
import pyarrow as pa
from jaxtyping import Float
from scipy import stats

from orbident.campaigns.case import Subject
from orbident.campaigns.conduct import failed_runs, reason_in
from orbident.campaigns.folder import REPORT, Campaign, read_rows
from orbident.campaigns.statistics import (
    Dependence,
    MethodStatistics,
    Parameter,
    method_statistics,
)
from orbident.data_table import Cell, DataTable, Numeric, table_of
from orbident.errors import InputError
from orbident.estimation.checks import Check, Level, worst
from orbident.excitation.bound import bound_of
from orbident.files.replacing import write_text
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.report.charts import (
    LIMIT,
    MEASURED,
    PREDICTED,
    Figure,
    Panel,
    bars,
    line,
    points,
    stacked,
)
from orbident.report.page import Chart, Section, Verdict, page, short, signed

REACH = 4.0
"""Deviations that a histogram shows; what is beyond counts in its ends."""

BARS, POINTS = 32, 400
"""Bars of a histogram, and points of a normal plot or a scatter: more would not be
seen."""


def histogram(z: Float[np.ndarray, " n"]) -> Figure:
    """Errors over deviations, beside the normal density."""
    edges = np.linspace(-REACH, REACH, BARS + 1)
    count, _ = np.histogram(np.clip(z, -REACH, REACH), edges)
    width = edges[1] - edges[0]
    middle = (edges[1:] + edges[:-1]) / 2
    shares = bars(middle, count / (z.size * width), MEASURED)
    x = np.linspace(-REACH, REACH, 100)
    normal = line(x, stats.norm.pdf(x), PREDICTED)
    return stacked([Panel("density", [shares, normal])], "error / deviation", nticks=9)


def normal_plot(z: Float[np.ndarray, " n"]) -> Figure:
    """Quantiles of errors over deviations against those of the normal distribution."""
    p = (np.arange(z.size) + 0.5) / z.size
    shown = _some(z.size)
    x = stats.norm.ppf(p)[shown]
    ends = np.array([x[0], x[-1]])
    dots = points(x, np.sort(z)[shown], MEASURED)
    panel = Panel("error / deviation", [line(ends, ends, LIMIT), dots])
    return stacked([panel], "normal quantile")


def dependence(each: Dependence) -> Figure:
    """A scatter of an error over what was drawn."""
    shown = _some(each.x.size)
    words = "size of error / deviation" if each.of_size else "error / deviation"
    panel = Panel(words, [points(each.x[shown], each.y[shown], MEASURED)])
    return stacked([panel], each.draw)


def _some(n: int) -> np.ndarray:
    """Evenly chosen, the first and the last among them."""
    return np.unique(np.linspace(0, n - 1, min(n, POINTS)).round().astype(int))


WORST, STRONGEST, DRAWN = 10, 20, 4
"""Worst cases and rank correlations in a table; scatter plots."""

Bounds = dict[str, float]
"""The least deviation that an unbiased estimate can have, by parameter."""


def write_campaign_report(campaign: Campaign, folder: Path) -> Path:
    """Write `report.html` into a campaign's folder, of what is made so far.

    Raises:
        InputError: a file of the folder is damaged, or it cannot be written.
        MissingLibraryError: plotly is not installed.
    """
    path = folder / REPORT
    write_text(path, campaign_report(campaign, folder, read_rows(campaign, folder)))
    return path


def campaign_report(campaign: Campaign, folder: Path, rows: pa.Table) -> str:
    """The report as HTML."""
    found = method_statistics(rows)
    bounds = {subject.name: _bounds(subject) for subject in campaign.subjects}
    checks = tuple(_check(group) for group in found)
    made = len(set(rows["run"].to_pylist()))
    failures = list(failed_runs(folder))
    return page(
        title=f"Campaign: {folder.resolve().name}",
        subtitle=f"{made} of {campaign.spec.runs} runs made, {len(failures)} failed, "
        f"entropy {campaign.spec.entropy}",
        verdict=Verdict(worst(checks), "", checks, ()),
        sections=[
            *(
                _errors(group, bounds[group.robot], folder, k)
                for k, group in enumerate(found)
            ),
            *_refusals(found),
            *_failed(failures),
            *(each for k, group in enumerate(found) for each in _dependences(group, k)),
            *(_distributions(group, k) for k, group in enumerate(found)),
        ],
    )


def _bounds(subject: Subject) -> Bounds:
    try:
        found = bound_of(subject.robot, subject.trajectory).parameters
    except InputError:
        return {}
    names = formulas_of(subject.robot, minimal_sets(subject.robot)).base.names
    variances = np.where(found.base.determined, np.diag(found.base.covariance), np.nan)
    return dict(zip(names, map(float, np.sqrt(variances)), strict=True))


def _check(group: MethodStatistics) -> Check:
    """Whether 95 % intervals hold the truth as often as they say."""
    known = group.parameters
    name = f"coverage of {group.robot} by {group.method}"
    if not known:
        return Check(name, "do not trust", f"{name}: no result was accepted")
    # So that all of them together are outside by chance once in twenty.
    confidence = 1 - 0.05 / len(known)
    ends = {p.name: p.coverage(confidence) for p in known}
    off = [name for name, (low, high) in ends.items() if not low <= 0.95 <= high]
    level: Level = "with care" if off else "trust"
    said = f"not that of {', '.join(off)}" if off else "as 95 % intervals say"
    return Check(name, level, f"{name}: {said}")


def _title(group: MethodStatistics) -> str:
    return f"{group.robot}, {group.method.replace('-', ' ')}"


def _errors(group: MethodStatistics, bounds: Bounds, folder: Path, k: int) -> Section:
    refused = group.rows.num_rows - group.accepted.num_rows
    return Section(
        name=f"errors{k}",
        title=_title(group),
        words=(
            f"{group.rows.num_rows} results, {refused} of them refused and not counted "
            "below. Errors are estimate less truth, SI; the bound (Cramér-Rao) is that "
            "of the robot as its file describes it; z is an error over the deviation "
            "that the result states.",
        ),
        tables=(
            table_of(
                "Errors and 95 % intervals", HEAD, _rows(group.parameters, bounds)
            ),
            *_worst(group, folder),
        ),
    )


def _dependences(group: MethodStatistics, k: int) -> Iterator[Section]:
    """What errors depend on, if anything was drawn."""
    strongest = group.dependences(STRONGEST)
    if not strongest:
        return
    yield Section(
        name=f"dependences{k}",
        title=f"{_title(group)}: what errors depend on",
        words=(
            "Rank correlation (Spearman) of errors over their deviations, or of "
            "their sizes, with what was drawn. Chance is the probability that any "
            "pair is so strongly correlated although nothing depends on it.",
        ),
        tables=(
            table_of(
                "The strongest",
                ("drawn", "parameter", "rank correlation", "chance"),
                map(_correlation, strongest),
            ),
        ),
        charts=tuple(
            Chart(
                f"scatter{k}-{i}",
                f"{each.parameter} over {each.draw}",
                dependence(each),
            )
            for i, each in enumerate(strongest[:DRAWN])
        ),
    )


def _correlation(each: Dependence) -> tuple[Cell, ...]:
    name = f"size of {each.parameter}" if each.of_size else each.parameter
    return each.draw, name, Numeric(each.rho, "+.2g"), Numeric(each.chance, ".2g")


def _distributions(group: MethodStatistics, k: int) -> Section:
    return Section(
        name=f"distributions{k}",
        title=f"{_title(group)}: distributions of errors",
        words=(
            "On the left are the errors over their deviations, beside the normal "
            "density. On the right are their quantiles against those of the normal "
            "distribution: points on the line mean that the intervals are right.",
        ),
        charts=tuple(_charts(group.parameters, k)),
    )


HEAD = (
    "parameter",
    "mean error",
    "± std",
    "RMS error",
    "bound",
    "RMS / bound",
    "RMS of z",
    "truth in 95 %",
    "interval of that",
)


def _rows(known: Sequence[Parameter], bounds: Bounds) -> Iterator[tuple[Cell, ...]]:
    for each in known:
        mean, std = each.bias
        bound = bounds.get(each.name, float("nan"))
        low, high = each.coverage()
        yield (
            each.name,
            Numeric(mean, "+.2g"),
            Numeric(std, ".2g"),
            Numeric(each.rms),
            Numeric(bound),
            Numeric(each.rms / bound if bound > 0 else None),
            Numeric(float(np.sqrt(np.mean(each.z**2)))),
            f"{short(100 * each.covered / each.z.size, 3)} %",
            f"{short(100 * low, 3)} to {short(100 * high, 3)} %",
        )


def _worst(group: MethodStatistics, folder: Path) -> Iterator[DataTable]:
    found = group.worst(WORST)
    if found:
        again = f"orbident campaign rerun {quote(str(folder))}"
        yield table_of(
            "Farthest off, in their deviations",
            ("run", "parameter", "error", "to make it again"),
            ((str(k), name, signed(z), f"{again} {k}") for k, name, z in found),
            in_words=True,
        )


def _charts(known: Sequence[Parameter], k: int) -> Iterator[Chart]:
    for i, each in enumerate(known):
        name = f"{k}-{i}"
        title = f"{each.name}: error over deviation"
        yield Chart(f"histogram{name}", title, histogram(each.z), first=True)
        yield Chart(f"normal{name}", f"{each.name}: normal plot", normal_plot(each.z))


def _refusals(found: Sequence[MethodStatistics]) -> Iterator[Section]:
    rows = []
    for group in found:
        count = Counter(group.rows["refused_by"].drop_null().to_pylist())
        for check, times in count.most_common():
            share = f"{short(100 * times / group.rows.num_rows, 3)} %"
            rows.append((group.robot, group.method, check, str(times), share))
    if rows:
        head = ("robot", "method", "check", "refused", "of its results")
        table = table_of("By the first check that refuses", head, rows)
        words = "'orbident campaign rerun' looks for the likely cause of one refusal."
        yield Section("refusals", "Refusals", (words,), (table,))


def _failed(failures: Sequence[Path]) -> Iterator[Section]:
    if not failures:
        return
    reasons: dict[str, list[int]] = {}
    for path in failures:
        reasons.setdefault(reason_in(path), []).append(int(path.stem))
    rows = (
        (reason, str(len(runs)), f"failed/{runs[0]}.json")
        for reason, runs in reasons.items()
    )
    table = table_of("Why", ("reason", "runs", "the first"), rows, in_words=True)
    yield Section("failed", "Runs that failed", tables=(table,))
