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
