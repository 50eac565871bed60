"""Exit status 1: it ran, and says why not to trust the numbers, and what to do."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_motions import Start, random_motion
from running import Orbident, missing, worst_error, written

from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.trajectories.trajectory_file import save_trajectory


def identified(
    orbident: Orbident, robot: object, recording: object, momentum: str = "unknown"
) -> tuple[dict[str, Any], str]:
    """The rejected result, and all that was said about it on standard error."""
    ran = orbident(
        *("identify", robot, recording),
        *("--initial-momentum", momentum, "--json", "-", "--all"),
    )
    assert ran.status == 1
    result = ran.json
    assert result["status"] == "rejected"
    assert ran.err.count("\n") == len(result["warnings"])
    for warning in result["warnings"]:
        assert f"orbident: warning: {warning}\n" in ran.err
    return result, ran.err


def check_no_scale(orbident: Orbident, result: dict[str, Any], robot: object) -> None:
    """All is null; the linear `phi`, which needs no scale, is kept for a look."""
    true = orbident("inspect", robot, "--json", "-").done().json
    assert result["mass"]["value"] is None
    assert result["mass"]["std"] is None
    assert missing(result["pi"]) == result["pi"]["names"]
    assert missing(result["base"]) == result["base"]["names"]
    assert missing(result["phi"]) == result["phi"]["names"]
    kept = result["diagnostics"]
    assert missing(kept["pi"]) == kept["pi"]["names"]
    assert missing(kept["phi"]) == []
    assert worst_error(kept["phi"], true["phi"]) < 1e-9


@pytest.mark.parametrize("momentum", ["unknown", "at-rest", "first-sample"])
def test_no_wheels(orbident: Orbident, momentum: str):
    Path("bare.urdf").write_text(load_robot("paper-spatial").urdf)
    save_trajectory(random_motion(load_robot("bare.urdf")), "m.yaml")
    orbident("simulate", "bare.urdf", "m.yaml", "-o", "r.csv", "--quiet").done()
    result, said = identified(orbident, "bare.urdf", "r.csv", momentum)
    check_no_scale(orbident, result, "bare.urdf")
    assert "pi has no scale" in said
    assert "declare its wheels" in said


@pytest.mark.parametrize("momentum", ["unknown", "at-rest", "first-sample"])
@pytest.mark.parametrize("start", ["turning", "at rest"])
def test_wheels_that_never_turn(orbident: Orbident, start: Start, momentum: str):
    robot = load_robot("paper-spatial")
    written(simulate(robot, random_motion(robot, wheel_speed=0, start=start)), "r.csv")
    result, said = identified(orbident, "paper-spatial", "r.csv", momentum)
    check_no_scale(orbident, result, "paper-spatial")
    assert "pi has no scale" in said
    assert "spin" in said


@pytest.mark.parametrize("momentum", ["unknown", "first-sample"])
def test_constant_wheel_in_the_plane(
    orbident: Orbident, table_run: Recording, momentum: str
):
    written(table_run, "r.csv")
    result, said = identified(orbident, "cepheus-like", "r.csv", momentum)
    check_no_scale(orbident, result, "cepheus-like")
    assert "--initial-momentum at-rest" in said
    assert "change the wheel speed" in said


def test_a_robot_that_was_not_at_rest(orbident: Orbident, flight: Recording):
    """In space a wrong assumption shows: freeing the momentum explains far more."""
    written(flight, "r.csv")
    result, said = identified(orbident, "paper-spatial", "r.csv", "at-rest")
    check_no_scale(orbident, result, "paper-spatial")
    assert "not at rest as assumed" in said
    assert "--initial-momentum unknown" in said


def test_a_table_robot_that_was_not_at_rest(orbident: Orbident, table_run: Recording):
    """In the plane the data cannot show it: the mass is half, and a warning says so."""
    columns = {name: 0.5 * table_run.columns[name] for name in ("wheel.rw.speed",)}
    written(table_run, "r.csv", replace=columns)
    ran = orbident(
        *("identify", "cepheus-like", "r.csv", "--initial-momentum", "at-rest")
    )
    assert ran.status == 0
    assert "was the robot at rest before the wheels spun up?" in ran.err


def test_without_velocity_and_position(orbident: Orbident, flight: Recording):
    """Momentum alone shows `pi`."""
    written(flight, "r.csv", drop=["velocity", "position"])
    true = orbident("inspect", "paper-spatial", "--json", "-").done().json
    ran = orbident("identify", "paper-spatial", "r.csv", "--json", "-")
    assert ran.status == 0
    result = ran.json
    assert (result["status"], result["level"]) == ("ok", "with care")
    assert result["mass"]["value"] is None
    for name in ("phi", "base"):
        assert missing(result[name]) == result[name]["names"]
    assert missing(result["pi"]) == []
    assert worst_error(result["pi"], true["pi"]) < 1e-7
    assert "velocity.x" in ran.err
    assert "position.x" in ran.err
    assert result["origins"]["velocity"] == "missing"


def test_other_methods_need_positions(orbident: Orbident, flight: Recording):
    written(flight, "r.csv", drop=["velocity", "position"])
    ran = orbident("identify", "paper-spatial", "r.csv", "--method", "structured")
    assert ran.status == 1
    assert "identify pi alone by maximum-likelihood" in ran.err


def test_pi_alone_predicts_how_the_base_turns(orbident: Orbident, flight: Recording):
    written(flight, "r.csv", drop=["velocity", "position"])
    orbident("identify", "paper-spatial", "r.csv", "-o", "run", "--quiet")
    written(flight, "s.csv")
    said = orbident("validate", "run", "s.csv").done().out
    assert "\ngyro      error" in said
    assert "velocity  is not scored" in said
    orbident("export", "run", "-o", "x.urdf").refused("is pi alone", "record position")


def test_the_reason_is_said_even_when_quiet(orbident: Orbident, flight: Recording):
    written(flight, "r.csv", drop=["velocity", "position"])
    arguments = ("identify", "paper-spatial", "r.csv", "--method", "recursive")
    ran = orbident(*arguments, "--quiet")
    assert ran.status == 1
    assert ran.out == ""
    assert "orbident: warning: phi and the mass are not determined" in ran.err
    shown = orbident(*arguments).out
    head, reason, *rest = shown.split("\n")
    assert head.startswith("paper-spatial: refused")
    assert "phi and the mass are not determined" in reason
    # No numbers follow.
    assert rest == [""]


def test_wrong_signals_give_no_mass(orbident: Orbident, flight: Recording):
    """One for all: `tests/contract` and `tests/mistakes` have the others."""
    wrong = {"wheel.rw_x.speed": -flight.columns["wheel.rw_x.speed"]}
    written(flight, "r.csv", replace=wrong)
    result, said = identified(orbident, "paper-spatial", "r.csv")
    assert result["mass"]["value"] is None
    assert "the sign of wheel rw_x" in said


def test_a_joint_in_degrees_is_beyond_its_stops(orbident: Orbident, flight: Recording):
    name = "joint.joint1.position"
    degrees = {name: np.degrees(flight.columns[name])}
    written(flight, "r.csv", replace=degrees)
    orbident("identify", "paper-spatial", "r.csv").refused(
        f"r.csv: column '{name}'",
        "beyond the joint's range -4 to 4",
        "degrees: give rad",
    )


def test_velocity_with_the_wrong_sign(orbident: Orbident, flight: Recording):
    """Four forms of Eq. 32 say 1110 kg, two 20568 kg, one -969 kg."""
    wrong = {f"velocity.{k}": -flight.columns[f"velocity.{k}"] for k in "xyz"}
    written(flight, "r.csv", replace=wrong)
    result, said = identified(orbident, "paper-spatial", "r.csv")
    assert result["mass"]["value"] is None
    assert "the signs of the velocity differ" in said


def test_attitude_the_other_way_round(orbident: Orbident, flight: Recording):
    """Inertial axes in base axes: that is the cause, and is said first."""
    wrong = {f"attitude.{k}": -flight.columns[f"attitude.{k}"] for k in "xyz"}
    written(flight, "r.csv", replace=wrong)
    result, said = identified(orbident, "paper-spatial", "r.csv")
    assert missing(result["pi"]) == result["pi"]["names"]
    assert missing(result["phi"]) == result["phi"]["names"]
    assert "the quaternion of the attitude is the inverse, from inertial" in said


@pytest.mark.slow
def test_a_refusal_is_short(orbident: Orbident, flight: Recording):
    """Its cause, the first check that failed, and where the others are."""
    wrong = {"gyro.x": 1.05 * flight.columns["gyro.x"]}
    written(flight, "r.csv", replace=wrong, rows=slice(300))
    ran = orbident("identify", "paper-spatial", "r.csv")
    lines = [*ran.err.splitlines(), *ran.out.splitlines()]
    assert len(lines) <= 8
    assert "gyro" in lines[0]
    whole = orbident("identify", "paper-spatial", "r.csv", "--all")
    assert len(whole.err.splitlines()) > 2
    unsearched = orbident("identify", "paper-spatial", "r.csv", "--causes", "none")
    assert unsearched.status == 1
    assert len(unsearched.err.splitlines()) < len(whole.err.splitlines())
