"""What CAD says of the minimal sets: zero where it is zero but for rounding."""

from pathlib import Path

import numpy as np
from random_robots import random_robot

from orbident.model.formulas import nominal_parameters
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
