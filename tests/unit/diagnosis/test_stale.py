"""Samples that repeat the one before."""

import numpy as np
from cause_problems import clean
from edited_recordings import changed

from orbident.diagnosis.stale import stale


def words(**columns: np.ndarray) -> list[str]:
    new = {name.replace("__", "."): column for name, column in columns.items()}
    return [*stale(clean().robot, changed(clean().recording, new))]


def test_noise_never_repeats():
    assert words() == []


def test_a_sensor_that_is_held():
    x = clean().recording.columns["joint.joint2.position"]
    assert words(joint__joint2__position=np.repeat(x[::2], 2)[: x.size])[0].startswith(
        "samples repeat the one before: joint joint2"
    )


def test_a_sensor_that_is_stuck_for_a_while():
    x = clean().recording.columns["joint.joint2.position"].copy()
    x[100:120] = x[100]
    (found,) = words(joint__joint2__position=x)
    assert "joint joint2 is stuck: the same value from t = 10" in found
