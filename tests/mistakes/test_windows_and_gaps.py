"""Short pieces of good flights, and flights in which instruments are silent.

`ORBIDENT_RUNS=20 pytest -m long -s tests/mistakes/test_windows_and_gaps.py` makes 20
windows of each of ten robots, and 60 flights with gaps.
"""

import os
from typing import NamedTuple

import numpy as np
import pytest
from random_flights import Known, flight, flights, recorded
from recordings import Clean
from scoring import misses_of

import orbident as oi
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.result import Result
from orbident.recordings.recording import Recording

RUNS = int(os.environ.get("ORBIDENT_RUNS", "1"))
SHORTEST, LONGEST = 10.0, 30.0
"""s of a window."""
SHORTEST_GAP, LONGEST_GAP = 0.5, 10.0
"""s; a flight on a table lasts 20 s."""
FAR = 5.0
"""Deviations: of a normal error beyond them there is one in two million."""
SAME = 0.05
"""Deviations by which two searches that end in one minimum may differ."""
SILENT = ("", "gyro", "attitude", "joint", "wheel", "position")
"""Instruments with a gap, by how their columns begin; the first one is all of them."""


class Found(NamedTuple):
    name: str
    result: Result
    off: float
    """The largest error of a base parameter, in its deviations; NaN where refused."""

    def line(self) -> str:
        why = self.result.warnings[0] if self.refused else ""
        return f"{self.name}: {self.result.status} {self.off:.1f} {why}"

    @property
    def refused(self) -> bool:
        return self.result.status == "rejected"


def found(name: str, true: oi.Robot, known: Known, momentum: InitialMomentum) -> Found:
    result = oi.identify(known.robot, known.recording, initial_momentum=momentum)
    refused = result.status == "rejected"
    return Found(name, result, np.nan if refused else misses_of(result, true).base)


def window_of(clean: Clean, recording: Recording, seed: int) -> Recording:
    """A piece of it, anywhere."""
    random = np.random.default_rng(seed)
    whole = float(np.ptp(recording.t))
    length = random.uniform(SHORTEST, min(LONGEST, whole))
    begin = recording.t[0] + random.uniform(0.0, whole - length)
    return recording.between(begin, begin + length)


def silenced(recording: Recording, sensor: str, seed: int) -> Recording:
    """The recording with a gap in one instrument or in all."""
    random = np.random.default_rng(seed)
    length = random.uniform(SHORTEST_GAP, min(LONGEST_GAP, np.ptp(recording.t) / 3))
    begin = random.uniform(recording.t[0], recording.t[-1] - length)
    inside = (recording.t > begin) & (recording.t < begin + length)
    return recording.with_columns(
        {
            name: np.where(inside, np.nan, x)
            for name, x in recording.columns.items()
            if name.startswith(sensor)
        }
    )


@pytest.mark.long
@pytest.mark.parametrize("name", [*flights()][::2])
def test_a_short_window_ends_where_that_of_the_true_robot_does(name: str):
    clean, elsewhere = flight(name), []
    for seed in range(RUNS):
        known = recorded(clean, seed)
        part = window_of(clean, known.recording, seed)
        one, other = (
            found(f"{name} {seed}", clean.robot, Known(robot, part), "unknown")
            for robot in (known.robot, clean.robot)
        )
        print(one.line())
        assert not one.off > FAR, one.line()
        a, b = one.result.base, other.result.base
        with np.errstate(invalid="ignore"):
            apart = np.nanmax(np.abs(a.values - b.values) / a.std, initial=0.0)
        if one.refused != other.refused or apart > SAME:
            elsewhere.append(
                f"{one.line()} | from the true robot {other.line()} {apart}"
            )
    assert not elsewhere, elsewhere


@pytest.mark.long
@pytest.mark.parametrize("sensor", SILENT)
def test_a_gap_is_a_gap(sensor: str):
    every = [*flights()]
    for k in range(RUNS // 2):
        name = every[(7 * k + len(sensor)) % len(every)]
        clean = flight(name)
        known = recorded(clean, 100 + k)
        part = silenced(known.recording, sensor, k)
        momentum = clean.initial_momentum
        one = found(
            f"{name} {k}", clean.robot, known._replace(recording=part), momentum
        )
        print(one.line())
        assert not one.refused
        assert one.off <= FAR, one.line()
