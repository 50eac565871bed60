"""The first real flight: a satellite on an air-bearing floor, weighed by three scales.

Its file is no part of this project (`examples/air-bearing-satellite/identify.py` says
where it is from). With the place of it,

    export ORBIDENT_REAL_FLIGHT=real_test_data.csv
    pytest tests/oracles/test_air_bearing_satellite.py
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples import EXAMPLES, identifying

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.robot.robot_file import load_robot

FLIGHT = Path(os.environ.get("ORBIDENT_REAL_FLIGHT", "real_test_data.csv"))

pytestmark = pytest.mark.skipif(
    not FLIGHT.is_file(), reason="ORBIDENT_REAL_FLIGHT does not name the flight's file"
)

EXAMPLE = EXAMPLES / "air-bearing-satellite"

WEIGHED = 23.09
"""kg, by scales."""

COM = np.array([0.0056, 0.0008])
"""m, by the same."""


@pytest.fixture(scope="module")
def example():
    return identifying("air-bearing-satellite")


@pytest.fixture(scope="module")
def robot():
    return load_robot(EXAMPLE / "satellite.yaml")


@pytest.fixture(scope="module")
def by_bench(example, robot) -> Result:
    return identify(robot, example.recording(FLIGHT))


def test_the_dead_valve_is_named(by_bench):
    assert by_bench.status == "ok", by_bench.warnings
    named = [c.name for c in by_bench.checks if "gives no thrust" in c.reason]
    assert named == ["thruster.t2.gain"]
    others = {c.name for c in by_bench.checks if c.level != "trust"} - {*named}
    assert not others


def test_the_mass_is_within_its_interval(by_bench):
    M = by_bench.mass
    assert abs(M.value - WEIGHED) < 1.96 * M.std < 0.45 * WEIGHED


def test_commands_are_late(by_bench):
    """As by whitened regression: 0.08 to 0.09 s, and 0.03 to 0.04 s more to close."""
    clock, pulse = (by_bench.calibration[f"thrusters.{x}"] for x in ("clock", "pulse"))
    assert 0.08 < clock.value < 0.10
    assert clock.std < 0.005
    assert 0.025 < pulse.value < 0.045


def test_with_the_mass_of_scales_thrust_and_inertia_are_known(example, robot):
    result = identify(replace(robot, known=example.SCALES), example.recording(FLIGHT))
    assert result.status == "ok", result.warnings
    M, *sigma, I = zip(result.base.values, result.base.std, strict=True)
    assert abs(M[0] - WEIGHED) < 0.03
    for (s, std), c in zip(sigma, COM, strict=True):
        assert abs(s / WEIGHED - c) < 3 * std / WEIGHED < 0.015
    assert I[1] < 0.05 * I[0]
    gains = [x for n, x in result.calibration.items() if n.endswith(".gain")]
    assert len(gains) == 8
    assert all(0 < each.std < 0.12 for each in gains)


def test_both_halves_have_the_same_parameters(example, robot):
    """Mass, CM, inertia and every valve; latency was another one."""
    one, other = (
        identify(robot, example.recording(FLIGHT, begin, end))
        for begin, end in ((0.0, 65.0), (65.0, 130.0))
    )
    off = one.base.values - other.base.values
    assert np.all(np.abs(off) < 3 * np.hypot(one.base.std, other.base.std))
    for name, fit in one.calibration.items():
        again = other.calibration[name]
        if name.endswith(".gain"):
            # Of the dead one, too, whose latency nobody sees.
            assert abs(fit.value - again.value) < 3.5 * np.hypot(fit.std, again.std)


def test_at_once_it_is_refused(example, robot):
    result = identify(example.without_latency(robot), example.recording(FLIGHT))
    assert result.status == "rejected"
