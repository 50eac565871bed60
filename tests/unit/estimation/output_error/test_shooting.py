"""Shooting intervals are as long as what joints show of their motion allows."""

from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import clean_space

from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error import shooting
from orbident.estimation.output_error.sensors import sensors_of
from orbident.estimation.output_error.shooting import intervals_of
from orbident.preprocessing.delays import delays
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def number_of_intervals(robot: Robot, recording: Recording) -> int:
    problem = momentum_problem(robot, recording, "unknown", lambda _: None)
    late = delays(robot, recording, problem.late)
    samples = problem.samples
    sensors = sensors_of(robot, recording, late, samples.speeds)
    return intervals_of(robot, samples, sensors).boundaries.size - 1


def test_rows_of_other_sensors_make_no_more_intervals():
    """With one for so few encoders' samples corrections would follow their noise."""
    recorded = clean_space(seed=1)
    whole = recorded.recording
    seldom = np.arange(whole.t.size) % 2 == 0
    of_joints = ("joint.", "wheel.")
    between = whole.with_columns(
        {
            name: np.where(seldom, x, np.nan)
            for name, x in whole.columns.items()
            if name.startswith(of_joints)
        }
    )
    columns = {name: x[seldom] for name, x in whole.columns.items()}
    alone = replace(whole, t=whole.t[seldom], columns=columns)
    one, other = (
        number_of_intervals(recorded.robot, each) for each in (alone, between)
    )
    assert abs(other - one) <= 0.1 * one


@pytest.mark.parametrize(("noise", "times"), [(2.5e-5, 1), (1e-2, 2)])
def test_noisy_encoders_make_shorter_intervals(noise: float, times: int, monkeypatch):
    """Where sensors of the base would show what corrections leave of their noise."""
    recorded = clean_space(seed=1, joints={"position": noise})
    here = number_of_intervals(recorded.robot, recorded.recording)
    monkeypatch.setattr(shooting, "PASSED_ON", np.inf)
    assert here >= times * number_of_intervals(recorded.robot, recorded.recording)
    if times == 1:
        assert here == number_of_intervals(recorded.robot, recorded.recording)
