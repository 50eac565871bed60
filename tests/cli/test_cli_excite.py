"""`orbident excite`."""

import json
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from swinging_satellite import swinging_satellite
from urdf_pieces import ARM, robot_file
from valved_satellite import satellite

from orbident.cli import excite_tables
from orbident.errors import InputError
from orbident.excitation.floating import was_at_rest
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import Trajectory
from orbident.trajectories.trajectory_file import load_trajectory


def test_like_the_paper(orbident):
    """A file that loads, the paper's figure beside ours, and the proven margins."""
    ran = orbident(
        "excite", "cepheus-like", "--like-paper", "--starts", 2, "-o", "made.yaml"
    ).done()
    assert "paper quotes a condition number of 153" in ran.out
    assert "proven for all times" in ran.out
    assert "--initial-momentum at-rest" in ran.out
    made = load_trajectory("made.yaml")
    assert made.duration == 20.0
    assert made.initial.wheel_speed == {"rw": -170.0}
    assert made.design is not None
    assert made.design["value"] < 60
    for joint in made.design["proven"]["joints"].values():
        assert joint["velocity"] <= joint["velocity_limit"]


def test_an_interrupted_search_says_so(orbident, monkeypatch):
    """Ctrl-C after the first start: the best is written, and the status tells."""

    @contextmanager
    def interrupting(_):
        def report(fraction, words):
            raise KeyboardInterrupt

        yield report

    monkeypatch.setattr("orbident.cli.excite.progress", interrupting)
    ran = orbident("excite", "cepheus-like", "--like-paper", "-o", "made.yaml")
    assert ran.status == 130
    assert "interrupted: the trajectory that was written is the best" in ran.err
    made = load_trajectory("made.yaml").design
    assert made is not None
    assert made["starts"] == 1


def test_a_score_that_falls_from_search_to_truth_is_told():
    def design(value, searched):
        none, still = np.zeros((0, 1)), np.zeros((0, 3))
        motion = Trajectory(1.0, (), none, none, still, still)
        return replace(motion, design={"value": value, "searched_value": searched})

    assert not excite_tables.design_doubts(design(100.0, 99.0), False)
    (sentence,) = excite_tables.design_doubts(design(832.0, 81.4), False)
    assert "81.4" in sentence
    assert "832" in sentence


def test_half_a_turn_is_no_limit_of_a_turn():
    """As far apart as two attitudes can be, which a base that goes on turning meets."""
    assert excite_tables._turn(1.25) == "turn 1.25 rad"
    assert (
        excite_tables._turn(np.pi) == excite_tables._turn(None) == "turn of any angle"
    )


def test_json_is_the_design(orbident):
    ran = orbident(
        *("excite", "cepheus-like", "--starts", 1, "--duration", 15),
        *("--harmonics", 2, "--objective", "d", "-o", "made.yaml", "--json", "-"),
    ).done()
    assert ran.json["objective"] == "d"
    assert ran.json["duration"] == 15.0
    assert ran.json["trajectory"] == "made.yaml"
    made = load_trajectory("made.yaml")
    assert made.a.shape == (2, 2)
    assert made.design is not None
    assert ran.json["value"] == made.design["value"]


def test_like_another_trajectory(orbident, table_5):
    orbident(
        *("excite", "cepheus-like", "--like", table_5, "--starts", 1),
        *("--limit", "acceleration=0.5", "-o", "made.yaml", "--quiet"),
    ).done()
    made, like = load_trajectory("made.yaml"), load_trajectory(table_5)
    assert made.duration == like.duration
    assert made.initial.wheel_speed == like.initial.wheel_speed
    assert made.design is not None
    for joint in made.design["proven"]["joints"].values():
        assert joint["acceleration"] <= 0.5


def test_compare(orbident, table_5):
    ran = orbident(
        *("excite", "cepheus-like", "--like-paper", "--json", "-"),
        *("--compare", table_5, "--compare", table_5),
    ).done()
    first, second = ran.json["trajectories"]
    assert first == second
    assert first["scores"]["cond_Y"] == pytest.approx(86, abs=0.5)
    assert set(first["scores"]) == set(excite_tables.CRITERIA)
    assert ran.json["parameters"][0] == "M"
    assert len(first["std"]) == len(ran.json["parameters"]) == 1 + 8 + 4
    words = orbident("excite", "cepheus-like", "--compare", table_5).done().out
    assert "predicted standard deviations" in words


