"""xacro files, and how a file's kind is told."""

from pathlib import Path

import numpy as np
import pytest
from urdf_texts import ARM

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot

SPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
LINK = """
<robot name="sc" {space}>
  <xacro:arg name="mass" default="{mass}"/>
  <xacro:property name="side" value="0.5"/>
  <xacro:macro name="part" params="name">
    <link name="${{name}}"><inertial><mass value="$(arg mass)"/>
      <inertia ixx="${{2 * side}}" iyy="1" izz="1.5" ixy="0" ixz="0" iyz="0"/>
    </inertial></link>
  </xacro:macro>
  <xacro:part name="base"/>{more}
</robot>"""


def xacro(mass: object = 7, more: str = "") -> str:
    return LINK.format(space=SPACE, mass=mass, more=more)


def test_macros_properties_and_defaults_of_arguments(tmp_path: Path):
    path = tmp_path / "sc.urdf.xacro"
    path.write_text(xacro())
    robot = load_robot(path)
    assert (robot.name, robot.bodies, robot.mass) == ("sc", ("base",), 7.0)
    np.testing.assert_array_equal(robot.theta[0, 4:], [1, 0, 1, 0, 0, 1.5])
    # Nothing of xacro is left in what is kept.
    assert "arg" not in robot.urdf


def test_a_file_that_is_included(tmp_path: Path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xacro").write_text(
        f'<robot {SPACE}><xacro:property name="mass" value="3"/></robot>'
    )
    path = tmp_path / "sc.xacro"
    more = (
        '<xacro:include filename="parts/arm.xacro"/><link name="arm"><inertial>'
        '<mass value="${mass}"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
        '<joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>'
    )
    path.write_text(xacro(more=more))
    assert load_robot(path).mass == 10.0
    document = "schema: orbident/robot/1\nmodel: sc.xacro\n"
    (tmp_path / "robot.yaml").write_text(document)
    assert load_robot(tmp_path / "robot.yaml").mass == 10.0


def test_a_file_of_the_same_package_and_of_one_that_ros_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    package, other = tmp_path / "sc", tmp_path / "other"
    for folder in (package / "urdf", other):
        folder.mkdir(parents=True)
    (package / "package.xml").touch()
    for place in (package, other):
        (place / "a.yaml").write_text("mass: 3")
    values = ["load_yaml('../a.yaml').mass", f"load_yaml('{other}/a.yaml').mass"]
    path = package / "urdf" / "sc.xacro"
    path.write_text(xacro("${{{} + {}}}".format(*(f"xacro.{v}" for v in values))))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(other))
    assert load_robot(path).mass == 6.0


BAD = {
    "cut off": (xacro()[:200], "malformed XML"),
    "no default": (
        xacro().replace('<xacro:arg name="mass" default="7"/>', ""),
        "Undefined substitution argument mass; give it a default",
    ),
    "no such macro": (xacro(more="<xacro:gone/>"), "gone"),
    "no such property": (xacro(more='<link name="${gone}"/>'), "gone"),
    "no such file": (xacro(more='<xacro:include filename="gone"/>'), "gone"),
    "a package of ROS": (
        xacro(more='<xacro:include filename="$(find arm)/a.xacro"/>'),
        "expand the file where ROS is",
    ),
    "a program": (xacro(more="${__import__('os')}"), "invalid name"),
    "a division by zero": (
        xacro(more='<xacro:if value="${1 / 0}"><link name="a"/></xacro:if>'),
        "division by zero",
    ),
    "without an end": (
        xacro(
            more='<xacro:macro name="again" params=""><xacro:again/></xacro:macro>'
            "<xacro:again/>"
        ),
        "does not come to an end",
    ),
    "a file elsewhere": (
        xacro(more="<link name=\"${xacro.load_yaml('/etc/hostname')}\"/>"),
        "is outside of what a xacro file may read",
    ),
    "a file above": (
        xacro(more='<xacro:include filename="../a.xacro"/>'),
        "is outside of what a xacro file may read",
    ),
    "a variable of the shell": (
        xacro(more='<link name="$(env HOME)"/>'),
        "environment variable 'HOME' is not set",
    ),
    "a text without end": (
        xacro(more="<link name=\"${'x'*10**10}\"/>"),
        "needs more than 500 MB of memory",
    ),
    "text for mass": (xacro("heavy"), "link 'base': <mass value>: found 'heavy'"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_refused(tmp_path: Path, case: str, capfd: pytest.CaptureFixture[str]):
    text, words = BAD[case]
    path = tmp_path / "sc.xacro"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert words in message
    assert "\n" not in message
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("case", ["a division by zero", "a file above"])
def test_nothing_is_said_twice(tmp_path: Path, case: str):
    text, words = BAD[case]
    path = tmp_path / "sc.xacro"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    assert str(caught.value).count(words) == 1


@pytest.mark.long
def test_what_would_not_end_is_stopped(tmp_path: Path):
    path = tmp_path / "sc.xacro"
    path.write_text(xacro("${9**9**9}"))
    with pytest.raises(InputError, match="needs more than 3 s of the processor"):
        load_robot(path)


def test_a_program_is_run_only_where_the_suffix_says_so(tmp_path: Path):
    path = tmp_path / "sc.urdf"
    path.write_text(xacro())
    with pytest.raises(InputError, match=r"rename it to sc\.xacro"):
        load_robot(path)
    # What xacro has expanded still declares its name space.
    path.write_text(ARM.replace("<robot", f"<robot {SPACE}", 1))
    assert load_robot(path).mass == 109.0


@pytest.mark.parametrize("suffix", [".xml", ".sdf", ".urdf", ".xacro"])
def test_a_urdf_with_another_suffix(tmp_path: Path, suffix: str):
    (tmp_path / f"sc{suffix}").write_text(ARM)
    assert load_robot(tmp_path / f"sc{suffix}").mass == 109.0


def test_model_and_urdf_are_one_key(tmp_path: Path):
    (tmp_path / "sc.urdf").write_text(ARM)
    robots = []
    for key in ("model", "urdf"):
        (tmp_path / "sc.yaml").write_text(f"schema: orbident/robot/1\n{key}: sc.urdf\n")
        robots.append(load_robot(tmp_path / "sc.yaml"))
    np.testing.assert_array_equal(robots[0].theta, robots[1].theta)
    (tmp_path / "sc.yaml").write_text(
        "schema: orbident/robot/1\nmodel: sc.urdf\nurdf: sc.urdf\n"
    )
    with pytest.raises(InputError, match="model and urdf each describe a robot"):
        load_robot(tmp_path / "sc.yaml")
