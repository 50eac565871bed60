"""Numbers that no spacecraft has are refused where they are read."""

import numpy as np
import pytest
from urdf_texts import ARM

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot
from orbident.robot.urdf_reader import read_urdf

TEXT = (
    '<robot name="r"><link name="a"><inertial><origin xyz="{xyz} 0 0"/>'
    '<mass value="{mass}"/><inertia ixx="{ixx}" iyy="1" izz="1" ixy="0" ixz="0" '
    'iyz="0"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia '
    'ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute">'
    '<parent link="a"/><child link="b"/><axis xyz="{axis} 0 0"/>'
    '<limit lower="{lower}" upper="{upper}" velocity="{velocity}"/></joint></robot>'
)
USUAL = {
    **{"xyz": "0", "mass": "1", "ixx": "1", "axis": "1"},
    **{"lower": "-1", "upper": "1", "velocity": "1"},
}

REFUSED = {
    "mass": ("1e160", r"<mass value>: found '1e160'; give at most 1e\+12, in SI units"),
    "ixx": ("1e300", r"<inertia ixx>: found '1e300'; give at most"),
    "xyz": ("-1e200", r"<origin xyz>: found '-1e200 0 0'; give at most"),
    "axis": ("1e-170", "found axis 0 0 0; give a nonzero vector"),
}


@pytest.mark.parametrize("key", REFUSED)
def test_what_no_robot_has(key: str):
    value, words = REFUSED[key]
    with pytest.raises(InputError, match=words):
        read_urdf(TEXT.format(**{**USUAL, key: value}))


def test_a_mass_next_to_nothing():
    with pytest.raises(InputError, match="give zero, or at least 1e-15 kg"):
        read_urdf(TEXT.format(**{**USUAL, "mass": "1e-200"}))


def test_the_largest_numbers_make_a_finite_robot(tmp_path):
    path = tmp_path / "r.urdf"
    huge = {"mass": "1e12", "ixx": "1e12", "xyz": "1e12"}
    path.write_text(TEXT.format(**{**USUAL, **huge}))
    assert np.isfinite(load_robot(path).theta).all()


def test_a_limit_as_large_as_can_be_is_none():
    largest = {"lower": "-1e308", "upper": "1e308", "velocity": "1e308"}
    (joint,) = read_urdf(TEXT.format(**{**USUAL, **largest})).joints
    assert joint.position is None
    assert joint.velocity is None


def test_noise_next_to_nothing_is_refused(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    path = tmp_path / "r.yaml"
    for value, words in (("1e-300", "give zero, or at least"), ("1e300", "at most")):
        path.write_text(
            "schema: orbident/robot/1\nurdf: arm.urdf\n"
            f"sensors: {{attitude: {{angle: {value} rad}}}}\n"
        )
        with pytest.raises(InputError, match=words):
            load_robot(path)
