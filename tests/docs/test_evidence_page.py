"""What the page of evidence says that a test asserts stands in that test."""

import re

import pytest
from pages import ROOT

PAGE = (ROOT / "docs/evidence.md").read_text(encoding="utf-8")
RESULTS = (ROOT / "benchmarks/open/results.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\|.*\| (.*) \| `(tests/\S+\.py)` \|$", PAGE, re.MULTILINE)


@pytest.mark.parametrize(("asserted", "test"), ROWS, ids=[row[1] for row in ROWS])
def test_what_is_asserted_stands_in_the_test(asserted: str, test: str):
    text = (ROOT / test).read_text(encoding="utf-8")
    for code in re.findall(r"`([^`]+)`", asserted):
        assert re.search(rf"(?<![\w.]){re.escape(code)}(?![\w.])", text), code


def test_the_row_of_the_open_benchmark_is_that_of_its_last_run():
    found = re.findall(
        r"^\| maximum-likelihood \| (\S+) \| (\d+) % \|", RESULTS, re.MULTILINE
    )
    error, inside = ([float(x) for x in column] for column in zip(*found, strict=True))
    said = re.search(
        r"([\d.]+) to ([\d.]+) times the .* hold (\d+) to (\d+) %.*\| (\S+) \|$",
        next(line for line in PAGE.splitlines() if "on six problems" in line),
    )
    assert said is not None
    assert [*map(float, said.groups()[:4])] == [
        *(min(error), max(error)),
        *(min(inside), max(inside)),
    ]
    assert f", {said[5]};" in RESULTS
