"""Motors behind gears: what every verb says of them, from the file to the export."""

import json
from pathlib import Path

import numpy as np
import pytest
from running import Orbident

ROTORS = "rotors: {joint1: {gear: 120, inertia: 4e-5, tolerance: 20 %}, joint3: none}\n"

MOTION = """\
schema: orbident/trajectory/1
duration: 40.0
joints:
  joint1: {a: [0.05, -0.05], b: [0.05, 0.05]}
  joint2: {a: [-0.05, 0.1], b: [0.1, -0.05]}
  joint3: {a: [0.1, 0.05], b: [-0.05, 0.05]}
initial: {angular_velocity: [0.01, 0.03, 0.025], wheel_speed: {rw1: 200, rw2: 300}}
"""

LACKS = "motors' rotors are not in the inertia of 'joint2', which lacks gear^2"


@pytest.mark.slow
def test_from_the_file_to_the_export(orbident: Orbident):
    orbident("new", "arm.yaml").done()
    Path("arm.yaml").write_text(Path("arm.yaml").read_text() + ROTORS)
    words = ", rotor 4e-05 kg m^2 +- 20 % behind 120"
    # Lines of the tree are as long as the terminal is wide.
    assert ", rotor" in orbident("check", "arm.yaml").done().out
    told = orbident("inspect", "arm.yaml").done().out
    assert f"joint1: revolute, base -> link1{words}" in told
    assert "the rotors of geared motors, if 'joint2' have any" in told
    Path("motion.yaml").write_text(MOTION)
    orbident("simulate", "arm.yaml", "motion.yaml", "--noise", "sensors", "-o", "r.csv")
    shown = orbident("identify", "arm.yaml", "r.csv", "--all", "-o", "run").done().out
    assert "links: base parameters without the motors' rotors" in shown
    assert " + rotor(joint1)" in shown
    assert "rotor(joint): its gear's ratio times" in shown
    export = ("export", "run", "-o")
    assert LACKS in orbident(*export, "arm.xml").done().out
    assert 'armature="0.571' in Path("arm.xml").read_text()
    assert LACKS in Path("arm.xml").read_text()
    assert "rotors of motors are in the robot file" in orbident(
        *export, "arm.urdf"
    ).done().out  # fmt: skip
    orbident(*export, "h.json", "--q", "0,0,0").done()
    document = json.loads(Path("h.json").read_text())
    assert LACKS in document["lacks"]
    # The tolerance of N (N - 1) J is in the deviation of the joint's own entry.
    assert np.array(document["H_plus_std"])[6, 6] > 0.2 * 0.57


def test_what_is_wrong_is_one_line(orbident: Orbident):
    orbident("new", "arm.yaml").done()
    text = Path("arm.yaml").read_text()
    for entry, words in (
        ("{elbow: {gear: 1, inertia: 1}}", "rotors: no joint 'elbow'"),
        ("{joint1: {gear: 0, inertia: 1}}", "rotors.joint1.gear: found 0; give how"),
        ("{joint1: {gear: 9, inertia: -1}}", "rotors.joint1.inertia: found -1"),
    ):
        Path("arm.yaml").write_text(f"{text}rotors: {entry}\n")
        orbident("check", "arm.yaml").refused(words)
