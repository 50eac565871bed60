"""Mistakes against which no cause was written: refused, and named."""

import os

import numpy as np
import pytest
from held_out import KINDS, Case, Count, Row, all_rows, markdown, row
from mistake import Mistake
from random_flights import flight

DRAW = 2
NAMED = 0.8
"""Of the refusals, at least this part names the true cause first."""

QUICK = (Case(1, "table 15271", "joint slip"),)


@pytest.mark.slow
@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.kind)
def test_a_drawn_mistake_is_named(case: Case):
    found = row(case)
    assert found.named, found


@pytest.mark.long
def test_a_hard_push_is_no_late_clock():
    found = row(Case(751, "table 73681", "thruster burst"))
    assert found.score.outcome == "right", found


@pytest.mark.slow
def test_what_an_error_explains_is_no_push():
    # The samples that a push leaves out would hide it.
    found = row(Case(711, "table 82917", "other inertial axes"))
    assert found.score.outcome == "refused", found


def test_there_are_enough_kinds_and_all_can_be_made():
    assert len(KINDS) >= 30
    for kind in KINDS.values():
        name = "space 30550" if kind.space else "table 10099"
        clean, random = flight(name), np.random.default_rng(0)
        if len(clean.robot.wheels) >= kind.wheels:
            assert isinstance(kind.draw(clean, random), Mistake)


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return all_rows(DRAW, workers=min(2, os.cpu_count() or 1))


@pytest.mark.long
def test_nothing_wrong_that_can_be_seen_is_accepted(rows: list[Row]):
    n = Count(rows)
    assert n.wrong == [], markdown(n.wrong)
    assert n.crashed == [], markdown(n.crashed)


@pytest.mark.long
def test_refusals_name_the_true_cause(rows: list[Row]):
    n = Count(rows)
    assert n.named >= NAMED * n.refused, markdown(rows)
