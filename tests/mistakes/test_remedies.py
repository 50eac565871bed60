"""Who does as a refusal says has the right result, or is refused again."""

import os

import pytest
from mistakes import MISTAKES, REAL_EFFECTS
from recordings import SPACE, TABLE
from remedies import Row, all_rows, markdown, row

QUICK = [
    pytest.param(TABLE, "all joints negated", ["right"], id="convention"),
    pytest.param(TABLE, "joint2 slips 20 mrad", ["right"], id="size"),
    pytest.param(
        *(SPACE, "joint2 zero off 20 mrad", ["right", "right"]),
        id="size, tolerance",
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize(("robot", "name", "outcomes"), QUICK)
def test_what_is_done_as_is_said_is_right(robot: str, name: str, outcomes: list[str]):
    found = row((robot, name))
    assert found is not None
    assert [one.outcome for one in found.attempts] == outcomes, found


def test_what_is_accepted_at_first_needs_nothing():
    assert row((TABLE, "link1 1 mm longer")) is None


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return all_rows(min(2, os.cpu_count() or 1), of=(*MISTAKES, *REAL_EFFECTS))


@pytest.mark.long
def test_nothing_wrong_is_accepted_that_was_done_as_is_said(rows: list[Row]):
    failed = [row for row in rows if row.has("wrong") or row.has("crashed")]
    assert failed == [], markdown(failed)
