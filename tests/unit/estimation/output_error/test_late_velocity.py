"""A tracker that shows the velocity of S late, of which the clock is an unknown."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, Recorded, clean_space
from random_motions import random_motion
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.robot.tolerances import Tolerances
from orbident.simulation.simulate import float_along

NOISE = 1e-4
"""m/s."""


def late(seconds: float, duration: float = 60.0) -> Recorded:
    """A flight with the velocity in the place of the position."""
    known = clean_space(seed=3, duration=duration)
    trajectory = random_motion(
        known.robot, seed=1, duration=duration, wheel_speed=100.0, start="turning"
    )
    flown = float_along(known.robot, trajectory, RATE)
    v_S = CubicSpline(flown.t, flown.v_S)(flown.t - seconds)
    v_S += NOISE * np.random.default_rng(5).standard_normal(v_S.shape)
    columns = {
        name: x
        for name, x in known.recording.columns.items()
        if not name.startswith("position")
    }
    columns |= {f"velocity.{k}": v_S[:, i].copy() for i, k in enumerate("xyz")}
    return replace(known, recording=Recording(known.recording.t, columns))


@pytest.mark.parametrize("seconds", [2e-3, -5e-3])
def test_the_clock_of_a_velocity_is_found(seconds: float):
    """Without it the mass was off, and the recording refused."""
    known = late(seconds)
    robot = replace(known.robot, tolerances=Tolerances(position_clock=1e-2))
    result = identify(robot, known.recording)
    assert result.status == "ok"
    clock = result.calibration["position.clock"]
    assert clock.std < 1e-3
    assert abs(clock.value - seconds) < 4 * clock.std
    assert np.abs(known.z(result)).max() < 4.5
    exact = replace(known.robot, tolerances=Tolerances())
    assert identify(exact, known.recording).status != "ok"


@pytest.mark.slow
def test_a_velocity_that_is_far_too_late_is_named():
    known = late(0.1, 30.0)
    exact = replace(known.robot, tolerances=Tolerances())
    refused = identify(exact, known.recording).with_causes("quick")
    assert "the clock of the velocity is 100 ms late" in refused.refusal()


@pytest.mark.slow
def test_a_velocity_behind_a_filter_is_named():
    """Of first order: 60 ms late, and no more at once."""
    known = late(0.0, 30.0)
    t, columns = known.recording.t, dict(known.recording.columns)
    part = -np.expm1(-(t[1] - t[0]) / 0.06)
    for name in (name for name in columns if name.startswith("velocity")):
        start = columns[name][0]
        columns[name] = start + lfilter([part], [1, part - 1], columns[name] - start)
    refused = identify(known.robot, Recording(t, columns)).with_causes("quick")
    assert "the samples of the velocity are" in refused.refusal()
    assert "by a filter or by the clock" in refused.refusal()
