"""The parameters with their intervals, beside what CAD says of them."""

import html
from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np
from jaxtyping import Float, Int

from orbident.data_table import Cell, DataTable, Interval, Numeric, TableRow, table_of
from orbident.estimation.quantities import (
    BaseSet,
    EstimatedSet,
    MassRoutes,
    most_different,
    parameter_rows,
    physical_names,
)
from orbident.estimation.result import Result
from orbident.gaussian import NINETY_FIVE
from orbident.model.core_robot import IN_FORMULAS, geared_joints
from orbident.model.formulas import physical_name
from orbident.report.charts import heat_map, interval_list, shares_across
from orbident.report.page import Chart, Section, filled, typeset

TITLES = {
    "base": "Base parameters: what free floating can identify",
    "links": "Links: base parameters without the motors' rotors that are declared",
    "phi": "phi: what the velocity of S shows",
    "pi": "pi: what the angular momentum shows",
}

WORDS = (
    "Parameters with their 95 % intervals, and how far they are from {known_as}: in "
    "standard deviations (sigmas) and in percent. A marked row is more than 3 sigmas "
    "from {known_as}. A dash: not determined, or the percentage of a zero. Inertias "
    "are about the origins of the bodies' frames.",
)

ROUTES = (
    "Every form of Eq. 32, then every method that ran. The last column compares each "
    "form with what all forms give together, and each method with the last one, in "
    "standard deviations of the difference. Deviations of Eq. 32 count white noise of "
    "its equations only: more than 3 sigmas show that encoders or a drift add to it."
)

FAR = 3.0
"""Sigmas from CAD that are no chance: the row is marked."""

MOST = 20
"""Rows of a table: a robot with two arms has hundreds of parameters and routes."""

ROUNDING = 1e-4
"""Relative: a chart is at least so much to either side."""

SMALL = 1e-3
"""A CAD value below this part of the largest of its kind: percent say nothing."""


def parameters(result: Result, known_as: str) -> Section | None:
    """The base parameters beside CAD, then all sets; None of a refused result.

    The nominal values are known as `"CAD"`, or as `"truth"` in a simulation.
    """
    if result.status == "rejected":
        return None
    base = result.base
    shown = most_different(base, MOST)
    tables = [_table(TITLES["base"], base, known_as, shown, folded=False)]
    words = tuple(text.format(known_as=known_as) for text in WORDS)
    if geared_joints(result.robot):
        words += (f"In formulas, {IN_FORMULAS}.",)
    if len(shown) < len(base.names):
        words += (
            f"The first table has the mass and the {len(shown) - 1} parameters that "
            f"differ most from {known_as}; all are below it, folded.",
        )
        tables += [_table("All base parameters", base, known_as)]
    tables[1:1] = spring_table(result), drive_table(result)
    for name in ("links", "phi", "pi"):
        tables += [_table(TITLES[name], getattr(result, name), known_as)]
    return Section(
        name="parameters",
        title="Parameters",
        words=words,
        tables=tuple(table for table in tables if table.rows),
        charts=_chart(base, known_as),
    )


def first_table(result: Result) -> str | None:
    """Verdict, mass and the first table as HTML, for a notebook.

    None of a refused result, whose text says why.
    """
    section = parameters(result, "CAD")
    if section is None:
        return None
    words = "<br>".join(html.escape(line) for line in result.summary()[:2])
    return f"<p>{words}</p>\n{filled('table.html', table=section.tables[0])}"


def spring_table(result: Result) -> DataTable:
    """How passive joints swing where the body that carries them is held."""
    rows = (
        (
            *(name, Numeric(fit.frequency, ".6g", fit.frequency_std)),
            *(Numeric(fit.frequency_std, ".2g"), Interval(*fit[:2])),
            *(Numeric(100 * fit.damping, ".3g", 100 * fit.damping_std),),
            Numeric(100 * fit.damping_std, ".2g"),
        )
        for name, fit in result.springs.items()
    )
    head = ("passive joint", "swings at, Hz", "± std", "95 %", "damping, %", "± std")
    return table_of("How passive joints swing", head, rows)


def drive_table(result: Result) -> DataTable:
    """What torques of joints drive beside what the joints move."""
    geared = any(fit.armature for fit in result.drives.values())
    parts = ("viscous", "Coulomb", "offset", *(["N (N - 1) J"] if geared else []))
    rows = []
    for name, fit in result.drives.items():
        # The rotor is the first in a fit, and the last in the table.
        numbers = fit[2:] + fit[:2] if geared else fit[2:]
        pairs = zip(numbers[::2], numbers[1::2], strict=True)
        cells = ((Numeric(x, ".4g", std), Numeric(std, ".2g")) for x, std in pairs)
        rows.append((name, *chain.from_iterable(cells)))
    head = ("joint", *(x for part in parts for x in (part, "± std")))
    return table_of("Friction and rotors of joints, SI", head, rows)


