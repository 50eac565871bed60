"""Some seconds of a flight: a fit ends at the robot, or the recording is refused.

`ORBIDENT_RUNS=200 pytest -m long -s tests/mistakes/test_short_recordings.py` prints
those that are refused.
"""

import os
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from random_flights import flight

import orbident as oi
from orbident.diagnosis.linear_test import plain_mistake
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import momentum_problem
from orbident.simulation.measure import measure_truth

RUNS = int(os.environ.get("ORBIDENT_RUNS", "40"))
FAR = 5.0
"""Deviations: of ten thousand numbers none is so far off by chance."""


class Window(NamedTuple):
    """Some seconds of a flight."""

    true: oi.Robot
    cad: oi.Robot
    """Masses and inertias are 20 % off at most."""
    recording: oi.Recording
    initial_momentum: InitialMomentum

    def identified(self, robot: oi.Robot) -> oi.Result:
        known = self.initial_momentum
        return oi.identify(robot, self.recording, initial_momentum=known)


def seconds_of(n: int) -> Window:
    """10 to 30 s of one of ten flights."""
    place = "table" if n % 2 else "space"
    flown = flight(f"{place} {7000 + n % 10}")
    random = np.random.default_rng([44, n])
    off = 1 + 0.2 * random.uniform(-1, 1, (len(flown.robot.bodies), 1))
    cad = replace(flown.robot, theta=off * flown.robot.theta)
    size = min(random.uniform(10.0, 30.0), 0.95 * flown.t[-1])
    # Wheels of robots on tables spin up at the start, which alone gives a scale.
    later = flown.initial_momentum == "unknown"
    start = random.uniform(0.0, flown.t[-1] - size) if later else 0.0
    whole = measure_truth(flown.robot, flown.t, flown.true, n)
    part = whole.between(start, start + size)
    return Window(flown.robot, cad, part, flown.initial_momentum)


def off(result: oi.Result, true: oi.Robot) -> float:
    """The worst base parameter's error, in deviations."""
    beta = oi.minimal_sets(true).beta(true.theta)
    return float(np.nanmax(np.abs(result.base.values - beta) / result.base.std))


def test_nothing_in_them_is_plainly_a_mistake():
    """A linear equation of few seconds has parameters that are far from the truth."""
    for n in range(0, 200, 32):
        window = seconds_of(n)
        problem = momentum_problem(
            window.cad, window.recording, window.initial_momentum, lambda _: None
        )
        assert not plain_mistake(problem), n


@pytest.mark.parametrize(
    "n", [*(pytest.param(n, marks=pytest.mark.slow) for n in (4, 18)), 186]
)
def test_a_search_ends_where_that_from_the_true_robot_does(n: int):
    """From neither a search leads there whose attitude has to turn as it should."""
    window = seconds_of(n)
    found, known = (window.identified(x) for x in (window.cad, window.true))
    assert found.status == known.status == "ok"
    apart = np.abs(found.base.values - known.base.values) / found.base.std
    assert apart.max() < 0.1
    assert off(found, window.true) < 3


@pytest.mark.slow
def test_what_noise_shows_of_the_mass_is_not_known():
    """With noise taken for a motion it seemed known to 13 %; others were 4.4 off."""
    window = seconds_of(128)
    result = window.identified(window.cad)
    assert result.status == "rejected"
    (said,) = (str(each) for each in result.checks if each.name == "mass")
    assert "a standard deviation of" in said
    assert "record a richer or longer motion" in said
    # By linear equations alone the sign of a wheel would be the opposite.
    assert not [each for each in result.with_causes().checks if each.name == "cause"]


@pytest.mark.long
def test_seconds_are_right_or_refused():
    refused, worst = 0, 0.0
    for n in range(RUNS):
        window = seconds_of(n)
        result = window.identified(window.cad)
        if result.status == "ok":
            worst = max(worst, off(result, window.true))
        else:
            refused += 1
            print(n, result.refusal())
    print(f"{RUNS} windows: {refused} refused, the others {worst:.1f} off at most")
    assert worst < FAR
    assert refused <= 0.05 * RUNS
