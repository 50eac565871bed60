"""The README is short; its table, and that of other methods, is of the last run."""

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
"""Words of the README, with blocks and tables: what is read at first sight."""


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


def test_the_methods_beside_each_other_are_those_of_the_last_run():
    """Least and largest of all problems."""
    page = (ROOT / "docs/comparison.md").read_text(encoding="utf-8")
    scores = [row for row in rows(RESULTS) if len(row) == 7]
    said = [row for row in rows(page) if row[-1].endswith("of 18")]
    assert len(said) == 7
    for name, *cells in said:
        found = [row[1:] for row in scores if row[0] == name]
        given = [row for row in found if row[0] != "-"]
        error, inside = (
            sorted((row[k].removesuffix(" %") for row in given), key=float)
            for k in (0, 1)
        )
        assert len(found) == 6
        assert cells == [
            f"{error[0]}, {error[-1]}",
            f"{inside[0]}, {inside[-1]} %",
            f"{sum(int(row[2].partition(' ')[0]) for row in found)} of 18",
        ]


def test_the_readme_is_short():
    assert len(README.split()) <= MOST
