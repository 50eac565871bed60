"""What deviations are made of: a picture of the budget."""

import numpy as np

from orbident.estimation.result import Result
from orbident.report.charts import shares_across
from orbident.report.page import Chart, Section

MOST = 8
"""Sources that have a colour of their own: all others are one."""

WORDS = (
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
    names, shares = result.base.names, budget.shares[: len(result.base.names)]
    known = np.flatnonzero(np.isfinite(shares[:, 0]))
    if not known.size:
        return None
    order = np.argsort(-shares[known].mean(axis=0), kind="stable")
    parts = {budget.sources[k]: 100 * shares[known, k] for k in order[:MOST]}
    if order.size > MOST:
        parts["all others"] = 100 * shares[known][:, order[MOST:]].sum(axis=1)
    figure = shares_across(
        [names[k] for k in known],
        {name: share for name, share in parts.items() if share.max() >= 0.5},
        "share of the variance (%)",
    )
    table = budget.table()
    return Section(
        name="budget",
        title="What the deviations are made of",
        words=(budget.in_words(), WORDS),
        tables=(table._replace(title=table.title.capitalize()),),
        charts=(Chart("budget", "Shares of each variance", figure),),
    )
