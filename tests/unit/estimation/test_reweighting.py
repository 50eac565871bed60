import numpy as np
from clean_recordings import clean_space
from edited_recordings import changed

import orbident as oi
from orbident.estimation.output_error import noise_scaling


def weights_of(result: oi.Result) -> list[str]:
    return [check.level for check in result.checks if check.name == "weights"]


def test_weights_that_still_change_are_said(monkeypatch):
    """One round is too few for a heavy-tailed gyro; weights that settle are silent."""
    flown = clean_space(seed=4, duration=40.0)
    random = np.random.default_rng(0)
    noise = {
        name: flown.recording.columns[name] + 2e-5 * random.standard_t(3, 401)
        for name in ("gyro.x", "gyro.y", "gyro.z")
    }
    recording = changed(flown.recording, noise)
    assert weights_of(oi.identify(flown.robot, flown.recording)) == []
    monkeypatch.setattr(noise_scaling, "ROUNDS", 1)
    assert weights_of(oi.identify(flown.robot, recording)) == ["with care"]
