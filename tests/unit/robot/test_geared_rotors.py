"""Motors' rotors as robot files write them, and as models propose them."""

from pathlib import Path

import pytest
from urdf_texts import ARM, joint, link, robot

from orbident.errors import InputError
from orbident.robot.description import NO_ROTOR, GearedRotor
from orbident.robot.robot_file import load_robot
from orbident.robot.urdf import urdf_text
from orbident.robot.urdf_reader import read_urdf


def test_in_units(load_yaml):
    found = load_yaml(
        "rotors: {joint1: {gear: 160, inertia: 2 kg cm^2, tolerance: 20 %}, "
        "joint2: none}"
    )
    assert found.rotors == {"joint1": GearedRotor(160, 2e-4, 0.2), "joint2": NO_ROTOR}
    back = load_yaml("rotors: {joint1: {gear: -50, inertia: 1e-5}}").rotors
    assert back == {"joint1": GearedRotor(-50, 1e-5, 0.1)}


def test_none_at_all(load_yaml):
    found = load_yaml("rotors: none").rotors
    assert found == {"joint1": NO_ROTOR, "joint2": NO_ROTOR}


SLIDES = robot(link("base"), link("a"), joint("slide", "base", "a", kind="prismatic"))


@pytest.mark.parametrize(
    ("lines", "urdf", "words"),
    [
        ("rotors: {elbow: {gear: 1, inertia: 1}}", ARM, "rotors: no joint 'elbow'"),
        (
            "rotors: {joint1: {gear: 0, inertia: 1}}",
            ARM,
            "gear: found 0; give how",
        ),
        ("rotors: {joint1: {gear: 9, inertia: -1}}", ARM, "-1; give zero or more"),
        ("rotors: {joint1: {gear: 9}}", ARM, "inertia: this key is missing"),
        ("rotors: {joint1: {ratio: 9}}", ARM, "unknown key 'ratio'"),
        ('rotors: {"*": {gear: 9, inertia: 1}}', ARM, "rotors: no joint '[*]'"),
        ("rotors: 160", ARM, "rotors: found 160; give names and their entries"),
        (
            "rotors: {slide: {gear: 9, inertia: 1}}",
            SLIDES,
            "rotors.slide: the joint",
        ),
        (
            "rotors: {joint1: {gear: 9, inertia: 1}}\n"
            "structure: {link1: {com_on_axis: z, principal_axes: true}}",
            ARM.replace('axis xyz="0 0 1"', 'axis xyz="1 0 1"'),
            "its axis is none of 'link1'",
        ),
    ],
)
def test_what_is_refused(load_yaml, lines: str, urdf: str, words: str):
    with pytest.raises(InputError, match=words) as refusal:
        load_yaml(lines, urdf=urdf)
    assert "\n" not in str(refusal.value)


def geared(name: str, reduction: object) -> str:
    return (
        f'<transmission name="t"><joint name="{name}"/><actuator name="m">'
        f"<mechanicalReduction>{reduction}</mechanicalReduction></actuator>"
        "</transmission>"
    )


@pytest.mark.parametrize(
    ("reduction", "dynamics", "proposal"),
    [
        ("100", "", "joint1: {gear: 100, inertia: ?}"),
        ("-100", '<dynamics armature="0.5"/>', "joint1: {gear: -100, inertia: 5e-05}"),
        ("1", '<dynamics armature="0.5"/>', "joint1: {gear: ?, inertia: 0.5 / gear^2}"),
        ("1", '<dynamics damping="0.5"/>', None),
        ("fast", "", None),
    ],
)
def test_urdf_proposes(load_yaml, reduction: str, dynamics: str, proposal: str | None):
    """What is no number is no proposal; what the file says is not proposed."""
    text = robot(
        link("base"),
        link("link1"),
        joint("joint1", "base", "link1", inside=dynamics),
        geared("joint1", reduction),
    )
    found = [each for each in load_yaml(urdf=text).warnings if "rotors: {" in each]
    words = f"give rotors: {{{proposal}}} in a robot file, or rotors: none"
    assert [words in each for each in found] == ([] if proposal is None else [True])
    assert not load_yaml("rotors: none", urdf=text).warnings
    again = read_urdf(urdf_text(read_urdf(text)))
    assert again.joints[0].gear == read_urdf(text).joints[0].gear
    assert again.joints[0].armature == read_urdf(text).joints[0].armature


MJCF = """
<mujoco model="m"><worldbody><body name="base"><freejoint/>
  <inertial pos="0 0 0" mass="10" diaginertia="1 1 1"/>
  <body name="arm"><joint name="j" axis="0 0 1" armature="0.32"/>
    <inertial pos="0.2 0 0" mass="2" diaginertia="0.1 0.2 0.2"/></body></body>
</worldbody><actuator><motor joint="j" gear="80"/></actuator></mujoco>
"""


def test_mjcf_proposes(tmp_path: Path):
    pytest.importorskip("mujoco")
    (tmp_path / "m.xml").write_text(MJCF)
    (warning,) = load_robot(tmp_path / "m.xml").warnings
    assert "rotors: {j: {gear: 80, inertia: 5e-05}}" in warning
