"""`weigh`: the total mass from a thruster burn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from burns import Body, burn, changed, without
from random_motions import random_motion
from running import Orbident, written

from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

BODY = Body(load_robot("cepheus-like").joint_names, mass=12.3)


@pytest.fixture(scope="module")
def table_burn() -> Recording:
    return without(burn(BODY), "velocity", "accelerometer")


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_mass_in_words_and_as_json(
    orbident: Orbident, table_burn: Recording, suffix: str
):
    file = written(table_burn, f"burn.{suffix}")
    words = orbident("weigh", "cepheus-like", file).done().out
    assert "cepheus-like: trusted, 401 samples of position" in words
    assert "mass 12.3 +- " in words
    # sqrt(0.3^2 + 0.5^2) N for 0.5 s.
    assert "impulse of 0.2915 N s" in words
    weighing = orbident("weigh", "cepheus-like", file, "--json", "-").done().json
    assert set(weighing) == {
        "mass",
        "status",
        "warnings",
        "signal",
        "samples",
        "impulse",
        "residual_rms",
        "thrust",
    }
    # As in the unit test: the base does not turn quite evenly in a step.
    assert weighing["mass"]["value"] == pytest.approx(12.3, rel=1e-7)
    assert 0 < weighing["mass"]["std"] < 1e-5
    assert weighing["status"] == "ok"
    assert orbident("weigh", "cepheus-like", file, "--quiet").done().out == ""


def test_json_to_a_file(orbident: Orbident, table_burn: Recording):
    file = written(table_burn, "burn.csv")
    orbident("weigh", "cepheus-like", file, "--json", "mass.json").done()
    assert '"mass"' in Path("mass.json").read_text()


def test_a_mass_that_is_not_determined(orbident: Orbident, table_burn: Recording):
    against = changed(table_burn, force=-table_burn.vector("force"))
    ran = orbident("weigh", "cepheus-like", written(against, "r.csv"), "--json", "-")
    assert ran.status == 1
    assert ran.json["mass"] == {"value": None, "std": None}
    assert ran.json["status"] == "rejected"
    assert ran.err.startswith("orbident: warning: mass: the robot moved against")
    assert ran.err.count("\n") == 1
    ran = orbident("weigh", "cepheus-like", "r.csv")
    assert ran.status == 1
    assert "mass not determined" in ran.out


def test_refusals(orbident: Orbident, table_burn: Recording):
    def refused(recording: Recording, *words: str):
        file = written(recording, "r.csv")
        orbident("weigh", "cepheus-like", file).refused("r.csv: ", *words)

    refused(without(table_burn, "force"), "'force.x' is missing")
    refused(
        changed(table_burn, force=0 * table_burn.vector("force")), "zero throughout"
    )
    refused(without(table_burn, "attitude"), "'attitude.x' is missing")
    refused(without(table_burn, "position"), "neither position.x")
    columns = dict(table_burn.columns)
    columns["joint.joint1.position"] = np.linspace(0.0, 0.1, table_burn.t.size)
    moving = Recording(table_burn.t, columns)
    refused(moving, "'joint.joint1.position'", "moved by 0.1 rad")


def test_files_that_are_not_there(orbident: Orbident):
    orbident("weigh", "cepheus-like", "no.csv").refused("no.csv: does not exist")
    orbident("weigh", "cepheus", "no.csv").refused("cepheus")


def test_help(orbident: Orbident):
    words = orbident("weigh", "--help").done().out
    assert "Usage: orbident weigh" in words
    assert "ROBOT" in words
    assert "REC" in words


def test_beside_the_other_masses(orbident: Orbident, table_burn: Recording):
    """`identify --burn` of the same robot, and of a heavier one."""
    robot = load_robot("cepheus-like")
    motion = random_motion(robot, start="spun up")
    flight = written(simulate(robot, motion, noise="sensors"), "flight.csv")
    burns = [burn(replace(BODY, mass=m * robot.mass)) for m in (1.0, 1.05)]
    files = [written(b, f"burn{k}.csv") for k, b in enumerate(burns)]
    common = "identify", "cepheus-like", flight, "--initial-momentum", "at-rest"
    ran = [orbident(*common, "--burn", file, "--json", "-") for file in files]
    same, heavier = ran[0].done().json, ran[1].json
    assert "check the burn's force" in ran[1].err
    forms = same["mass"]["forms"]
    routes = "Eq. 40", "Eq. 32", "maximum likelihood"
    assert forms["names"][-3:] == [f"M by {route}" for route in routes]
    assert forms["values"][-3] == pytest.approx(robot.mass, rel=1e-6)
    assert same["warnings"] == []
    assert any("kg by Eq. 40" in words for words in heavier["warnings"])
    assert same["mass"]["value"] == heavier["mass"]["value"]


def test_a_burn_that_cannot_be_weighed(orbident: Orbident, table_burn: Recording):
    robot = load_robot("cepheus-like")
    flight = written(simulate(robot, random_motion(robot)), "flight.csv")
    without_force = written(without(table_burn, "force"), "burn.csv")
    orbident("identify", "cepheus-like", flight, "--burn", without_force).refused(
        "burn.csv", "force.x"
    )


def test_thrusters_on_a_bench(orbident: Orbident):
    """Of pulses with 0.5 N and no noise; a section that is a list in YAML."""
    rows = [f"{k / 50},{0.5 * (k // 100 % 2)},{k // 100 % 2}" for k in range(1001)]
    Path("jet.csv").write_text("\n".join(["t,force_N,command", *rows]))
    ran = orbident("weigh", "--bench", "jet.csv", "jet.csv").done()
    section = yaml.safe_load(ran.out[ran.out.index("thrusters:") :])["thrusters"]
    assert [each["thrust"] for each in section] == [0.5, 0.5]
    bench = orbident("weigh", "--bench", "jet.csv", "--json", "-").done().json["bench"]
    assert bench["jet"]["pulses"] == 4
    orbident("weigh", "--bench", "no.csv").refused("no.csv: does not exist")
    orbident("weigh", "jet.csv").refused("found 1 of ROBOT and REC")
