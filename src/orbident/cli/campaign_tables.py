"""A campaign as tables for people."""

from collections import Counter
from pathlib import Path

from rich.table import Table

from orbident.campaigns.campaign_table import read_rows
from orbident.campaigns.folder import Campaign
from orbident.estimation.checks import LEVELS


def levels(campaign: Campaign, folder: Path) -> Table:
    """How many results of each robot and method may be trusted."""
    rows = read_rows(campaign, folder, ("robot", "method", "level"))
    keys = zip(*(rows[name].to_pylist() for name in ("robot", "method")), strict=True)
    seen = Counter(zip(keys, rows["level"].to_pylist(), strict=True))
    table = Table("robot", "method", box=None)
    for level in LEVELS:
        table.add_column(level, justify="right")
    for robot, method in dict.fromkeys(key for key, _ in seen):
        counts = (seen[(robot, method), level] for level in LEVELS)
        table.add_row(robot, method, *map(str, counts))
    return table
