"""Robots of other tools that are wrong: one line that says what to do, status 2."""

import re
from pathlib import Path

import pytest
from running import Orbident

XACRO = """\
<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="m" value="2"/>
  <link name="base">
    <inertial><mass value="10"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="arm">
    <inertial><origin xyz="0.3 0 0"/><mass value="${m}"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>
"""
MJCF = """\
<mujoco model="a">
  <worldbody>
    <body name="base"><freejoint/>
      <inertial pos="0 0 0" mass="10" diaginertia="1 1 1"/>
      <body name="arm" pos="0.5 0 0">
        <joint name="j" type="hinge" axis="0 0 1"/>
        <inertial pos="0.3 0 0" mass="2" diaginertia="1 1 1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
SDF = """\
<sdf version="1.9">
  <model name="a">
    <link name="base"><inertial><mass>10</mass>
      <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <link name="arm"><pose>0.5 0 0 0 0 0</pose><inertial><mass>2</mass>
      <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <joint name="j" type="revolute"><parent>base</parent><child>arm</child>
      <axis><xyz>0 0 1</xyz></axis></joint>
  </model>
</sdf>
"""
FILES = {"a.xacro": XACRO, "a.xml": MJCF, "a.sdf": SDF}


def without_inertia(text: str) -> str:
    """The base has none; `/>` ends it in MJCF, a tag of its own in the others."""
    whole = r"<inertial pos.*?/>" if "<mujoco" in text else r"<inertial>.*?</inertial>"
    return re.sub(whole, "", text, count=1, flags=re.DOTALL)


SPOILT = {
    "nothing in it": lambda text: "",
    "truncated": lambda text: text[: 2 * len(text) // 3],
    "another root": lambda text: re.sub(
        r"<(/?)(robot|mujoco|sdf)", r"<\1machine", text
    ),
    "no inertia": without_inertia,
    "unknown joint": lambda text: re.sub("revolute|hinge", "screw", text),
    "text for mass": lambda text: text.replace("10", "heavy"),
    "text for an axis": lambda text: text.replace("0 0 1", "up"),
    "bytes": lambda text: text.replace("base", "b\udcff"),
}
WORDS = {
    "nothing in it": "malformed XML",
    "truncated": "malformed XML|MuJoCo cannot read it",
    "another root": r"the root element is <machine>; give <robot>.*<mujoco>.*<sdf>",
    "no inertia": "mass|inertia",
    "unknown joint": "'screw'",
    "text for mass": "mass",
    "text for an axis": "axis|xyz",
    "bytes": "is not UTF-8 text",
}


@pytest.mark.parametrize("name", FILES)
def test_the_good_ones_are_read(orbident: Orbident, name: str):
    Path(name).write_text(FILES[name])
    assert "12 kg nominal" in orbident("inspect", name).done().out


@pytest.mark.parametrize("spoilt", SPOILT)
@pytest.mark.parametrize("name", FILES)
def test_a_bad_one_is_refused(orbident: Orbident, name: str, spoilt: str):
    text = SPOILT[spoilt](FILES[name])
    Path(name).write_bytes(text.encode(errors="surrogateescape"))
    said = orbident("inspect", name).refused("orbident: a")
    assert re.search(WORDS[spoilt], said), said


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_not_there(orbident: Orbident, name: str):
    orbident("inspect", name).refused(f"{name}: no such file; check the path")
    Path("robot.yaml").write_text(f"schema: orbident/robot/1\nmodel: {name}\n")
    orbident("inspect", "robot.yaml").refused(f"no file {name}")


def test_a_version_that_nobody_knows(orbident: Orbident):
    Path("a.sdf").write_text(SDF.replace("1.9", "3.0"))
    orbident("inspect", "a.sdf").refused("version '3.0'", "'1.0' to '1.12'")
