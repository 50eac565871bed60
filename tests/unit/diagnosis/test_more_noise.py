"""Noise beyond what is declared."""

import numpy as np
import pytest
from cause_problems import fitted, problem_with

from orbident.diagnosis.noisier_sensors import lasting_errors, noisier_sensors


def test_declared_noise_is_not_suspected():
    assert [*noisier_sensors(problem_with())] == []


def test_encoders_that_are_noisier():
    random = np.random.default_rng(3)
    (found,) = noisier_sensors(
        problem_with(
            {
                f"joint.joint{k}.position": lambda q: (
                    q + 5e-4 * random.standard_normal(q.size)
                )
                for k in (1, 2, 3)
            }
        )
    )
    assert found.accepted
    assert "noise of the joints is 0.0005" in found.cause


@pytest.mark.slow
def test_a_bias_that_wanders():
    problem = problem_with(
        {"gyro.x": lambda w: w + 1e-4 * np.sin(np.arange(w.size) / 80)}
    )
    found = min(lasting_errors(problem, fitted(problem)), key=lambda one: one.misfit)
    assert "bias of the gyro drifts" in found.cause
