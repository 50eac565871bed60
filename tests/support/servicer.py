"""A robot file for what URDFs may hold: rotors, fixed links, a base below the root."""

from pathlib import Path

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

SERVICER = """\
<robot name="servicer">
  <!-- kept -->
  <link name="world"/>
  <link name="deck"><inertial><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="bus"><inertial><origin xyz="0.1 0 0"/><mass value="100"/>
    <inertia ixx="10" ixy="0" ixz="0" iyy="12" iyz="0" izz="11"/></inertial>
    <visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <link name="rotor"><inertial><mass value="3"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial>
  </link>
  <link name="arm"><inertial><origin xyz="0.4 0.1 0"/><mass value="5"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.3"/></inertial></link>
  <link name="tool"><inertial><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
  <joint name="free" type="floating"><parent link="world"/><child link="deck"/></joint>
  <joint name="bolt" type="fixed"><parent link="deck"/><child link="bus"/>
    <origin xyz="0 0 -0.5" rpy="0.1 0.2 0.3"/></joint>
  <joint name="spin" type="continuous"><parent link="deck"/><child link="rotor"/>
    <origin xyz="0.2 0 0" rpy="0.4 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="shoulder" type="revolute"><parent link="bus"/><child link="arm"/>
    <origin xyz="0.5 0 0.2" rpy="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="grip" type="fixed"><parent link="arm"/><child link="tool"/>
    <origin xyz="0.8 0 0" rpy="0 0.3 0"/></joint>
</robot>
"""

FILE = """\
schema: orbident/robot/1
urdf: servicer.urdf
base_link: bus
feature_point: [0.3, -0.2, 0.6]
wheels:
  - {name: rw, joint: spin}
  - {name: rw_x, axis: [1, 0, 0], inertia: 0.03}
"""


def load_servicer(folder: Path) -> Robot:
    """Write `servicer.urdf` and `servicer.yaml` there, and load them."""
    (folder / "servicer.urdf").write_text(SERVICER)
    (folder / "servicer.yaml").write_text(FILE)
    return load_robot(folder / "servicer.yaml")
