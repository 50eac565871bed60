"""Gyro and attitude show the same turning, or one of them is written otherwise."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cause_problems import clean, problem_with

from orbident.diagnosis.conventions import conventions, turned_in
from orbident.diagnosis.linear_test import tried_conventions

EVERY = 4  # rows: an attitude that is rarer than the gyro's samples

Columns = dict[str, Callable[[np.ndarray], np.ndarray]]


def rarer(x: np.ndarray) -> np.ndarray:
    return np.where(np.arange(x.size) % EVERY, np.nan, x)


RARE: Columns = {f"attitude.{axis}": rarer for axis in "xyzw"}


def exchanged() -> Columns:
    x, y = (clean().recording.column(f"gyro.{axis}") for axis in "xy")
    return {"gyro.x": lambda _: y, "gyro.y": lambda _: x}


def of_them(columns: Columns) -> list[str]:
    """The conventions of gyro and attitude that are tried."""
    every = conventions(problem_with(RARE | columns))
    named = "attitude sensor", "of the attitude is", "gyro"
    return [one.cause for one in every if any(name in one.cause for name in named)]


def test_both_agree_as_they_were_recorded():
    turned = turned_in(problem_with(RARE).recording)
    assert turned.apart < 0.02
    assert turned.ratio == pytest.approx(1.0, abs=0.02)
    assert not of_them({})


def test_a_single_attitude_shows_no_convention():
    first = {
        f"attitude.{axis}": lambda x: np.where(np.arange(x.size), np.nan, x)
        for axis in "xyzw"
    }
    assert np.isnan(turned_in(problem_with(first).recording).apart)
    assert tried_conventions(problem_with(first))


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (
            {f"gyro.{axis}": lambda x: 2 * x for axis in "xyz"},
            "the gyro turns the base 2 times as far as the attitude does, so that its "
            "unit, or that of the times, is another one",
        ),
        (
            {f"gyro.{axis}": np.degrees for axis in "xyz"},
            "the gyro is in degrees per second",
        ),
        ({"gyro.z": np.negative}, "the sign of z of the gyro differs"),
        (exchanged(), "its y, x, z) of the gyro differ"),
        ({f"attitude.{axis}": np.negative for axis in "xyz"}, "is the inverse"),
    ],
)
def test_what_makes_them_agree_is_named(columns: Columns, words: str):
    """The attitude is fused with the gyro: all is derived again with it put right."""
    one = {name: change for name, change in columns.items() if name not in RARE}
    both = {
        name: (lambda x, change=change: rarer(change(x)))
        for name, change in columns.items()
        if name in RARE
    }
    problem = problem_with(RARE | one | both)
    first = tried_conventions(problem)[0]
    assert words in first.convention.cause
    assert first.residuals_alone > 10
    assert any(words in cause for cause in of_them(one | both))


def test_times_that_are_twice_as_long_are_named():
    problem = problem_with(RARE)
    longer = replace(problem.recording, t=2 * problem.recording.t)
    first = tried_conventions(problem.amended(recording=longer))[0]
    assert "turns the base 2 times as far" in first.convention.cause
    assert first.residuals_alone > 10


def test_a_clock_that_is_late_is_no_convention():
    late = {f"attitude.{axis}": lambda x: rarer(np.roll(x, EVERY)) for axis in "xyzw"}
    assert not of_them(late)
