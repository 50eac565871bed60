from pathlib import Path

import numpy as np
import pytest
from random_robots import random_robot

from orbident.model.formulas import (
    combinations,
    formulas_of,
    mass_forms,
    nominal_parameters,
    of_width,
)
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.robot_file import load_robot

TURNED = """<robot name="turned">
<link name="base"><inertial><mass value="40"/><origin xyz="0 0 0"/>
<inertia ixx="4" iyy="5" izz="6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><mass value="3"/><origin xyz="0.2 0 0"/>
<inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tool"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
<inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/>
<origin xyz="0.5 0 0" rpy="0 1.57079632679 1.57079632679"/><axis xyz="0 0 1"/></joint>
<joint name="bolts" type="fixed"><parent link="arm"/><child link="tool"/>
<origin xyz="0.4 0 0" rpy="1.57079632679 0 1.57079632679"/></joint>
</robot>"""
"""Right angles to as many digits as URDFs have: sums that are zero are 1e-12."""


@pytest.mark.parametrize(
    ("coefficients", "text"),
    [
        ([1.0, 0.0, 0.0], "a"),
        ([-1.0, 0.0, 0.0], "-a"),
        ([0.5, -2.0, 1.0], "-2 b + c + 0.5 a"),
        ([0.0, 1.0, -1.0], "b - c"),
        ([1 / 3, 0.0, 12345.678], "1.235e+04 c + 0.3333 a"),
        ([1.0, 1e-13, 0.0], "a"),
        ([1.0, 1.0 + 1e-12, 1.0], "a + b + c"),
        ([0.0, 0.0, 0.0], "0"),
    ],
)
def test_combination(coefficients, text):
    assert combinations(np.array([coefficients]), ["a", "b", "c"]) == (text,)


def test_nothing_is_combined_of_nothing():
    assert combinations(np.zeros((1, 0)), []) == ("0",)


def test_formulas_of_the_papers_arm():
    robot = load_robot("paper-spatial")
    found = formulas_of(robot, minimal_sets(robot))
    assert found.base.names[:6] == ("M", *(f"sigma_{k}" for k in range(1, 6)))
    assert found.base.names[6:] == tuple(f"iota_{k}" for k in range(1, 13))
    assert found.base.formulas[0] == "m(base) + m(link1) + m(link2) + m(link3)"
    assert found.phi.formulas[0] == "mx(base)/M"
    assert found.phi.formulas[3] == "(2 m(link3) + mx(link2))/M"
    assert "sigma_1 sigma_4/M" in found.pi.formulas
    assert found.pi.formulas[9] == "4 m(link3) + Iyy(link2) - sigma_4^2/M"


def test_mass_forms_of_the_papers_arm():
    """Eq. 42's mass is one of them; a sum is in parentheses."""
    robot = load_robot("paper-spatial")
    sets = minimal_sets(robot)
    words = formulas_of(robot, sets)
    one, two = np.eye(19)[13], np.eye(19)[12] + np.eye(19)[13]
    forms = mass_forms(sets, np.stack([one, two]), words)
    assert forms.names == ("pi_14", "pi_13 + pi_14")
    assert forms.formulas == (
        "pi_14/(phi_1 phi_5)",
        "(pi_13 + pi_14)/(phi_1 phi_4 + phi_1 phi_5)",
    )


def test_formulas_are_as_many_as_the_parameters():
    robot = random_robot(0, (0, 1), prismatic=(1,))
    sets = minimal_sets(robot)
    found = formulas_of(robot, sets)
    assert len(found.pi.names) == len(found.pi.formulas)
    assert len(found.pi.names) == len(sets.pi(robot.theta))
    assert found.pi.names[0] == "pi_1"
    assert found.phi.names[-1] == f"phi_{len(sets.phi(robot.theta))}"


def test_names_that_are_cut_remain_different():
    """Cut in their middles, all three would be `honey/to..tal_link`."""
    arms = ("arm", "gripper_left", "gripper_right")
    texts = [f"Ixz of honey/top_aft_{arm}_distal_link and beyond" for arm in arms]
    assert of_width(["total mass", *texts, "mx of honey/body"], 25) == [
        *("total mass", "Ixz of arm ...", "Ixz of gripper_left ..."),
        *("Ixz of gripper_right ...", "mx of honey/body"),
    ]
    other = "Ixz of honey/top_aft_gripper_left_proximal_link and beyond"
    left, right = of_width([*texts[1:], other], 25)[:2]
    assert (left, right) == ("Ixz of left_distal ...", "Ixz of right_distal ...")


def test_numbers_alone_are_no_names():
    """All letters of numbered links are the same; one that is cut alone keeps some."""
    texts = [f"Ixx - Iyy of servicer_arm_link_{k} and beyond" for k in (1, 2)]
    words = ["Ixx - Iyy of s_a_l_1 ...", "Ixx - Iyy of s_a_l_2 ..."]
    assert of_width(texts, 25) == words
    assert of_width(texts[:1], 25) == words[:1]
    assert of_width([f"Ixx of {10**40}"], 25) == [f"Ixx of 1{17 * '0'}"]
    assert of_width(["Ixx of base and beyond"], 22) == ["Ixx of base and beyond"]


def test_rounding_is_zero(tmp_path: Path):
    path = tmp_path / "turned.urdf"
    path.write_text(TURNED)
    robot = load_robot(path)
    sets = minimal_sets(robot)
    raw = sets.beta(robot.theta), sets.phi(robot.theta), sets.pi(robot.theta)
    rounded = 0
    for values, found in zip(raw, nominal_parameters(robot, sets), strict=True):
        # Nothing of this robot is between rounding and a gram at a centimetre.
        tiny = np.abs(values) < 1e-6
        rounded += np.count_nonzero(values[tiny])
        np.testing.assert_array_equal(found, np.where(tiny, 0.0, values))
    assert rounded > 0


def test_all_else_is_as_it_is():
    """A robot with nothing special about it has no zeros."""
    robot = random_robot(3, (0, 1, 2, 0))
    sets = minimal_sets(robot)
    found = nominal_parameters(robot, sets)
    np.testing.assert_array_equal(found.base, sets.beta(robot.theta))
    np.testing.assert_array_equal(found.phi, sets.phi(robot.theta))
    np.testing.assert_array_equal(found.pi, sets.pi(robot.theta))
