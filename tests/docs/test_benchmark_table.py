"""The README is short, and its table is that of the open benchmark's last run."""

import re
from collections.abc import Iterator

from pages import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
RESULTS = (ROOT / "benchmarks/open/results.md").read_text(encoding="utf-8")
METHODS = (
    "maximum-likelihood",
    "the paper's method",
    "EKF on theta",
    "plain recursive least squares",
)
"""In the order of the README's columns."""

MOST = 700
"""Words of the README, but for blocks and tables: what is read at first sight."""


def rows(text: str) -> Iterator[list[str]]:
    """The cells of every row of every table."""
    for row in re.findall(r"^\|(.*)\|$", text, re.MULTILINE):
        yield [cell.strip() for cell in row.split("|")]


def found() -> Iterator[list[str]]:
    """Of each problem error and coverage by every method, as the README has them."""
    for name, part in re.findall(r"^## (\S+)\n(.*?)(?=^## |\Z)", RESULTS, re.M | re.S):
        scores = {method: cells for method, *cells in rows(part)}
        assert all(scores[method][2] in {"0 of 3", "3 of 3"} for method in METHODS)
        yield [
            f"`{name}`",
            *(
                "no result"
                if scores[method][2] == "3 of 3"
                else ", ".join(scores[method][:2])
                for method in METHODS
            ),
        ]


def test_the_table_is_that_of_the_last_run():
    problems = [row for row in rows(README) if len(row) == 1 + len(METHODS)][2:]
    assert problems == [*found()]


def test_the_readme_is_short():
    text = re.sub(r"^```.*?^```$|<!--.*?-->", "", README, flags=re.M | re.S)
    assert len(re.sub(r"^\|.*$", "", text, flags=re.M).split()) <= MOST