@pytest.mark.slow
def test_how_large_a_table_a_motion_needs(orbident, table_5):
    ran = orbident(
        *("excite", "cepheus-like", "-o", "made.yaml", "--starts", 1),
        *("--limit", "table=1x1.1", "--duration", 10),
    ).done()
    assert "m of a table" in ran.out
    made = load_trajectory("made.yaml").design
    assert made is not None
    width, depth, radius = made["proven"]["table"]
    assert width < 1.0
    assert depth < 1.1
    inspected = orbident("inspect", "cepheus-like", "--trajectory", table_5).done()
    assert "needs 1.298 x 1.298 m of a table" in inspected.out
    compared = orbident(
        *("excite", "cepheus-like", "--compare", "made.yaml", "--json", "-"),
    ).done()
    assert compared.json["trajectories"][0]["table"] == [width, depth, radius]


def test_what_a_compared_motion_exceeds(orbident, table_5):
    compare = ("excite", "cepheus-like", "--compare", table_5)
    limits = ("--limit", "table=0.6", "--limit", "wheel_speed=210")
    words = "table5.yaml: table radius: up to 0.649"
    ran = orbident(*compare, *limits, "--json", "out.json")
    assert ran.status == 0
    assert words in ran.err
    (found,) = json.loads(Path("out.json").read_text())["trajectories"]
    assert [each for each in found["exceeded"] if words in each]
    assert "round table, radius in m" in ran.out
    ran = orbident(*compare, "--limit", "table=1.5x1.4", "--json", "-").done()
    assert ran.json["trajectories"][0]["exceeded"] == []
    orbident(*compare, "--recordings", 3).refused("--recordings 3", "leave")


def test_motions_of_several_recordings(orbident):
    """One name stands for all of them: they are written, and scored together."""
    made = ("excite", "cepheus-like", "--recordings", 2, "-o", "two.yaml")
    fast = ("--starts", 1, "--duration", 10, "--harmonics", 3)
    ran = orbident(*made, *fast, "--json", "two.json").done()
    assert "recording 2 of 2; scores are of all until here together" in ran.out
    first, second = json.loads(Path("two.json").read_text())["recordings"]
    assert [each["trajectory"] for each in (first, second)] == [
        "two-1.yaml",
        "two-2.yaml",
    ]
    compared = orbident(
        *("excite", "cepheus-like", "--compare", "two.yaml", "--json", "-")
    ).done()
    (together,) = compared.json["trajectories"]
    assert together["source"] == "two-1.yaml to two-2.yaml"
    assert together["scores"]["d"] == pytest.approx(second["value"], rel=1e-9)
    orbident(*made, *fast).refused("two-1.yaml", "exists already")
    text = Path("two-1.yaml").read_text()
    for wrong in ("recordings: 1", "recordings: [2]", "recordings: 1000000000"):
        Path("two-1.yaml").write_text(text.replace("recordings: 2", wrong))
        orbident("excite", "cepheus-like", "--compare", "two.yaml").refused(
            "two.yaml", "not one of several"
        )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["cepheus-like"], ["-o is missing"]),
        (["cepheus-like", "-o", "no/made.yaml"], ["'no' does not exist"]),
        (
            ["dual-arm", "--like-paper", "-o", "made.yaml"],
            ["dual-arm", "no trajectory"],
        ),
        (["cepheus-like", "-o", "made.yaml", "--duration", 0], ["duration: found 0"]),
        (["cepheus-like", "-o", "made.yaml", "--harmonics", 0], ["harmonics: found 0"]),
        (["cepheus-like", "-o", "made.yaml", "--starts", 0], ["starts: found 0"]),
        (["cepheus-like", "-o", "made.yaml", "--limit", "speed=1"], ["'speed=1'"]),
        (
            ["cepheus-like", "-o", "made.yaml", "--limit", "base_rate=x"],
            ["base_rate=x"],
        ),
        (["cepheus-like", "-o", "made.yaml", "--limit", "base_rate=0"], ["base rate"]),
        (["cepheus-like", "-o", "made.yaml", "--limit", "table="], ["WIDTHxDEPTH"]),
        (["cepheus-like", "-o", "m.yaml", "--limit", "table=1x1x1"], ["table=RADIUS"]),
        (["cepheus-like", "-o", "m.yaml", "--limit", "table=-1"], ["table radius"]),
        pytest.param(
            ["cepheus-like", "-o", "m.yaml", "--limit", "table=0.2"],
            ["even the gentlest joint motion exceeds the limit of table radius, by"],
            # `tests/unit/excitation` has that of its width.
            marks=pytest.mark.long,
        ),
        (["cepheus-like", "-o", "made.yaml", "--limit", "table=1xm"], ["'table=1xm'"]),
        (["cepheus-like", "-o", "made.yaml", "--limit", "table=1x0"], ["table depth"]),
        (["paper-spatial", "-o", "made.yaml", "--limit", "table=1x1"], ["in space"]),
        (["cepheus-like", "--compare", "missing.yaml"], ["missing.yaml"]),
        (
            ["paper-spatial", "--like-paper", "-o", "m.yaml", "--wheel-speed", 60],
            ["--like-paper give the initial state already"],
        ),
        (["cepheus-like", "-o", "m.yaml", "--wheel-speed", "inf"], ["finite"]),
        (
            ["cepheus-like", "-o", "m.yaml", "--initial-momentum", "some"],
            ["--initial-momentum", "at-rest"],
        ),
        (["cepheus-like", "-o", "m.yaml", "--recordings", 0], ["--recordings"]),
        (["cepheus-like", "-o", "m.yaml", "--recordings", 1e9], ["--recordings"]),
        (["cepheus-like", "-o", "m.yaml", "--recordings", 101], ["--recordings"]),
        (
            ["cepheus-like", "--like-paper", "-o", "m.yaml", "--recordings", 2],
            ["condition numbers do not add up"],
        ),
        (["paper-spatial", "--compare", "table5.yaml"], ["joint3"]),
    ],
)
def test_wrong_input(orbident, table_5, arguments, words):
    orbident("excite", *arguments).refused(*words)


