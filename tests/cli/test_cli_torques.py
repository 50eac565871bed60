"""Torques at joints: what every verb says of them, from the file to the result."""

import json
from pathlib import Path

import pytest
from running import Orbident

MOTION = """\
schema: orbident/trajectory/1
duration: 40.0
joints:
  joint1: {a: [0.05, -0.05], b: [0.05, 0.05]}
  joint2: {a: [-0.05, 0.1], b: [0.1, -0.05]}
  joint3: {a: [0.1, 0.05], b: [-0.05, 0.05]}
initial: {angular_velocity: [0.01, 0.03, 0.025]}
"""

DRIVES = """\
friction: {joint1: {viscous: 20 mN m s, coulomb: 5 mN m, offset: 2 mN m}}
rotors: none
tolerances: exact
disturbances: []
"""


@pytest.fixture
def without_wheels(orbident: Orbident) -> Orbident:
    """An arm on a base without a wheel, and its recording."""
    orbident("new", "arm.yaml").done()
    text = Path("arm.yaml").read_text()
    lines = [line for line in text.splitlines() if "rw" not in line]
    text = "\n".join(lines).replace("wheels:\n", "wheels: []\n", 1)
    text = text.replace("  wheels: {position: 0.1 mrad}", "  torques: {std: 2 mN m}")
    Path("arm.yaml").write_text(f"{text}\n{DRIVES}")
    Path("motion.yaml").write_text(MOTION)
    made = ("simulate", "arm.yaml", "motion.yaml", "--noise", "sensors", "-o", "r.csv")
    orbident(*made).done()
    return orbident


def test_from_the_file_to_the_result(without_wheels: Orbident):
    orbident = without_wheels
    checked = orbident("check", "arm.yaml").done().out
    assert "torques: rate 20, std 0.002" in checked
    assert "no wheels" not in checked
    told = orbident("inspect", "arm.yaml").done().out
    assert ", friction 0.02 viscous, 0.005 Coulomb, offset 0.002" in told
    assert "the scale of pi" not in told
    identify = ("identify", "arm.yaml", "r.csv", "--json", "found.json")
    shown = orbident(*identify).done().out
    assert "Friction and rotors of joints, SI" in shown
    found = json.loads(Path("found.json").read_text())
    M, std = found["mass"]["value"], found["mass"]["std"]
    # Deviations of a single recording: more than four are no chance.
    assert abs(M - 115.0) < 4 * std < 5.0
    drive = found["drives"]["joint1"]
    for what, true in (("viscous", 0.02), ("coulomb", 0.005), ("offset", 0.002)):
        assert abs(drive[what] - true) < 4 * drive[f"{what}_std"]
    assert "torques" in found["residual"]["sensors"]


def test_without_torques_there_is_no_scale(without_wheels: Orbident):
    refused = without_wheels("identify", "arm.yaml", "r.csv", "--method", "structured")
    assert "or record torques of joints" in refused.err


def test_a_second_recording_without_torques_is_named(without_wheels: Orbident):
    made = ("simulate", "arm.yaml", "motion.yaml", "--noise", "sensors", "--seed", "5")
    without_wheels(*made, "-o", "s.csv").done()
    rows = [line.split(",") for line in Path("s.csv").read_text().splitlines()]
    kept = [k for k, name in enumerate(rows[0]) if not name.endswith(".torque")]
    lines = [",".join(row[k] for k in kept) for row in rows]
    Path("s.csv").write_text("\n".join([*lines, ""]))
    refused = without_wheels("identify", "arm.yaml", "r.csv", "s.csv")
    assert "s: pi has no scale: the robot has no reaction wheel" in refused.err


def as_currents(constants: dict[str, float]) -> None:
    """Writes `c.csv`, which is `r.csv` with currents in the place of torques."""
    header, *lines = Path("r.csv").read_text().splitlines()
    cells = zip(*(line.split(",") for line in lines), strict=True)
    table = dict(zip(header.split(","), cells, strict=True))
    for joint, constant in constants.items():
        torque = table.pop(f"joint.{joint}.torque")
        current = [repr(float(x) / constant) if x else "" for x in torque]
        table[f"joint.{joint}.current"] = tuple(current)
    rows = map(",".join, zip(*table.values(), strict=True))
    Path("c.csv").write_text("\n".join([",".join(table), *rows, ""]))


@pytest.mark.slow
def test_currents_of_motors_from_the_file_to_the_result(without_wheels: Orbident):
    """All that follows is as by torques, with the tolerance of torque constants."""
    orbident, text = without_wheels, Path("arm.yaml").read_text()
    scales = "tolerances: {joints: {torque_scale: 5 %}}"
    text = text.replace("tolerances: exact", scales)
    Path("arm.yaml").write_text(text)
    motors = "torque_constants: {joint1: 2.5 N m/A, joint3: 40 mN m/A}\n"
    Path("motors.yaml").write_text(text + motors)
    orbident("check", "motors.yaml", "--json", "check.json").done()
    known = json.loads(Path("check.json").read_text())["torque_constants"]
    assert known == {"joint1": 2.5, "joint3": 0.04}
    shown = orbident("inspect", "motors.yaml").done().out
    assert ", torque constant 2.5 N m/A +- 5 %" in shown
    as_currents(known)
    numbers = []
    for robot, recording in (("arm", "r.csv"), ("motors", "c.csv")):
        identify = ("identify", f"{robot}.yaml", recording, "-o", robot)
        orbident(*identify, "--json", "found.json").done()
        found = json.loads(Path("found.json").read_text())
        orbident("validate", robot, recording, "--json", "scores.json")
        scores = json.loads(Path("scores.json").read_text())
        inspect = ("inspect", f"{robot}.yaml", "--trajectory", "motion.yaml")
        orbident(*inspect, "--json", "bound.json").done()
        bound = json.loads(Path("bound.json").read_text())
        numbers.append(
            {
                "mass": found["mass"]["value"],
                "bound": bound["base"]["bound"][0],
                "scale": found["calibration"]["joint.joint1.torque_scale"]["value"],
                "viscous": found["drives"]["joint1"]["viscous"],
                **scores["torques"],
            }
        )
    by_torque, by_current = numbers
    assert by_current == pytest.approx(by_torque, rel=1e-5)
    refused = orbident("identify", "arm.yaml", "c.csv")
    refused.refused("add 'torque_constants: {joint1: ... N m/A}' to the robot file")


def test_simulated_currents_are_identified(without_wheels: Orbident):
    with Path("arm.yaml").open("a") as file:
        file.write("torque_constants: {joint1: 2.5, joint2: 1, joint3: 0.4}\n")
    made = ("simulate", "arm.yaml", "motion.yaml", "--noise", "sensors", "-o", "i.csv")
    without_wheels(*made).done()
    assert "joint.joint2.current" in Path("i.csv").read_text().splitlines()[0]
    run = ("identify", "arm.yaml", "i.csv", "--json", "found.json")
    without_wheels(*run).done()
    mass = json.loads(Path("found.json").read_text())["mass"]
    assert abs(mass["value"] - 115.0) < 4 * mass["std"] < 5.0
