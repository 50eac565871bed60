from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import clean_space

import orbident as oi


@pytest.fixture(scope="module")
def flown():
    return clean_space(seed=1)


@pytest.fixture(scope="module")
def result(flown):
    return oi.identify(flown.robot, flown.recording)


def moved(result: oi.Result, deviations: float) -> oi.Result:
    """The mass and the last inertia wrong by so many of their deviations."""
    beta = result.base.values.copy()
    beta[[0, -1]] += deviations * result.base.std[[0, -1]]
    pi, phi = oi.minimal_sets(result.robot).pi_and_phi(beta)
    return replace(
        result,
        base=replace(result.base, values=beta),
        pi=replace(result.pi, values=pi),
        phi=replace(result.phi, values=phi),
    )


@pytest.mark.parametrize("seed", range(11, 17))
def test_a_right_result_explains_a_fresh_recording(result, seed):
    scores = oi.validate(result, clean_space(seed=seed).recording)
    assert scores.verdict == "explained", scores.reason
    # The sensors' noise is nearly all of the error.
    for name in ("gyro", "velocity"):
        assert scores.noise[name] == pytest.approx(scores.rms[name], rel=0.05)


@pytest.mark.parametrize("seed", range(11, 14))
def test_parameters_that_are_wrong_do_not(result, seed):
    scores = oi.validate(moved(result, 8.0), clean_space(seed=seed).recording)
    assert scores.verdict == "not explained"
    assert scores.p_value < 1e-4
    assert "combined standard deviations" in scores.reason


def test_a_recording_that_is_wrong_is_no_proof(flown, result):
    columns = dict(flown.recording.columns)
    columns["gyro.x"] = -columns["gyro.x"]
    scores = oi.validate(result, oi.Recording(flown.recording.t, columns))
    assert scores.verdict == "not explained"
    assert "the recording is refused" in scores.reason
    assert np.isnan(scores.chi2)