def test_how_it_starts_is_said(orbident):
    """All at rest before the wheels spun up to 60 rad/s, in space too."""
    start = ("--wheel-speed", 60, "--initial-momentum", "at-rest")
    orbident(
        *("excite", "paper-spatial", *start, "--duration", 20, "--starts", 1),
        *("--harmonics", 2, "-o", "made.yaml"),
    ).done()
    robot, made = load_robot("paper-spatial"), load_trajectory("made.yaml")
    assert made.initial.wheel_speed == dict.fromkeys(robot.wheel_names, 60.0)
    assert was_at_rest(robot, made.initial, made.start)


def test_a_duration_too_short_says_by_how_much(orbident, table_5):
    """2 rad in 2 s, where no more than 0.7 rad/s is allowed."""
    text = table_5.read_text().replace("end: {position: 0.0", "end: {position: 1.0", 1)
    assert "1.0, velocity" in text
    Path("far.yaml").write_text(text)
    orbident(
        *("excite", "cepheus-like", "--like", "far.yaml", "--duration", 1.5),
        *("-o", "made.yaml"),
    ).refused("joint1", "velocity", "0.7", "%")


def test_a_motion_that_shows_too_little_is_not_trusted(orbident):
    """One harmonic in 5 s: eight parameters, and hardly any motion."""
    ran = orbident(
        *("excite", "cepheus-like", "--objective", "cond", "--starts", 1),
        *("--duration", 0.02, "--harmonics", 1, "-o", "made.yaml"),
    )
    assert ran.status == 1
    assert "does not determine all parameters" in ran.err


LIMITS = "limits: {joint1: {velocity: 1}, joint2: {velocity: 1}}\n"
WHEEL = "wheels: [{name: rw, axis: [1, 0, 0], inertia: 0.1}]\n"
GYRO = (
    "sensors: {gyro: {angle_random_walk: 1e-6}, joints: {position: 1e-5}, "
    "wheels: {position: 1e-5}}\n"
)
POSITION = "position: {std: 1e-4}, "


def test_what_instruments_do_not_show_is_named(orbident):
    """And not that more harmonics would help."""
    path = robot_file(Path(), ARM, LIMITS + WHEEL + GYRO)
    ran = orbident("excite", path, "--duration", 10, "--starts", 1, "-o", "m.yaml")
    assert "needs position or accelerometer" in ran.err
    assert "harmonics" not in ran.err


