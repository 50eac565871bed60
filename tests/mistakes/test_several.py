"""Several recordings of one robot are identified as one.

The statistics: `pytest -m long tests/mistakes/test_several.py`, some ten minutes.
"""

from dataclasses import replace

import numpy as np
import pytest
from random_flights import flights
from several_flights import flights_of, recorded, with_payload

import orbident as oi
from orbident.errors import InputError
from orbident.estimation.solution import Shared, together
from orbident.estimation.unknowns import Unknown

TABLE = "table 3"


@pytest.fixture(scope="module")
def recordings() -> list[oi.Recording]:
    return recorded(flights_of(TABLE), 0)


@pytest.fixture(scope="module")
def robot() -> oi.Robot:
    return flights_of(TABLE)[0].robot


@pytest.fixture(scope="module")
def one(robot: oi.Robot, recordings: list[oi.Recording]) -> oi.Result:
    return oi.identify(robot, recordings, initial_momentum="at-rest")


@pytest.fixture(scope="module")
def alone(robot: oi.Robot, recordings: list[oi.Recording]) -> list[oi.Result]:
    return [oi.identify(robot, each, initial_momentum="at-rest") for each in recordings]


def test_it_is_the_mean_of_each_alone_weighted_by_information(
    one: oi.Result, alone: list[oi.Result]
):
    """It is so to first order; the mean is made of matrices nobody factorised."""
    information = [np.linalg.inv(each.base_covariance) for each in alone]
    C = np.linalg.inv(sum(information))
    mean = C @ sum(
        A @ each.base.values for A, each in zip(information, alone, strict=True)
    )
    assert one.status == "ok"
    np.testing.assert_allclose(one.base.std, np.sqrt(np.diag(C)), rtol=0.02)
    assert np.abs((one.base.values - mean) / one.base.std).max() < 0.1


def test_what_is_true_lies_within_its_deviations(robot: oi.Robot, one: oi.Result):
    beta = oi.minimal_sets(robot).beta(robot.theta)
    z = (one.base.values - beta) / one.base.std
    assert np.abs(z).max() < 4


@pytest.mark.slow
def test_the_order_of_recordings_does_not_matter(
    robot: oi.Robot, recordings: list[oi.Recording], one: oi.Result
):
    back = oi.identify(robot, recordings[::-1], initial_momentum="at-rest")
    off = np.abs(back.base.values - one.base.values) / one.base.std
    assert off.max() < 0.01


def test_what_is_a_recording_s_own_begins_with_its_name(one: oi.Result):
    assert {name.partition(": ")[0] for name in one.biases} <= {
        "first",
        "second",
        "third",
    }
    assert {signal.sensor for signal in one.signals()} >= {"attitude", "position"}
    assert (
        one.samples == 3 * one.residual.get("sensors", {})["first: position"]["samples"]
    )


def test_the_recording_of_another_robot_is_named(robot: oi.Robot):
    first, second, third = flights_of(TABLE)
    other = recorded([first, with_payload(second, 0.02), third], 0)
    refused = oi.identify(robot, other, initial_momentum="at-rest")
    assert refused.status == "rejected"
    assert refused.refusal().startswith("second does not show the same robot")
    assert np.isnan(refused.base.values).all()


def test_of_two_that_differ_neither_is_named(robot: oi.Robot):
    first, second, _ = flights_of(TABLE)
    other = recorded([first, with_payload(second, 0.02)], 0)
    refused = oi.identify(robot, other, initial_momentum="at-rest")
    assert "'first', 'second' do not show the same robot" in refused.refusal()


@pytest.mark.slow
def test_one_that_is_refused_by_itself_refuses_all(
    robot: oi.Robot, recordings: list[oi.Recording]
):
    first, second, third = recordings
    columns = dict(second.columns)
    columns["joint.joint1.position"] = -columns["joint.joint1.position"]
    wrong = replace(second, columns=columns)
    refused = oi.identify(robot, [first, wrong, third], initial_momentum="at-rest")
    assert refused.status == "rejected"
    assert refused.with_causes().refusal().startswith("second: ")
    assert np.isnan(refused.base.values).all()


def test_a_recording_counts_once(robot: oi.Robot, recordings: list[oi.Recording]):
    first, second, _ = recordings
    copy = replace(first, source="copy.csv")
    with pytest.raises(InputError, match=r"copy\.csv are the same recording"):
        oi.identify(robot, [first, second, copy])


def test_other_methods_take_one(robot: oi.Robot, recordings: list[oi.Recording]):
    with pytest.raises(InputError, match="maximum likelihood only, not by structured"):
        oi.identify(robot, recordings, "structured")


def test_none_is_no_recording(robot: oi.Robot):
    with pytest.raises(InputError, match="no recording is given"):
        oi.identify(robot, [])


def test_what_they_say_together_is_said_of_the_unknowns_that_each_has():
    """Beside least squares of all equations at once, tolerances among them."""
    random = np.random.default_rng(1)
    zero, gain = (
        Unknown(name, name, "1", std, 0.0)
        for name, std in (("zero", 0.1), ("gain", 2.0))
    )
    A, B = random.normal(size=(2, 4, 5))
    # [beta, beta, zero] and [beta, beta, gain], then the right-hand side.
    a, b = A[:, :4], B[:, :4]
    said = together([Shared(np.zeros(2), (zero,), a), Shared(np.zeros(2), (gain,), b)])
    wide = said.over([zero])
    every = np.zeros((9, 4))
    right = np.zeros(9)
    every[:4, [0, 1, 2]], right[:4] = a[:, :3], a[:, 3]
    every[4:8, [0, 1, 3]], right[4:8] = b[:, :3], b[:, 3]
    every[8, 3] = 1 / gain.std
    N = every.T @ every
    # Without the gain.
    schur = N[:3, :3] - np.outer(N[:3, 3], N[3, :3]) / N[3, 3]
    np.testing.assert_allclose(wide[:, :3].T @ wide[:, :3], schur, atol=1e-12)
    x = np.linalg.lstsq(every, right)[0]
    np.testing.assert_allclose(np.linalg.lstsq(wide[:, :3], wide[:, 3])[0], x[:3])


ROBOTS = 17
"""Random robots, every second one on a table."""


@pytest.mark.long
def test_errors_are_as_large_as_those_of_three_say():
    """RMS error over deviation, which is the bound of all three; 20 robots, 2 seeds."""
    z = []
    for name in flights():
        three = flights_of(name)
        robot, known = three[0].robot, three[0].initial_momentum
        beta = oi.minimal_sets(robot).beta(robot.theta)
        for seed in range(2):
            one = oi.identify(robot, recorded(three, seed), initial_momentum=known)
            assert one.status == "ok", (name, seed, one.refusal())
            off = (one.base.values - beta) / one.base.std
            z += [*off[np.isfinite(off)]]
    assert np.sqrt(np.mean(np.square(z))) < 1.05
    assert 0.93 < np.mean(np.abs(z) < 1.96) < 0.97


@pytest.mark.long
def test_one_of_another_robot_is_always_named():
    """A payload of 2 % of the mass, in one of three recordings of 17 robots."""
    for k, name in enumerate([*flights()][:ROBOTS]):
        three = flights_of(name)
        robot, known = three[0].robot, three[0].initial_momentum
        for odd, label in enumerate(("first", "second", "third")):
            changed = [*three]
            changed[odd] = with_payload(three[odd], 0.02)
            refused = oi.identify(
                robot, recorded(changed, 100 + k), initial_momentum=known
            )
            assert refused.refusal().startswith(f"{label} does not show"), (name, odd)
