"""What no method of identification may take for an answer."""

import numpy as np
import pytest
from edited_recordings import changed
from random_motions import random_motion

from orbident.errors import InputError
from orbident.estimation.identify import METHODS, Method, identify
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.simulate import simulate

every_method = pytest.mark.parametrize("method", METHODS)


@every_method
@pytest.mark.parametrize("sensor", ["gyro", "attitude"])
def test_a_sensor_that_never_showed_anything_is_refused(
    method: Method, robot: Robot, recording: Recording, sensor: str
):
    dead = {
        name: np.full_like(column, np.nan)
        for name, column in recording.columns.items()
        if name.startswith(sensor)
    }
    with pytest.raises(InputError, match=sensor):
        identify(robot, changed(recording, dead), method)


@every_method
def test_no_scale_is_rejected(method: Method, robot: Robot):
    silent = simulate(robot, random_motion(robot, wheel_speed=0.0))
    result = identify(robot, silent, method)
    assert result.status == "rejected"
    assert np.isnan(result.mass.value)
    assert np.isnan(result.pi.values).all()
    assert np.isnan(result.phi.values).all()
    assert result.diagnostics is not None
    assert np.isnan(result.diagnostics.pi.values).all()
    assert np.isfinite(result.diagnostics.phi.values).all()
    assert any("pi has no scale" in warning for warning in result.warnings)


@pytest.mark.parametrize(
    ("method", "start", "factor"),
    [
        *((method, "wheel", -1.0) for method in METHODS),
        ("least-squares", "gyro", np.degrees(1.0)),
        ("maximum-likelihood", "velocity", -1.0),
    ],
)
def test_wrong_signals_are_rejected(
    method: Method, robot: Robot, recording: Recording, start: str, factor: float
):
    """The equations have a solution all the same; it must not pass for a result."""
    wrong = {
        name: factor * column
        for name, column in recording.columns.items()
        if name.startswith(start)
    }
    result = identify(robot, changed(recording, wrong), method)
    assert result.status == "rejected"
    assert np.isnan(result.mass.value)
    said = ("check units", "is in degrees per second", "the sign of", "the signs of")
    assert any(words in each for words in said for each in result.warnings)


@pytest.mark.parametrize(
    "method",
    [
        "least-squares",
        *(pytest.param(x, marks=pytest.mark.slow) for x in ("structured", "recursive")),
    ],
)
def test_no_velocity_is_rejected(method: Method, robot: Robot, recording: Recording):
    """Maximum likelihood has `pi` all the same: `tests/oracles/test_momentum_alone`."""
    blind = changed(
        recording, keep=lambda name: not name.startswith(("velocity", "position"))
    )
    result = identify(robot, blind, method)
    assert result.status == "rejected"
    assert np.isnan(result.mass.value)
    assert np.isnan(result.phi.values).all()
    assert any("velocity.x" in warning for warning in result.warnings)


@every_method
def test_too_few_samples_are_refused(
    method: Method, robot: Robot, recording: Recording
):
    with pytest.raises(InputError, match="complete samples"):
        identify(robot, changed(recording, rows=slice(5)), method)


@every_method
@pytest.mark.parametrize("column", ["gyro.y", "attitude.z", "joint.joint1.position"])
def test_missing_columns_are_refused(
    method: Method, robot: Robot, recording: Recording, column: str
):
    with pytest.raises(InputError, match=column):
        identify(robot, changed(recording, keep=lambda name: name != column), method)
