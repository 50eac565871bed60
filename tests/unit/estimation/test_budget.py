"""What deviations are made of: the shares of results, and what would halve them."""

import numpy as np
import pytest
from random_motions import random_motion

import orbident as oi
from orbident.errors import InputError
from orbident.estimation.budget import Budget, Kind
from orbident.estimation.result import Result
from orbident.excitation.bound import bound_of

KINDS: dict[str, Kind] = {
    "gyro": "noise",
    "slow_torque": "recording",
    "joint zeros": "instrument",
    "gyro.scale": "instrument",
}


def budget(*shares: float, cost: float = 1.0, least_sure: str = "M") -> Budget:
    """Of the mass, where joint zeros cost so much; of `iota_1` by noise of the gyro."""
    both = np.array([shares, [1.0, 0.0, 0.0, 0.0]])
    costs = np.array([[np.nan, 1.3, cost, 1.001], [np.nan, 1.0, 1.0, 1.0]])
    names, kinds = tuple(KINDS), tuple(KINDS.values())
    return Budget(("M", "iota_1"), least_sure, names, kinds, both, costs)


NO_SINGLE = "no source is three quarters of that, and another motion may do more"


@pytest.mark.parametrize(
    ("shares", "words"),
    [
        # 1 - f (1 - 1/r^2) = 1/4 with f = 1: half of its deviation.
        ((1.0, 0.0, 0.0, 0.0), "one 2 times better halves its std"),
        ((0.9, 0.1, 0.0, 0.0), "one 2.5 times better halves its std"),
        ((0.0, 1.0, 0.0, 0.0), "2 times less of that halves its std"),
        # With f = 0.78, five times; four recordings have a quarter of all.
        ((0.78, 0.22, 0.0, 0.0), "4 times as many recordings halve its std"),
        ((0.5, 0.5, 0.0, 0.0), "4 times as many recordings halve its std"),
        # A tenth is the same in all recordings: 0.9 / n = 0.15.
        ((0.5, 0.4, 0.1, 0.0), "6 times as many recordings halve its std"),
        ((0.1, 0.0, 0.9, 0.0), "a calibration 2.5 times better halves its std"),
        ((0.5, 0.2, 0.3, 0.0), NO_SINGLE),
        ((0.0, 0.2, 0.4, 0.4), NO_SINGLE),
    ],
)
def test_what_would_halve_a_deviation(shares: tuple[float, ...], words: str):
    assert budget(*shares).halving("M") == words


def test_what_is_to_be_known_where_nothing_else_halves_it():
    words = "its std is 3.2 times as wide as if joint zeros were known"
    assert budget(0.2, 0.2, 0.6, 0.0, cost=3.2).halving("M") == words


def test_what_limits_the_mass_and_what_is_least_sure():
    found = budget(0.1, 0.0, 0.9, 0.0, least_sure="iota_1")
    assert repr(found) == (
        "M is limited by joint zeros (90 % of its variance); a calibration 2.5 times "
        "better halves its std. iota_1, the least sure, is limited by noise of the "
        "gyro (100 % of its variance); one 2 times better halves its std."
    )


def test_what_limits_both_is_said_once():
    found = budget(1.0, 0.0, 0.0, 0.0, least_sure="iota_1")
    assert found.in_words() == (
        "M is limited by noise of the gyro (100 % of its variance); one 2 times better "
        "halves its std. So is iota_1, the least sure."
    )


def test_a_table_has_what_matters_and_the_largest_first():
    rows = budget(0.1, 0.003, 0.897, 0.0, cost=2.0).table().rows
    assert [row.cells for row in rows] == [
        ("M", "joint zeros 90, gyro 10", "joint zeros 2, slow_torque 1.3"),
        ("iota_1", "gyro 100", ""),
    ]


def test_tables_of_other_sizes_are_refused():
    shares, nothing = np.ones((1, 2)), np.full((1, 2), np.nan)
    kinds: tuple[Kind, Kind] = ("noise", "noise")
    for names, sources, words in (
        (("M",), ("gyro",), "the budget is not 1 by 1"),
        (("M", "iota_1"), ("gyro", "joints"), "the budget is not 2 by 2"),
        (("iota_1",), ("gyro", "joints"), "'M' is no parameter of the budget"),
    ):
        with pytest.raises(InputError, match=words):
            Budget(names, "M", sources, kinds, shares, nothing)


@pytest.fixture(scope="module")
def flown() -> tuple[oi.Robot, oi.Recording]:
    robot = oi.load_robot("paper-spatial")
    return robot, oi.simulate(
        robot, random_motion(robot, duration=20.0), noise="sensors", seed=1
    )


@pytest.fixture(scope="module")
def result(flown) -> Result:
    return oi.identify(*flown)


def of(result: Result) -> Budget:
    found = result.budget()
    assert found is not None
    return found


def test_shares_add_up_to_one(result: Result):
    found = of(result)
    names = (*result.base.names, *result.phi.names, *result.pi.names)
    assert found.parameters == names
    assert found.shares.min() >= 0
    np.testing.assert_allclose(found.shares.sum(axis=1), 1.0, rtol=1e-12)
    assert found.costs[np.isfinite(found.costs)].min() > 1 - 1e-6


def test_other_methods_have_that_of_what_the_sensors_show(
    flown: tuple[oi.Robot, oi.Recording], result: Result
):
    assert of(oi.identify(*flown, "structured")).in_words() == of(result).in_words()


def test_the_bound_of_a_manoeuvre_is_made_of_the_same(flown, result: Result):
    """But for the noise, which is a few per cent larger or smaller in a recording."""
    robot, _ = flown
    there = bound_of(robot, random_motion(robot, duration=20.0)).budget()
    assert there.sources == of(result).sources
    np.testing.assert_allclose(there.shares, of(result).shares, atol=0.03)


@pytest.mark.slow
def test_neither_refused_nor_exact_results_have_one(flown):
    robot, recording = flown
    turned = {"gyro.x": -recording.column("gyro.x")}
    refused = oi.identify(robot, recording.with_columns(turned), "least-squares")
    assert refused.status == "rejected"
    assert refused.budget() is None
    motion = random_motion(robot, duration=20.0)
    assert oi.identify(robot, oi.simulate(robot, motion, noise="none")).budget() is None
