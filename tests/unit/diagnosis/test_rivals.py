"""A cause is stated as a fact only where nothing else may explain as much."""

import numpy as np
import pytest

from orbident.diagnosis.causes import _explained
from orbident.diagnosis.likeliest import LIKELIEST, Scored, likeliest
from orbident.diagnosis.trial import NONE, Rival, Trial, best_trial
from orbident.estimation.clock_search import WORTH

BEFORE = 1000.0
"""The misfit as recorded; 500 with the cause put right."""


def words_of(rival: Rival, seen: bool = False) -> str:
    trial = Trial("the gyro is late", True, 500.0, seen=seen, rival=rival)
    return _explained(trial, BEFORE).words


@pytest.mark.parametrize(
    "rival", [NONE, Rival(500.0 - WORTH - 1, "a panel swings")], ids=["none", "less"]
)
def test_a_fact(rival):
    words = words_of(rival)
    assert words.startswith("the gyro is late: with that corrected")
    assert "perhaps" not in words


@pytest.mark.parametrize("falls", [500.0, 900.0, np.inf])
def test_either_of_two(falls):
    words = words_of(Rival(falls, "a panel swings"))
    assert words.startswith("perhaps the gyro is late")
    assert "or perhaps a panel swings" in words
    assert "find out which of them it is" in words


def test_what_samples_show_by_themselves_is_a_fact():
    assert "perhaps" not in words_of(Rival(900.0, "a panel swings"), seen=True)


def test_two_that_are_accepted_and_explain_alike_are_both_named():
    first = Trial("an axis of one wheel is tilted", True, 500.0)
    other = Trial("an axis of another one is tilted", True, 500.0 - WORTH / 2)
    best = best_trial([first, other, Trial("a panel swings", False, 480.0)], BEFORE)
    assert best is not None
    assert best.cause == first.cause
    words = _explained(best, BEFORE).words
    assert words.startswith("perhaps an axis of one wheel is tilted")
    assert "or perhaps an axis of another one is tilted" in words


def test_what_explains_more_but_not_all_may_be_the_cause_too():
    trials = [
        Trial("a joint drifts", True, 500.0),
        Trial("a joint slips", False, 100.0),
        Trial("a panel swings", False, 900.0),
    ]
    best = best_trial(trials, BEFORE)
    assert best is not None
    words = _explained(best, BEFORE).words
    assert words.startswith("perhaps a joint drifts")
    assert "or perhaps a joint slips" in words


def test_one_that_explains_a_little_less_may_be_the_cause_too():
    other = Trial("a wheel is late", True, 540.0)
    best = best_trial([other, Trial("a torque acts", True, 500.0)], BEFORE)
    assert best is not None
    words = _explained(best, BEFORE).words
    assert words.startswith("perhaps a torque acts")
    assert "or perhaps a wheel is late" in words


@pytest.mark.parametrize(("accepted", "misfit"), [(True, 600.0), (False, 480.0)])
def test_one_that_explains_much_less_or_not_all_is_no_rival(accepted, misfit):
    other = Trial("a wheel is late", accepted, misfit)
    best = best_trial([other, Trial("a torque acts", True, 500.0)], BEFORE)
    assert best is not None
    assert best.rival == NONE


def test_a_simpler_cause_is_no_fact_beside_one_of_more_unknowns():
    """Both explain a recording, and one is not worth its six numbers."""
    simple = Trial("a wheel's inertia is off", True, 950.0 - WORTH).with_price(20.0)
    more = Trial("axes of wheels are tilted", False, 930.0 - WORTH, fits=True)
    best = best_trial([simple, more.with_price(60.0)], BEFORE)
    assert best is not None
    words = _explained(best, BEFORE).words
    assert words.startswith("perhaps a wheel's inertia is off")
    assert "or perhaps axes of wheels are tilted" in words


@pytest.mark.parametrize(
    ("accepted", "tried"),
    [(True, ["100", "60"]), (False, ["100", "60", "40"])],
)
def test_beside_what_is_accepted_only_what_may_explain_as_much_is_tried(
    accepted, tried
):
    """Scores are of first order: half of one may be as good in a fit."""

    def scored(falls: float) -> Scored:
        cause = f"{falls:.0f}"
        return Scored(falls, cause, lambda: [Trial(cause, accepted, 0.0)])

    untried = [scored(each) for each in (100.0, 60.0, 40.0, 30.0)]
    found = [*likeliest(untried)]
    assert [one.cause for one in found] == tried
    assert [one.score for one in found] == [float(each) for each in tried]
    assert len(found) + len(untried) == LIKELIEST + 1
