"""An exported MJCF file loads as the robot that it was made of."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import mujoco
import pytest

from orbident.identified.exported_robot import exported_urdf, mechanism_of
from orbident.identified.simulator_models import mjcf
from orbident.robot.description import Friction
from orbident.robot.robot_file import load_robot

ROBOT = """<mujoco><worldbody><body name="base"><freejoint/>
<inertial pos="0 0 0" mass="10" diaginertia="1 1 1"/>
<body name="a"><joint name="j" axis="0 0 1"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
<body name="b"><joint name="k" axis="0 1 0" ref="10"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></worldbody>
<equality><joint joint1="k" joint2="j" polycoef="0.5 3 0 0 0"/></equality></mujoco>"""


def test_friction_is_that_of_the_joints(tmp_path: Path):
    path = tmp_path / "robot.xml"
    path.write_text(ROBOT)
    friction = {"j": Friction(0.5, 0.25, 0.1)}
    robot = replace(load_robot(path), friction=friction)
    (made,) = ET.fromstring(mjcf(mechanism_of(robot, ()))).iterfind(
        ".//joint[@damping]"
    )
    assert (made.get("name"), made.get("damping"), made.get("frictionloss")) == (
        *("j", "0.5", "0.25"),
    )
    model = mujoco.MjModel.from_xml_string(mjcf(mechanism_of(robot, ())))
    assert model.dof_damping.max() == 0.5
    assert model.dof_frictionloss.max() == 0.25
    urdf = ET.fromstring(exported_urdf(robot))
    (dynamics,) = urdf.iterfind("joint[@name='j']/dynamics")
    assert (dynamics.get("damping"), dynamics.get("friction")) == ("0.5", "0.25")


def test_joints_that_follow_others_still_do(tmp_path: Path):
    path = tmp_path / "robot.xml"
    path.write_text(ROBOT)
    robot = load_robot(path)
    path.write_text(mjcf(mechanism_of(robot, ())))
    again = load_robot(path)
    assert again.joint_names == robot.joint_names == ("j", "k")
    assert again.couplings == robot.couplings
    assert again.couplings[0].factor == pytest.approx(3.0)
