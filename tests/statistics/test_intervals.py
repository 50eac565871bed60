"""Prediction intervals, against predictions with drawn parameters."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.prediction import predict, prediction_deviations
from orbident.identified.validate import validate
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

pytestmark = pytest.mark.long

DRAWS = 50
RELATIVE = 1e-3


@pytest.fixture(scope="module", params=["paper-spatial", "cepheus-like"])
def case(request) -> tuple[Result, Recording]:
    """A result whose parameters are off by 0.1 %, and what it is to predict."""
    robot = load_robot(request.param)
    start = "spun up" if robot.motion == "planar" else "turning"
    momentum = "at-rest" if robot.motion == "planar" else "unknown"
    recording, other = (
        simulate(robot, random_motion(robot, seed, 10.0, start=start))
        for seed in (0, 5)
    )
    result = identify(robot, recording, "least-squares", momentum)
    C = np.diag((RELATIVE * result.base.values) ** 2)
    return replace(result, base=replace(result.base, covariance=C)), other


def test_deviations_against_drawn_parameters(case):
    result, recording = case
    sets = minimal_sets(result.robot)
    random = np.random.default_rng(0)
    w, v_S = [], []
    for beta in random.multivariate_normal(
        result.base.values, result.base_covariance, DRAWS
    ):
        pi, phi = sets.pi_and_phi(beta)
        drawn = replace(
            result,
            pi=replace(result.pi, values=pi),
            phi=replace(result.phi, values=phi),
        )
        prediction = predict(drawn, recording)
        w.append(prediction.w)
        v_S.append(prediction.v_S)
    found = prediction_deviations(result, predict(result, recording))
    for ours, drawn in zip(found, (w, v_S), strict=True):
        expected = np.std(drawn, axis=0)
        # 50 draws tell a deviation to 10 %; the rule between samples, to less.
        size = np.sqrt(np.mean(expected**2))
        assert np.sqrt(np.mean(ours**2)) == pytest.approx(size, rel=0.2)
        assert np.abs(ours - expected).max() < size


def test_true_motion_is_inside(case):
    """Without noise the true parameters are inside, and so is what they do."""
    result, recording = case
    scores = validate(result, recording)
    assert scores.inside == {"gyro": 1.0, "velocity": 1.0}
    assert min(scores.std.values()) > 0
    known = np.full_like(result.base_covariance, np.nan)
    lost = replace(result, base=replace(result.base, covariance=known))
    unknown = validate(lost, recording).to_json()
    assert unknown["inside_95"] == {"gyro": None, "velocity": None}
    assert unknown["predicted_std"] == {"gyro": None, "velocity": None}
