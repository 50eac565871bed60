"""The time at which a robot changed, found by fitting parts of its recording."""

from typing import Any, NamedTuple, cast

import numpy as np
import pytest

from orbident.estimation import solve
from orbident.estimation.estimate import Change
from orbident.estimation.levels import ChiSquare

CHANGED = 50.0
"""s: a part fits that ends before it, or begins after it."""
UNSEEN = 3.0
"""s after it, in which it passes for a torque."""
T = np.arange(0.0, 100.0, 0.1)


class Made(NamedTuple):
    """A fit of a part: which robot it is, and what seems to act."""

    robot: int
    acting: frozenset[str] = frozenset()

    @property
    def shown(self) -> "Made":
        """What it shows."""
        return self


def between(begin: float, end: float) -> Made | None:
    """A part with some seconds of the other robot fits, too, with a torque."""
    if end < CHANGED or begin > CHANGED:
        return Made(int(begin > CHANGED))
    if end < CHANGED + UNSEEN:
        return Made(2, frozenset({"torque"}))
    return None


def apart(one: Made, other: Made) -> ChiSquare:
    return ChiSquare(1e4 if one.robot != other.robot else 1.0, 10)


def next_change(parts: Any, *alarms: float) -> Change | None:
    """The first one, where a filter raised alarms at these times, s."""
    suspected = [Change(t, t - 1, 2.0, 0.99) for t in alarms]
    return solve._next_change(parts, cast("Any", apart), T, -np.inf, suspected)


@pytest.mark.parametrize(
    "alarms",
    [
        pytest.param([51.0], id="soon after it"),
        pytest.param([30.0, 51.0], id="before it and soon after it"),
        pytest.param(
            [30.0, 55.5], id="an alarm before, and its next part has some of it"
        ),
        pytest.param([30.0, 80.0], id="none near it"),
    ],
)
def test_a_change_is_where_another_robot_begins(alarms):
    found = next_change(between, *alarms)
    assert found is not None
    assert CHANGED <= found.t < CHANGED + 2 * UNSEEN


def test_what_acts_begins_no_other_robot():
    """A torque that seems to act at the end of a part says nothing of the robot."""

    def acted(begin: float, end: float) -> Made | None:
        return between(begin, min(end, CHANGED + UNSEEN / 2)) if begin < 30.0 else None

    assert next_change(acted, 40.0) is None
