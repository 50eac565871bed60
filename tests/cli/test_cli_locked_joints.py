"""A joint that never moved costs only the parameters that it alone reveals."""

from typing import Any

import numpy as np
import pytest
from random_motions import random_motion
from running import LINEAR, Orbident, missing, worst_error, written

from orbident.estimation.identify import Method
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

EXACT = 1e-9
"""Relative error without noise: rounding."""
ENCODER = 1e-5
"""Noise of the locked joints' encoders, rad."""
NOISY = 1e-6
"""Relative error with it: an angle 1e-5 / sqrt(801) rad off, times a few."""


def locked(at: dict[str, float]) -> Recording:
    robot = load_robot("paper-spatial")
    return simulate(robot, random_motion(robot, start_at=at, still=tuple(at)))


def check(
    orbident: Orbident,
    recording: Recording,
    joints: list[str],
    tolerance: float,
    method: Method = "least-squares",
) -> dict[str, Any]:
    """Identify; what is null is named with the joint's name, all else is right."""
    written(recording, "r.csv")
    true = orbident("inspect", "paper-spatial", "--json", "-").done().json
    ran = orbident(
        *("identify", "paper-spatial", "r.csv", "--method", method, "--json", "-")
    )
    result = ran.json
    null = missing(result["pi"]) + missing(result["phi"])
    assert null
    lost = [words for words in result["warnings"] if "not determined" in words]
    for sentence in lost:
        for joint in joints:
            assert f"'{joint}'" in sentence
    assert "never moved" in lost[0]
    named = " ".join(lost).replace(",", "").split()
    assert [word for word in named if word.startswith(("pi_", "phi_"))] == null
    for name in ("pi", "phi", "base"):
        assert worst_error(result[name], true[name]) < tolerance, name
    assert result["status"] == "ok"
    assert ran.status == 0
    assert abs(result["mass"]["value"] / true["mass"] - 1) < tolerance
    return result


@pytest.mark.parametrize(
    "at",
    [
        {"joint1": 0.0},
        {"joint2": 0.0},
        {"joint1": 0.4},
        {"joint2": -0.4},
        {"joint3": 0.4},
        {"joint1": 0.0, "joint2": 0.0},
        {"joint1": 0.4, "joint3": 0.5},
    ],
    ids=str,
)
def test_locked(orbident: Orbident, at: dict[str, float]):
    check(orbident, locked(at), list(at), EXACT)


@pytest.mark.parametrize("method", ["maximum-likelihood", "structured"])
def test_locked_by_the_other_methods(orbident: Orbident, method: Method):
    at = {"joint1": 0.4}
    check(orbident, locked(at), list(at), EXACT, method)


@pytest.mark.parametrize(
    "at",
    [
        {"joint3": 0.0},
        {"joint1": 0.4, "joint2": -0.3},
        {"joint2": 0.3, "joint3": 0.5},
    ],
    ids=str,
)
def test_locked_with_mass_in_sums_only(orbident: Orbident, at: dict[str, float]):
    """With joint 3 at zero, links 2 and 3 are one body with an axis in common: only
    pi_13 + pi_14 and phi_4 + phi_5 show, and M = (pi_13 + pi_14)/(phi_1 (phi_4 +
    phi_5))."""
    written(locked(at), "r.csv")
    ran = orbident("identify", "paper-spatial", "r.csv", *LINEAR, "--json", "-")
    result = ran.json
    assert result["mass"]["value"] == pytest.approx(1110.0, rel=EXACT)


@pytest.mark.parametrize(
    ("at", "rates"),
    [({"joint1": 0.0}, "derived"), ({"joint1": 0.4, "joint3": 0.5}, "measured")],
    ids=str,
)
def test_locked_with_encoder_noise(
    orbident: Orbident, at: dict[str, float], rates: str
):
    """Noise must not pass for motion, and so determine what it cannot."""
    recording = locked(at)
    random = np.random.default_rng(0)
    columns = dict(recording.columns)
    for joint in at:
        for what in ("position", "velocity"):
            noise = ENCODER * random.standard_normal(recording.t.size)
            columns[f"joint.{joint}.{what}"] = columns[f"joint.{joint}.{what}"] + noise
        if rates == "derived":
            del columns[f"joint.{joint}.velocity"]
    noisy = check(orbident, Recording(recording.t, columns), list(at), NOISY)
    exact = check(orbident, recording, list(at), EXACT)
    for name in ("pi", "phi"):
        assert set(missing(exact[name])) <= set(missing(noisy[name]))


def test_every_joint_locked(orbident: Orbident):
    written(locked({"joint1": 0.1, "joint2": 0.2, "joint3": 0.3}), "r.csv")
    ran = orbident("identify", "paper-spatial", "r.csv", "--json", "-")
    assert ran.status == 1
    assert ran.json["status"] == "rejected"
    assert ran.json["mass"]["value"] is None
    assert "'joint1', 'joint2', 'joint3' never moved" in ran.err