def masses(result: Result, known_as: str) -> Section | None:
    """The mass by every route; None where there is none."""
    routes = result.mass_forms
    shown = surest_routes(routes)
    if not shown:
        return None
    M = float(result.base.nominal[0])
    names = [routes.names[k] for k in shown]
    half = NINETY_FIVE * routes.std[shown]
    rows = tuple(mass_rows(routes, shown))
    hovers = [_hover(known_as, *row.cells[:3], "kg", Numeric(M)) for row in rows]
    figure = interval_list(
        *(names, routes.values[shown], half, M, ROUNDING * M, "M (kg)", hovers)
    )
    words = [ROUTES]
    if len(shown) < len(routes.names):
        words.append(f"The surest of {len(routes.names)}.")
    words += [f"{sentence}." for sentence in routes_left_out(routes)]
    return Section(
        name="masses",
        title="The mass by every route",
        words=tuple(words),
        tables=(DataTable("Mass", ("route", "kg", "± std", "95 %", "sigmas"), rows),),
        charts=(Chart("masses", f"Mass by every route; line: {known_as}", figure),),
    )


def mass_rows(routes: MassRoutes, which: Iterable[int]) -> Iterator[TableRow]:
    """Route, mass, deviation, 95 % and sigmas; the note is the formula."""
    for k in which:
        value, std = float(routes.values[k]), float(routes.std[k])
        cells = (
            *(routes.names[k], Numeric(value, ".6g", std), Numeric(std, ".2g")),
            *(Interval(value, std), Numeric(float(routes.sigmas[k]), "+.1f")),
        )
        yield TableRow(cells, routes.formulas[k])


def routes_left_out(routes: MassRoutes) -> list[str]:
    """How many forms of Eq. 32 are not shown, if any, and why."""
    if not routes.left_out:
        return []
    return [
        f"{routes.left_out} further forms of Eq. 32 are too uncertain to be listed: "
        "their deviations are beyond a tenth of the mass"
    ]


def _table(
    title: str,
    found: EstimatedSet,
    known_as: str,
    shown: Int[np.ndarray, " rows"] | None = None,
    folded: bool = True,
) -> DataTable:
    which = range(len(found.names)) if shown is None else shown.tolist()
    far = np.abs(found.sigmas) > FAR
    rows = (
        TableRow(cells, _in_words(found, k), marked=bool(far[k]))
        for k, (cells, *_) in zip(which, parameter_rows(found, which), strict=True)
    )
    before, after = ("parameter", "estimate", "± std", "unit", "95 %"), ("sigmas", "%")
    return DataTable(title, (*before, known_as, *after), tuple(rows), folded=folded)


def _in_words(found: EstimatedSet, k: int) -> str:
    """The formula of a parameter; before it, of a base parameter, what that is."""
    name, formula = found.names[k], found.formulas[k]
    if not isinstance(found, BaseSet):
        return formula
    return f"{physical_name(name, formula)} = {formula}"


def _chart(base: EstimatedSet, known_as: str) -> tuple[Chart, ...]:
    nominal = base.nominal
    kinds = np.array([name.split("_")[0] for name in base.names])
    size = [np.abs(nominal[kinds == kind]).max(initial=0.0) for kind in kinds]
    # Elsewhere percent say little.
    said = np.isfinite(base.values) & (np.abs(nominal) > SMALL * np.array(size))
    if not said.any():
        return ()
    shown = np.flatnonzero(said).tolist()
    what, hovers = physical_names(base), list[str]()
    for k, row in zip(shown, parameter_rows(base, shown), strict=True):
        _, value, std, unit, _, cad, *_ = row.cells
        name = physical_name(base.names[k], base.formulas[k])
        hovers.append(_hover(known_as, name, value, std, unit, cad))
    figure = interval_list(
        [what[k] for k in shown],
        100 * (base.values[shown] / nominal[shown] - 1),
        100 * NINETY_FIVE * base.std[shown] / np.abs(nominal[shown]),
        0.0,
        100 * ROUNDING,
        f"difference from {known_as} (%)",
        hovers,
    )
    return (Chart("base", f"Base parameters beside {known_as}", figure),)


def _hover(known_as: str, *cells: Cell) -> str:
    """Name, estimate, deviation, unit and nominal value with the table's digits."""
    name, value, std, unit, nominal = map(typeset, cells)
    return f"{name}\n{value} ± {std} {unit}\n{known_as}: {nominal} {unit}"


def surest_routes(routes: MassRoutes) -> list[int]:
    """Which routes to the mass to show: every method's, and the surest of Eq. 32."""
    sure = np.sort(routes.std)[:MOST]
    return [
        k
        for k, name in enumerate(routes.names)
        if routes.std[k] <= sure[-1] or name.startswith("M by")
    ]


