"""Joints that give way between motor and link, as robot files write them."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from urdf_texts import ARM, joint, link, robot

from orbident.errors import InputError
from orbident.estimation.weigh import weigh
from orbident.identified.exported_robot import exported_urdf
from orbident.model.core_robot import (
    spinning_parts,
    spinning_rotors,
    theta_with_rotors,
)
from orbident.model.equations_of_motion import check_regular
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Passive
from orbident.robot.parameters import Structure
from orbident.robot.robot_file import load_robot, write_robot

ELBOW = "flexible: {joint2: {frequency: 3 Hz, damping: 0.5 %, tolerance: 10 %}}"


def test_a_passive_joint_stands_behind_it(load_yaml):
    found, stiff = load_yaml(ELBOW), load_yaml()
    assert found.joint_names == ("joint1", "joint2", "joint2's flexibility")
    assert found.bodies == ("base", "link1", "joint2's motor", "link2")
    assert found.passive == {"joint2's flexibility": Passive(3.0, 0.005, 0.1)}
    assert found.structure == {"joint2's motor": Structure(spins_about="y")}
    motor, spring = found.joints[1:]
    np.testing.assert_array_equal(motor.p_PJ, stiff.joints[1].p_PJ)
    np.testing.assert_array_equal(spring.axis, motor.axis)
    np.testing.assert_array_equal(spring.p_PJ, np.zeros(3))
    np.testing.assert_array_equal(spring.R_PJ, np.eye(3))
    np.testing.assert_array_equal(np.delete(found.theta, 2, axis=0), stiff.theta)
    np.testing.assert_array_equal(found.theta[2], np.zeros(10))


def test_base_parameters_are_those_of_the_stiff_robot(load_yaml):
    flexible, stiff = load_yaml(f"rotors: none\n{ELBOW}"), load_yaml()
    found, of_stiff = (minimal_sets(x).beta(x.theta) for x in (flexible, stiff))
    # Rounding in matrices of some ten rows.
    np.testing.assert_allclose(found, of_stiff, atol=1e-9)


def test_a_rotor_before_the_spring_is_one_parameter_more(load_yaml):
    """The link does not turn as the motor does: momentum shows `N J` by itself."""
    rotor = "rotors: {joint1: none, joint2: {gear: 100, inertia: 1e-3 kg m^2}}"
    known, stiff = load_yaml(f"{rotor}\n{ELBOW}"), load_yaml()
    sets = minimal_sets(known)
    names = formulas_of(known, sets).base.formulas
    k = names.index("Iyy(joint2's motor) + rotor(joint2)")
    assert sets.beta(known.theta)[k] == pytest.approx(0.1)
    assert len(names) == len(minimal_sets(stiff).base.T) + 1
    (found,) = spinning_rotors(known)
    assert known.joint_names[found] == "joint2"
    with_rotors = theta_with_rotors(known)
    np.testing.assert_allclose(
        spinning_parts(known, with_rotors), with_rotors - known.theta
    )


def test_the_exported_urdf_is_the_stiff_one(load_yaml, tmp_path):
    """With the inertias of what was identified, for the robot file that there is."""
    robot = load_yaml(ELBOW)
    theta = 1.1 * robot.theta
    text = exported_urdf(replace(robot, theta=theta))
    again = load_yaml(ELBOW, text)
    assert (again.joint_names, again.passive) == (robot.joint_names, robot.passive)
    # Moved to the CM and back: rounding of 100 kg m^2.
    np.testing.assert_allclose(again.theta, theta, rtol=1e-13, atol=1e-12)
    stiff = load_yaml("", text)
    assert stiff.joint_names == ("joint1", "joint2")
    check_regular(stiff)


def test_what_takes_none_names_the_joint_as_the_file_does(load_yaml):
    words = r"joint 'joint2' is flexible, and the .* without 'joint2' under"
    with pytest.raises(InputError, match=words):
        weigh(load_yaml(ELBOW), Recording(np.arange(3.0), {}, "burn.csv"))


def test_limits_are_of_the_motor(load_yaml):
    limited = ARM.replace(
        "</joint></robot>", '<limit lower="-1" upper="2"/></joint></robot>'
    )
    found = load_yaml(ELBOW, limited)
    assert [each.position for each in found.joints] == [None, (-1.0, 2.0), None]


def test_what_is_written_is_read_again(load_yaml, tmp_path):
    found = load_yaml(ELBOW + "\nstructure: {link2: {com_on_axis: x}}")
    again = load_robot(write_robot(found, tmp_path / "written"))
    assert (again.joint_names, again.passive) == (found.joint_names, found.passive)
    assert again.structure == found.structure
    document = yaml.safe_load((tmp_path / "written" / "robot.yaml").read_text())
    assert "flexible" not in document


def test_comments_and_what_it_looks_like_are_kept(load_yaml):
    visual = "<!-- mine --><visual><geometry><box size='1 1 1'/></geometry></visual>"
    found = load_yaml(
        ELBOW, ARM.replace('<link name="link2">', f'<link name="link2">{visual}')
    )
    assert "<!-- mine -->" in found.urdf
    assert "<box" in found.urdf


def test_of_one_make(load_yaml):
    found = load_yaml("flexible: {joint2: {like: joint1}, joint1: {frequency: 3 Hz}}")
    one, other = (found.passive[f"joint{k}'s flexibility"] for k in (1, 2))
    assert other == one._replace(like="joint1's flexibility")


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (
            "flexible: {elbow: {frequency: 3 Hz}}",
            "flexible: no joint 'elbow' that turns; known ones: 'joint1', 'joint2'",
        ),
        ("flexible: {slide: {frequency: 3 Hz}}", "no joint 'slide' that turns"),
        ("flexible: {joint1: {frequency: 0}}", "flexible.joint1.frequency: found 0"),
        ("flexible: {joint1: {stiffness: 3}}", "unknown key 'stiffness'"),
        ("flexible: {joint1: }", "flexible.joint1"),
        (
            "passive: {joint1: {frequency: 1}}\nflexible: {joint1: {frequency: 3 Hz}}",
            "flexible.joint1: the joint is passive",
        ),
    ],
)
def test_what_is_wrong_is_one_line(load_yaml, lines, words):
    slide = joint("slide", "link2", "link3", kind="prismatic")
    arm = robot(
        ARM[len('<robot name="test">') : -len("</robot>")], link("link3"), slide
    )
    with pytest.raises(InputError, match=words) as error:
        load_yaml(lines, arm)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("rotors", ["none", "{joint2: none}"])
def test_a_motor_without_a_gear_has_no_rotor(load_yaml, rotors):
    found = load_yaml(f"rotors: {rotors}\n{ELBOW}")
    assert found.structure == {"joint2's motor": Structure(massless=True)}


def test_a_rotor_about_no_axis_of_the_link_has_no_place(load_yaml):
    """Then momentum would show its products of inertia, which nothing else has."""
    tilted = ARM.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0.6 0.8"/>')
    assert load_yaml(ELBOW, tilted).structure["joint2's motor"].massless
    with pytest.raises(InputError, match="'joint2's motor' is massless"):
        load_yaml(f"rotors: {{joint2: {{gear: 9, inertia: 1}}}}\n{ELBOW}", tilted)
