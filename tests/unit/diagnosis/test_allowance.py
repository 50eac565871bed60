"""A search for causes ends, in the middle of a trial too, and says so."""

from typing import NoReturn

import pytest
from cause_problems import fitted, problem_with

from orbident.diagnosis import causes as module
from orbident.diagnosis.causes import SEARCH_ON, causes
from orbident.diagnosis.rings import Ring
from orbident.diagnosis.trial import trial
from orbident.estimation.allowance import Allowance, GivenUpError, limited_to
from orbident.estimation.estimate import Solved
from orbident.estimation.momentum_problem import MomentumProblem


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    """With a gyro that shows too much about one axis."""
    return problem_with({"gyro.x": lambda x: 1.05 * x})


def too_long(*_: object) -> NoReturn:
    raise GivenUpError


def test_a_trial_is_given_up(problem: MomentumProblem):
    with limited_to(Allowance(1.0)), pytest.raises(GivenUpError):
        trial("", problem)
    assert trial("", problem).estimate is not None


@pytest.mark.parametrize("stage", ["jumps", "smoothed"])
def test_an_answer_says_that_the_search_ended(
    problem: MomentumProblem, stage: str, monkeypatch: pytest.MonkeyPatch
):
    """Before all trials, and among them."""
    monkeypatch.setattr(module, stage, too_long)
    monkeypatch.setattr(module, "event", too_long)
    shown = fitted(problem)
    (found,) = causes(Solved(problem, [], shown, shown))
    assert found.remedy.endswith(SEARCH_ON)
    assert found.reason.startswith("no cause that was tried")


@pytest.mark.parametrize("stage", ["jumps", "smoothed"])
def test_what_rings_is_named_when_the_search_is_over(
    problem: MomentumProblem, stage: str, monkeypatch: pytest.MonkeyPatch
):
    """It needs no fit."""
    monkeypatch.setattr(module, stage, too_long)
    monkeypatch.setattr(module, "ring_of", lambda *_: Ring(3.7, alike=True))
    shown = fitted(problem)
    (found,) = causes(Solved(problem, [], shown, shown))
    assert "rings at 3.7 Hz" in found.reason