READABLE = 20
"""Rows and columns of which the numbers can be read."""

STRONG = 100.0
"""Deviations: a colour is full there, or at the largest shift if that is larger."""


def sensitivities(result: Result) -> Section | None:
    """How calibration errors that are taken for zero would shift the parameters.

    None where every error has a tolerance, or where shifts are not known: of a refused
    result, or of exact data.
    """
    table = result.sensitivity()
    if table is None or not np.isfinite(table.shifts).any():
        return None
    size = np.nan_to_num(np.abs(table.shifts))
    parameters, errors = _largest(size.max(axis=1)), _largest(size.max(axis=0))
    what = dict(zip(result.base.names, physical_names(result.base), strict=True))
    symbols = [table.parameters[k] for k in parameters]
    names = [what.get(symbol, symbol) for symbol in symbols]
    causes = [error_in_words(table.errors[k], table.units[k]) for k in errors]
    shifts = table.shifts[np.ix_(parameters, errors)].T
    # By the logarithm, shifts of 1 and of 100 deviations have colours that differ.
    colour = np.sign(shifts) * np.log10(1 + np.abs(shifts))
    full = max(np.log10(1 + STRONG), float(np.nanmax(np.abs(colour))))
    words = (
        "The instruments below are taken as exact: the robot file has no tolerance for "
        "them. A cell shows by how many of its own standard deviations a parameter "
        "would be off if the error were as large as its row says, all others being "
        "zero; red is upwards, blue downwards. An error with a tolerance is estimated "
        "with the parameters, or counted in their deviations.",
    )
    if shifts.size < size.size:
        words += (
            f"The {len(causes)} of {len(table.errors)} errors that shift most, and the "
            f"{len(names)} of {len(table.parameters)} parameters that are shifted "
            "most; result.json has all.",
        )
    chart = Chart(
        "sensitivity",
        "Shift of each parameter, in its own standard deviations",
        heat_map(
            *(causes, names, colour, full),
            height=26 * len(causes) + 90,
            text=[[_cell(shift) for shift in row] for row in shifts],
            texttemplate="%{text}",
            textfont={"size": 10},
            showscale=False,
            xgap=1,
            ygap=1,
            hovertemplate="%{y} would shift %{x} by %{text}<extra></extra>",
        ),
        wide=True,
    )
    return Section("sensitivity", "Errors of instruments", words, charts=(chart,))


def error_in_words(error: str, unit: str) -> str:
    """A calibration error for people: `1 mrad: zero of elbow`."""
    kind, _, rest = error.partition(".")
    if kind in {"joint", "wheel"}:
        name, _, what = rest.rpartition(".")
        return f"1 {unit}: {what} of {name}"
    return f"1 {unit}: {error.replace('.', ' ').replace('_', ' ')}"


def _largest(size: Float[np.ndarray, " n"]) -> list[int]:
    """The `READABLE` largest, in their order."""
    return sorted(np.argsort(-size, kind="stable")[:READABLE].tolist())


def _cell(shift: float) -> str:
    """Its size, short enough for a cell; the colour has its sign."""
    if not np.isfinite(shift):
        return ""
    size = abs(shift)
    return f"{size:.1f}" if size < 9.95 else f"{size:.0f}" if size < 9999.5 else "≫"


COLOURED = 8
"""Sources that have a colour of their own: all others are one."""

OF_SHARES = (
    "What the variance of each base parameter is made of: noise of sensors, drifts of "
    "biases, and whatever else is unknown beside the parameters. A source that were r "
    "times smaller would leave at most 1 - f (1 - 1/r²) of a variance of which it has "
    "the share f. The table has phi and pi too, and how many times as wide each "
    "deviation is as if a family of unknowns were known."
)


def variance_shares(result: Result) -> Section | None:
    """What the variances are made of; None where that is not known."""
    budget = result.budget()
    if budget is None:
        return None
    names = physical_names(result.base)
    shares = budget.shares[: len(names)]
    known = np.flatnonzero(np.isfinite(shares[:, 0]))
    if not known.size:
        return None
    order = np.argsort(-shares[known].mean(axis=0), kind="stable")
    parts = {budget.sources[k]: 100 * shares[known, k] for k in order[:COLOURED]}
    if order.size > COLOURED:
        parts["all others"] = 100 * shares[known][:, order[COLOURED:]].sum(axis=1)
    figure = shares_across(
        [names[k] for k in known],
        {name: share for name, share in parts.items() if share.max() >= 0.5},
        "share of the variance (%)",
    )
    table = budget.table()
    return Section(
        name="budget",
        title="What the deviations are made of",
        words=(budget.in_words(), OF_SHARES),
        tables=(table._replace(title=table.title.capitalize()),),
        charts=(Chart("budget", "Shares of each variance", figure),),
    )
