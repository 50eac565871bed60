"""A steady torque looks like a late clock to Eq. 24: the sensors tell them apart."""

import re

import pytest
from mistakes import by_name
from random_flights import flight, recorded
from recordings import TABLE, clean
from scipy.interpolate import CubicSpline
from scoring import scored
from spoiled import Spoiled, spoiled
from wrong_motions import torque

from orbident.estimation.clock_search import evidence
from orbident.estimation.identify import Method, estimator_of, identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.preprocessing.delays import Delay
from orbident.recordings.recording import Recording


def late(rows: int) -> Spoiled:
    """Joints and wheels as they were so many rows ago; a row is 20 ms."""
    exact = clean(TABLE)
    recording = exact.recorded()
    columns = {
        name: x[:-rows] if name.startswith(("joint", "wheel")) else x[rows:]
        for name, x in recording.columns.items()
    }
    return spoiled(exact, recording=Recording(recording.t[rows:], columns))


def clock(mistake: Spoiled, method: Method) -> Delay:
    """That of joints and wheels, as the sensors show it."""
    problem = momentum_problem(
        mistake.robot, mistake.recording, mistake.initial_momentum, lambda _: None
    )
    found = evidence(problem, estimator_of(method), lambda _: None)
    return found.problem.clocks["joints"]


@pytest.mark.parametrize(
    ("method", "size"), [("maximum-likelihood", 1e-4), ("least-squares", 1e-3)]
)
def test_a_torque_that_looks_like_a_late_clock(method: Method, size: float):
    """To Eq. 24 joints seem to be 0.1 s or 0.7 s early; they are on time."""
    assert not clock(torque(size)(clean(TABLE)), method).believed


@pytest.mark.parametrize(
    ("method", "rows"), [("maximum-likelihood", 2), ("least-squares", 1)]
)
def test_a_clock_that_is_late(method: Method, rows: int):
    found = clock(late(rows), method)
    assert found.believed
    assert found.late == pytest.approx(0.02 * rows, abs=4 * found.std)


@pytest.mark.slow
@pytest.mark.parametrize("size", ["0.0001", "0.001"])
def test_a_torque_for_ten_seconds_is_found(size: str):
    """A step of its search that leads far costs less if parameters stay where it led.

    The attitudes where intervals meet are then corrected alone.
    """
    mistake = by_name(f"torque {size} N m over 10 s")
    found = scored(mistake.spoil(clean(TABLE)), "maximum-likelihood", causes=False)
    assert found.outcome == "right"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["table 5", pytest.param("table 9", marks=pytest.mark.long)]
)
def test_a_late_attitude_without_a_gyro(name: str):
    """The other clocks are beside that of the attitude then, wherever it is tried."""
    clean, known = flight(name), recorded(flight(name), 0)
    t, late = known.recording.t, 0.06
    columns = {
        key: CubicSpline(t, x)(t - late) if key.startswith("attitude") else x
        for key, x in known.recording.columns.items()
    }
    recording = Recording(t, columns, "late")
    result = identify(clean.robot, recording, initial_momentum="at-rest")
    words = result.with_causes("all").refusal()
    said = re.match(r"the clock of the attitude is (\S+) ms late", words)
    assert said, words
    assert float(said[1]) == pytest.approx(60.0, abs=5.0)
