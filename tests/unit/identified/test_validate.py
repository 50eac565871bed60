from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS, clean_space
from random_motions import random_motion

import orbident as oi
from orbident.estimation.result import Result
from orbident.identified.validate import Validation
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.report.write import validation
from orbident.robot.description import Friction
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import measure_truth, truth_of
from orbident.simulation.simulate import float_along


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


@pytest.mark.parametrize("seed", range(11, 14))
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


NOISE = 0.05
"""N m, of a sample of a torque."""


class Driven(NamedTuple):
    """Torques that a result predicts, beside those that another way gives."""

    scores: Validation
    truth: Validation
    """The prediction with the true robot in place of CAD's."""
    by_cad: dict[str, float]
    """Errors by CAD's dynamics at each true sample, as parts of the signals."""
    without_H: Validation
    """The prediction where the result has no definite `H+`."""
    noise: dict[str, float]
    """The noise of one sample of a torque sensor, as a part of the signal."""


@pytest.fixture(scope="module")
def driven() -> Driven:
    """Joints with friction of which the robot file knows nothing; CAD is 10 % off."""
    plant = oi.load_robot("paper-spatial")
    plant = replace(
        plant,
        sensors=declared_sensors(
            {"rate": RATE, **SENSORS, "torques": {"std": f"{NOISE} N m"}}
        ),
        friction=dict.fromkeys(plant.joint_names, Friction(0.5, 0.3, 0.02)),
    )
    anything = dict.fromkeys(plant.joint_names, np.inf)
    cad = replace(
        plant,
        theta=plant.theta * np.array([1.1, 1.1, 0.9, 1.1])[:, None],
        friction={},
        tolerances=replace(
            plant.tolerances,
            joint_viscous=anything,
            joint_coulomb=anything,
            joint_torque_offset=anything,
        ),
    )
    recordings = []
    for seed in (1, 2):
        motion = random_motion(plant, seed, 60.0, wheel_speed=100.0, start="turning")
        flown, own = float_along(plant, motion, RATE), motion.for_robot(plant)
        true = truth_of(plant, flown, own)
        recordings.append(measure_truth(plant, flown.t, true, seed))
    results = [oi.identify(robot, recordings[0]) for robot in (cad, plant)]
    scores, truth = (oi.validate(each, recordings[1]) for each in results)

    def refused(_: Result) -> Dynamics:
        raise oi.InputError("H+ is indefinite")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Result, "dynamics", refused)
        without_H = oi.validate(results[0], recordings[1])
    beta = oi.minimal_sets(cad).beta(cad.theta)
    model = reconstructed(cad, beta, np.zeros((beta.size, beta.size)))
    q, qd, qdd = own.at(flown.t)
    found = model.torques(q, qd, qdd, w=true.gyro, qd_rw=true.qd_rw)
    shown = true.shown_torques(plant)
    assert shown is not None
    names = [f"joint.{name}.torque" for name in plant.joint_names]
    size = shown.std(axis=0)
    off = np.sqrt(np.mean((found - shown) ** 2, axis=0)) / size
    return Driven(
        scores,
        truth,
        dict(zip(names, off, strict=True)),
        without_H,
        dict(zip(names, NOISE / size, strict=True)),
    )


@pytest.mark.slow
def test_torques_are_predicted(driven):
    """No worse than by the true robot, whose error is noise of sensors alone."""
    assert driven.scores.verdict == "explained"
    assert driven.scores.torques.keys() == driven.noise.keys()
    by_truth = driven.truth.torques_by_nominal
    for name, error in driven.scores.torques.items():
        # The parameters' own deviations are a small part of the noise.
        assert error == pytest.approx(by_truth[name], rel=0.05)
        assert driven.noise[name] < by_truth[name] < driven.by_cad[name] / 4


def test_torques_by_cad(driven):
    """The robot file errs as its own inverse dynamics does, sample by sample."""
    for name, error in driven.scores.torques_by_nominal.items():
        # Noise of sensors is in it as well: some 1 %, of 8 % and more.
        assert error == pytest.approx(driven.by_cad[name], rel=0.05)


def test_torques_are_shown(driven):
    scores = driven.scores
    assert any("joint.joint1.torque error" in line for line in scores.summary())
    assert scores.to_json()["torques"] == scores.torques
    section = validation({"file": "second.csv", **scores.to_json()})
    assert section.tables[-1].title == "Errors of torques at joints"


def test_without_a_definite_inertia_the_base_is_predicted(driven):
    assert not driven.without_H.torques
    assert driven.without_H.nrmse == driven.scores.nrmse


def test_without_torques_there_are_none(result):
    scores = oi.validate(result, clean_space(seed=11).recording)
    assert not scores.torques
