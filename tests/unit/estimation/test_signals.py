"""What the equations predict is what the robot did."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate


@pytest.fixture(scope="module")
def recording() -> Recording:
    robot = load_robot("cepheus-like")
    return simulate(robot, random_motion(robot, duration=5.0, start="spun up"))


def _check_exact(found: Result, recording: Recording) -> None:
    for signal in found.signals():
        assert (signal.t == recording.t).all()
        size = np.abs(signal.measured).max()
        assert size > 0
        # Rounding of a fit over some hundred samples.
        np.testing.assert_allclose(
            signal.measured, signal.predicted, atol=1e-9 * size, rtol=0
        )


def test_known_momentum(recording: Recording):
    robot = load_robot("cepheus-like")
    found = identify(robot, recording, "least-squares", "at-rest")
    momentum, velocity = found.signals()
    assert (momentum.axes, velocity.axes) == (("z",), ("x", "y"))
    assert momentum.units == ("N m s",)
    _check_exact(found, recording)
    (wheel,) = robot.wheels
    h_rw = wheel.inertia * recording.column(f"wheel.{wheel.name}.speed")
    # What base and arms have is what the wheel has taken.
    np.testing.assert_allclose(
        momentum.measured[:, 0], -h_rw * wheel.axis[2], rtol=1e-12
    )


def test_unknown_momentum():
    robot = load_robot("paper-spatial")
    flight = simulate(robot, random_motion(robot, duration=10.0))
    found = identify(robot, flight, "structured", "unknown")
    assert [signal.axes for signal in found.signals()] == 2 * [("x", "y", "z")]
    _check_exact(found, flight)


def test_velocity_that_was_not_measured_has_no_signal(recording: Recording):
    robot = load_robot("cepheus-like")
    kept = {
        name: column
        for name, column in recording.columns.items()
        if not name.startswith(("position", "velocity"))
    }
    without = replace(recording, columns=kept)
    found = identify(robot, without, "least-squares", "at-rest")
    assert [signal.name for signal in found.signals()] == ["momentum"]
    assert found.motion is not None
    assert found.motion["duration"] == 5.0
    assert found.motion["locked"] == []
