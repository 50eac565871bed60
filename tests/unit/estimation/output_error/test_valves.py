"""Valves that are late, short, on one tank, or dead: against a flight by plain sums."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from valved_satellite import Truth, base_of, flown, satellite, with_dead

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.validate import validate
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot, write_robot

slow = partial(pytest.param, marks=pytest.mark.slow)
KNOWN = "known: {mass: 23.09 +- 0.01 kg}\n"
FLOOR = f"""{KNOWN}
disturbances: {{torque_walk: free, force_walk: free, pull: 2 mm/s^2}}
"""


def drawn(seed: int, **more: object) -> Truth:
    """Gains of a tenth, a coupling of 5 % a valve, a table that is not level."""
    random = np.random.default_rng(1000 + seed)
    return Truth(
        gains=0.1 * random.standard_normal(8),
        coupling=float(0.05 * random.standard_normal()),
        tilt=tuple(1e-3 * random.standard_normal(2)),
        **more,  # pyright: ignore[reportArgumentType]
    )


def scores(result: Result, truth: Truth) -> dict[str, float]:
    """What was found less what is true, in deviations."""
    base = zip(("M", "mx", "my", "I"), result.base.values - base_of(truth), strict=True)
    z = {
        name: float(off / std)
        for (name, off), std in zip(base, result.base.std, strict=True)
    }
    for name in ("clock", "pulse", "coupling"):
        fit = result.calibration[f"thrusters.{name}"]
        z[name] = (fit.value - getattr(truth, name)) / fit.std
    return z


def dead_ones(result: Result) -> list[str]:
    """The thrusters that are said to give none."""
    named = [each for each in result.checks if "gives no thrust" in each.reason]
    return [each.name.split(".")[1] for each in named]


@pytest.mark.parametrize(
    ("seed", "known"),
    [
        (1, KNOWN),
        slow(1, ""),
        # Another valve, alike.
        *(pytest.param(6, known, marks=pytest.mark.long) for known in ("", KNOWN)),
    ],
)
def test_a_dead_valve_is_named_and_the_rest_identified(tmp_path, seed, known):
    truth = with_dead(drawn(seed), 1 + seed % 8)
    result = identify(satellite(tmp_path, more=known), flown(truth, seed))
    assert result.status == "ok", result.warnings
    assert dead_ones(result) == [f"t{1 + seed % 8}"]
    z = scores(result, truth)
    assert max(map(abs, z.values())) < 4, z
    # Without scales the mass is as sure as the thrust of a bench: a fifth.
    expected = 0.01 if known else 0.2 * truth.mass
    assert result.mass.std == pytest.approx(expected, rel=0.3)


@pytest.mark.slow
def test_nothing_is_named_where_all_valves_work(tmp_path):
    truth = drawn(3)
    result = identify(satellite(tmp_path), flown(truth, 3))
    assert result.status == "ok", result.warnings
    assert not dead_ones(result)
    assert all(check.level == "trust" for check in result.checks), result.warnings


@pytest.mark.slow
def test_valves_that_are_said_to_act_at_once(tmp_path):
    """Refused; the time is what would explain it."""
    robot = satellite(tmp_path)
    exact = replace(robot.tolerances, thruster_clock=0.0, thruster_pulse=0.0)
    seen = flown(drawn(1), 1, duration=30.0)
    result = identify(replace(robot, tolerances=exact), seen)
    assert result.status == "rejected"


@pytest.mark.slow
def test_a_result_predicts_poses(tmp_path):
    """As well as they are measured, and far better than the robot file's numbers."""
    truth = drawn(2)
    result = identify(satellite(tmp_path, more=KNOWN), flown(truth, 2))
    level = replace(truth, tilt=(0.0, 0.0))
    found = validate(result, flown(level, 3))
    assert found.verdict == "explained"
    assert all(np.isnan(each) for each in found.rms.values())
    # The noise of `flown`, and what parameters and valves are off.
    seen = flown(level, 3, std=(0.0, 0.0))
    for name, std in {"position": 3e-4, "attitude": 5e-4}.items():
        size = spread(seen, name)
        assert found.pose[name] * size < 1.3 * std
        assert found.pose_by_nominal[name] > 3 * found.pose[name]
    assert "error over 5 s" in str(found)


def spread(recording: Recording, name: str) -> float:
    """RMS about means of windows of five seconds, m (an axis) or rad."""
    if name == "position":
        x = recording.vector(name)[:, :2]
    else:
        x = 2 * np.unwrap(
            np.arctan2(recording.column("attitude.z"), recording.column("attitude.w")),
            period=np.pi,
        )
    parts = np.array_split(x, 12)
    return float(np.sqrt(np.mean([np.mean((p - p.mean(axis=0)) ** 2) for p in parts])))


@pytest.mark.slow
def test_a_floor_that_pushes_at_random(tmp_path):
    """Densities are found, and what they hide is in the deviations."""
    walks = (3e-3, 2e-2)
    truth = with_dead(drawn(5, walks=walks), 6)
    result = identify(satellite(tmp_path, more=FLOOR), flown(truth, 5))
    assert result.status == "ok", result.warnings
    assert dead_ones(result) == ["t6"]
    z = scores(result, truth)
    assert max(map(abs, z.values())) < 4, z
    for name, true in zip(("torque_walk", "force_walk"), walks, strict=True):
        found = result.disturbances[name]
        # That of a torque is by the nominal inertia, which is a tenth too small, and
        # that of a force by a mass that is an eighth too small.
        assert found.value == pytest.approx(true, rel=0.35)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [pytest.param(2, marks=pytest.mark.long), 6])
def test_a_floor_that_does_not_push(tmp_path, seed):
    """Walks of torque and force are free, and there are none: any that is too small to
    see is as likely. One so small that rounding is larger had spoiled the fit."""
    truth = Truth(clock=0.1, pulse=0.03)
    result = identify(satellite(tmp_path, more=FLOOR), flown(truth, seed))
    assert (result.status, result.warnings) == ("ok", ())
    assert max(map(abs, scores(result, truth).values())) < 4
    walk = result.disturbances["force_walk"]
    assert 1e-9 < walk.value < walk.std


@pytest.mark.slow
def test_a_cm_from_a_balance(tmp_path):
    truth = drawn(2)
    more = "known: {com: {x: 5.6 +- 0.1 mm, y: 0.8 +- 0.1 mm}}\n"
    result = identify(satellite(tmp_path, more=more), flown(truth, 2))
    x, y = result.base.values[1:3] / result.base.values[0]
    assert x == pytest.approx(truth.com[0], abs=4e-4)
    assert y == pytest.approx(truth.com[1], abs=4e-4)


def test_what_is_known_is_written_with_the_robot(tmp_path):
    robot = satellite(tmp_path, more=KNOWN)
    assert robot.known.mass == (23.09, 0.01)
    again = load_robot(write_robot(robot, tmp_path / "written"))
    assert again.known == robot.known


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ("{mass: 23 kg}", "give a value and its deviation"),
        ("{mass: 23 +- 0 kg}", "give a deviation above zero"),
        ("{weight: 23 +- 1 kg}", "unknown key 'weight'"),
        ("{mass: 23 +- 1 mm}", "unknown unit 'mm'"),
    ],
)
def test_what_is_known_is_checked(tmp_path: Path, known: str, words: str):
    with pytest.raises(InputError, match=words):
        satellite(tmp_path, more=f"known: {known}\n")
