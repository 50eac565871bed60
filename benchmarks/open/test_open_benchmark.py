"""The open benchmark runs on one problem, and its scores mean what they say."""

import subprocess
import sys
from pathlib import Path

import pytest
from answers import Answer, read_answer, write_answer
from open_scores import score
from problem_folder import Problem

OPEN = Path(__file__).parent


@pytest.mark.slow
def test_every_method_is_on_the_page_and_the_truth_has_no_error():
    """The page of one recording of the smallest problem, and what is scored by it.

    The truth predicts, too: rounding to nine decimals, rates of 0.1 rad/s, is 1e-6 of a
    rate. One test asks both: two processes would make the recordings at once.
    """
    command = [sys.executable, str(OPEN), "paper-planar", "--recordings", "1"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    rows = [line for line in ran.splitlines() if line.startswith("| ")][1:]
    names = [row.split(" | ")[0].removeprefix("| ") for row in rows]
    assert names[0] == "maximum-likelihood"
    assert len(names) == 7
    assert "## paper-planar" in ran
    problem = Problem(OPEN / "problems/paper-planar")
    true = {name: each["value"] for name, each in problem.truth.items()}
    bound = {name: each["bound"] or 1.0 for name, each in problem.truth.items()}
    found = score(problem, [Answer(true, bound, seconds=1.0), Answer(refused="why")])
    assert found.error == 0.0
    assert found.coverage == 1.0
    assert (found.refused, found.of) == (1, 2)
    assert found.rate < 1e-6
    assert found.velocity < 1e-5
    # One bound beside the truth is an error of one bound.
    beside = {name: value + bound[name] for name, value in true.items()}
    assert score(problem, [Answer(beside, bound)]).error == pytest.approx(1.0)


def test_answers_are_files(tmp_path: Path):
    answer = Answer({"M": 3.0}, {"M": 0.1}, seconds=2.0)
    path = tmp_path / "mine/real-table/identify-0.json"
    write_answer(answer, path)
    assert read_answer(path) == answer
    assert read_answer(tmp_path / "gone.json").refused == "no answer"
