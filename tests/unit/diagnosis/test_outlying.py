"""Single samples that are off what their neighbours show."""

import numpy as np
from cause_problems import problem_with

from orbident.diagnosis.noisier_sensors import outlying, spikes

T = np.arange(300) * 0.1
NOISE = 1e-4 * np.random.default_rng(0).standard_normal(T.size)
OFF = np.arange(20, 280, 17)


def test_noise_on_a_motion_has_none():
    assert not outlying(T, np.sin(0.7 * T) + NOISE).any()


def test_spikes_that_are_smaller_than_the_steps_of_the_motion():
    """The joint moves by up to 70 mrad from one sample to the next."""
    x = np.sin(0.7 * T) + NOISE
    x[OFF] += 0.02 * np.sign(np.sin(OFF))
    np.testing.assert_array_equal(np.flatnonzero(outlying(T, x)), OFF)


def test_a_recording_without_its_spikes_is_accepted():
    def spoiled(q: np.ndarray) -> np.ndarray:
        q = q.copy()
        q[OFF] += 0.01
        return q

    (found,) = spikes(problem_with({"joint.joint2.position": spoiled}))
    assert found.accepted
    assert f"{OFF.size} samples of joint joint2" in found.cause