@pytest.mark.slow
def test_a_robot_that_shows_no_scale_is_refused_before_the_search(orbident):
    """Nor is one refused whose joints' torques give its scale."""
    asked = "--duration", 10, "--starts", 1, "-o", "m.yaml"
    path = robot_file(Path(), ARM, LIMITS)
    orbident("excite", path, *asked).refused("scale of pi", "needs wheels")
    torques = GYRO.replace("wheels: {position: 1e-5}", "torques: {std: 1 mN m}")
    path = robot_file(Path(), ARM, LIMITS + torques.replace("gyro", POSITION + "gyro"))
    ran = orbident("excite", path, *asked).done()
    assert ran.err == ""


def test_wheels_without_a_sensor_are_told_before_the_search(orbident, monkeypatch):
    def searching(*_, **__):
        raise InputError("the search began")

    monkeypatch.setattr("orbident.excitation.design.design_recordings", searching)
    blind = GYRO.replace(", wheels: {position: 1e-5}", "")
    path = robot_file(Path(), ARM, LIMITS + WHEEL + blind)
    ran = orbident("excite", path, "--duration", 10, "-o", "m.yaml")
    told, search = ran.err.split("the search began")
    assert "nothing is said of wheels" in told
    assert not search.strip()


@pytest.mark.slow
def test_identify_refuses_what_lacks_it(orbident):
    path = robot_file(Path(), ARM, LIMITS + WHEEL + GYRO)
    orbident("excite", path, "--duration", 10, "--starts", 1, "-o", "m.yaml")
    orbident("simulate", path, "m.yaml", "-o", "r.csv", "--noise", "sensors")
    ran = orbident("identify", path, "r.csv", "--method", "least-squares")
    assert ran.status == 1
    assert "phi and the mass are not determined" in ran.err


def test_pulses_of_a_robot_without_joints(orbident, tmp_path):
    """Designed, predicted, sampled, flown and identified from the command line."""
    sensors = "sensors:\n  position: {std: 0.3 mm}\n  attitude: {angle: 0.5 mrad}\n"
    satellite(tmp_path, more=sensors)
    asked = "--duration", 10, "--starts", 2, "--limit", "base_rate=0.5"
    ran = orbident("excite", "satellite.yaml", *asked, "-o", "pulses.yaml").done()
    assert "best of 2 random sequences" in ran.out
    assert "nothing else acting, without feedback" in ran.out
    inspected = orbident("inspect", "satellite.yaml", "--trajectory", "pulses.yaml")
    assert "thrusters.scale" in inspected.done().out
    orbident("sample", "pulses.yaml", "--rate", 20, "-o", "commands.csv").done()
    head, *rows = Path("commands.csv").read_text().splitlines()
    assert head.startswith("t,thruster.t")
    assert {cell for row in rows for cell in row.split(",")[1:]} == {"0", "1"}
    orbident(
        *("sample", "pulses.yaml", "--rate", 20, "-o", "joints.yaml"),
        *("--format", "joint-trajectory"),
    ).refused("has no pulses of thrusters")
    orbident("excite", "satellite.yaml", "--compare", "pulses.yaml").refused(
        "scores motions of joints"
    )
    flown = "simulate", "satellite.yaml", "pulses.yaml", "--noise", "sensors"
    orbident(*flown, "-o", "flight.csv").done()
    orbident("identify", "satellite.yaml", "flight.csv").done()


def test_a_motion_beside_which_panels_swing(orbident, tmp_path):
    """What is designed is inspected and flown."""
    swinging_satellite(tmp_path)
    asked = "--duration", 10, "--starts", 1, "--harmonics", 3
    ran = orbident("excite", "satellite.yaml", *asked, "-o", "made.yaml")
    assert "2 joints, beside which others swing" in ran.out
    assert "by the number of harmonics" in ran.out
    assert "panel_left swings by up to" in ran.out
    assert load_trajectory("made.yaml").joints == ("shoulder", "elbow")
    orbident("simulate", "satellite.yaml", "made.yaml", "-o", "flight.csv").done()
    orbident("excite", "satellite.yaml", "--compare", "made.yaml").refused(
        "'orbident inspect ROBOT --trajectory TRAJ' tells what one promises"
    )
