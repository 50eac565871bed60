"""No wrong number is accepted, whatever is wrong with recording or robot file."""

import os
import re

import pytest
from campaign_of_mistakes import all_rows
from mistake import Mistake
from mistakes import MISTAKES, QUICK, REAL_EFFECTS, by_name
from recordings import ROBOTS, SPACE, clean
from remembered_fits import fits_remembered
from scoring import Row, row, scored
from spoiled import nothing, tolerating
from table import Count, markdown
from visibility import visibility

from orbident.estimation.identify import METHODS, Method

NAMED = 0.8
"""Of the refusals, at least this part names the true cause first."""

QUICK_METHODS: tuple[Method, ...] = ("maximum-likelihood", "structured")
"""All methods are judged by the same residuals; the long test has all four."""

CASES = [
    pytest.param(
        *(robot, name),
        id=f"{robot}, {name}",
        marks=[pytest.mark.slow] if robot == SPACE else [],
    )
    for name in QUICK
    for robot in by_name(name).robots
    if robot not in by_name(name).unobservable
]


@pytest.mark.parametrize(("robot", "name"), CASES)
def test_nothing_wrong_is_accepted(robot: str, name: str):
    """What hides in the noise is right where the robot file declares a tolerance."""
    mistake = by_name(name)
    for method, score in row(robot, mistake, QUICK_METHODS).scores.items():
        if score.outcome in {"refused", "right"}:
            continue
        assert mistake.tolerance, (method, score)
        covered = tolerating(mistake.spoil(clean(robot)), mistake.tolerance)
        assert scored(covered, method).outcome == "right", method


@pytest.mark.parametrize(
    "name",
    [
        *("all joints negated", "quaternion scalar first"),
        pytest.param("joint2 zero off 20 mrad", marks=pytest.mark.slow),
    ],
)
def test_a_refusal_names_the_cause(name: str):
    """One mistake of each kind is made; for all of them see the long test."""
    found = row(ROBOTS[0], by_name(name), ("maximum-likelihood",), causes=True)
    assert found.named("maximum-likelihood"), found


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("robot", ROBOTS)
def test_what_has_no_mistake_is_accepted(robot: str, method: Method):
    score = scored(nothing(clean(robot)), method)
    assert score.outcome == "right", score


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return all_rows(workers=min(2, os.cpu_count() or 1))


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_no_wrong_number_is_ever_accepted(rows: list[Row], method: Method):
    n = Count(rows, method)
    assert n.wrong == [], markdown(n.wrong)
    assert n.crashed == [], markdown(n.crashed)


@pytest.mark.long
def test_refusals_name_the_true_cause(rows: list[Row]):
    counts = [Count(rows, method) for method in METHODS]
    named, refused = sum(n.named for n in counts), sum(n.refused for n in counts)
    assert named >= NAMED * refused, markdown(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param("joint2 zero off 20 mrad", marks=pytest.mark.long),
        pytest.param("joint2 scale 1 %", marks=pytest.mark.long),
        "gyro scale 1 %",
    ],
)
def test_a_cause_is_named_beside_usual_tolerances(name: str):
    """An error of twenty tolerances is found, and the residuals are as noise."""
    mistake, method = by_name(name), "maximum-likelihood"
    found = row(SPACE, mistake, (method,), causes=True, usual=True)
    assert found.named(method), found


TOLERABLE = [
    pytest.param(robot, mistake.name, id=f"{robot}, {mistake.name}")
    for mistake in MISTAKES
    for robot in mistake.robots
    if mistake.tolerance
]


@pytest.mark.long
@pytest.mark.parametrize(("robot", "name"), TOLERABLE)
def test_with_its_tolerance_declared_nothing_is_wrong(robot: str, name: str):
    """What cannot be seen is no excuse then."""
    mistake = by_name(name)
    assert mistake.tolerance
    covered = tolerating(mistake.spoil(clean(robot)), mistake.tolerance)
    with fits_remembered():
        scores = {method: scored(covered, method) for method in METHODS}
    outcomes = {method: score.outcome for method, score in scores.items()}
    assert {*outcomes.values()} <= {"right", "refused"}, scores
    print(outcomes)


HIDDEN = [
    pytest.param(robot, mistake.name, id=f"{robot}, {mistake.name}")
    for mistake in (*MISTAKES, *REAL_EFFECTS)
    for robot in mistake.unobservable
]


@pytest.mark.long
@pytest.mark.parametrize(("robot", "name"), HIDDEN)
def test_what_is_excused_cannot_be_seen(robot: str, name: str):
    assert not visibility(robot, by_name(name).spoil).seen


def test_there_are_enough_mistakes():
    names = [mistake.name for mistake in MISTAKES]
    assert len(names) == len(set(names))
    for robot in ROBOTS:
        assert sum(robot in mistake.robots for mistake in MISTAKES) >= 60


KINDS = {
    re.sub(r"(?<!\w)[\d.]+(e-\d+)?", "#", mistake.name): mistake
    for mistake in (*MISTAKES, *REAL_EFFECTS)
}
"""One size of each, the last one: sizes differ by a number alone."""


@pytest.mark.slow
@pytest.mark.parametrize("mistake", KINDS.values(), ids=lambda x: x.name)
def test_every_row_of_the_tables_can_be_recorded(mistake: Mistake):
    """What the long tables try in half an hour begins here, on one robot each."""
    assert mistake.spoil(clean(mistake.robots[-1])).recording.t.size
