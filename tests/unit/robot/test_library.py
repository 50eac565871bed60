import numpy as np
import pytest
from urdf_texts import ARM

from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com
from orbident.robot.robot_file import bundled_robots, load_robot, write_robot


def assert_same_robot(one: Robot, other: Robot) -> None:
    for name in (
        "name",
        "motion",
        "bodies",
        "sensors",
        "structure",
        "warnings",
        "urdf",
    ):
        assert getattr(one, name) == getattr(other, name)
    np.testing.assert_array_equal(one.theta, other.theta)
    np.testing.assert_array_equal(one.feature_point, other.feature_point)
    for a, b in zip(one.joints, other.joints, strict=True):
        for name in ("axis", "R_PJ", "p_PJ"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        assert (a.name, a.kind, a.parent) == (b.name, b.kind, b.parent)
        assert (a.position, a.velocity) == (b.position, b.velocity)
    for a, b in zip(one.wheels, other.wheels, strict=True):
        np.testing.assert_array_equal(a.axis, b.axis)
        assert (a.name, a.inertia, a.mode) == (b.name, b.inertia, b.mode)
    for a, b in zip(one.thrusters, other.thrusters, strict=True):
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.direction, b.direction)


def test_the_bundled_robots():
    assert {"paper-spatial", "cepheus-like", "dual-arm"} <= set(bundled_robots())


@pytest.mark.parametrize("name", bundled_robots())
def test_bundled_robots_load_without_warnings(name):
    robot = load_robot(name)
    assert robot.name == name
    assert robot.warnings == ()
    assert all(joint.position and joint.velocity for joint in robot.joints)


@pytest.mark.parametrize("name", bundled_robots())
def test_a_written_robot_loads_again(name, tmp_path):
    robot = load_robot(name)
    path = write_robot(robot, tmp_path / "new" / "run")
    assert path == tmp_path / "new" / "run" / "robot.yaml"
    assert_same_robot(load_robot(path), robot)


def test_a_bare_urdf_is_written_with_a_robot_file(load_urdf, tmp_path):
    robot = load_urdf(ARM)
    assert_same_robot(load_robot(write_robot(robot, tmp_path)), robot)


def test_paper_spatial_is_table_1():
    robot = load_robot("paper-spatial")
    assert robot.theta[:, 0].tolist() == [1000, 10, 50, 50]
    diagonals = [[600, 600, 900], [0.21, 0.21, 0.01]] + 2 * [[0.05, 16.69, 16.69]]
    for theta_i, diagonal in zip(robot.theta, diagonals, strict=True):
        # The base's CM is 1.6 m away: 2e3 kg m^2 cancel.
        I = inertia_about_com(theta_i)
        np.testing.assert_allclose(I, np.diag(diagonal), atol=1e-11)
    # r0, from the base's CM to joint 1, as reproduces Table 4.
    r0 = robot.joints[0].p_PJ - robot.theta[0, 1:4] / 1000
    np.testing.assert_allclose(r0, [-1.06191, -1.06191, 0.67082], atol=1e-15)
    l1r1, l2r2 = robot.joints[1].p_PJ, robot.joints[2].p_PJ
    np.testing.assert_array_equal([l1r1, l2r2], [[0, 0, 0.5], [2, 0, 0]])
    assert [wheel.inertia for wheel in robot.wheels] == [0.18] * 3
    # 4 bodies x 10, less 5 that the structure of each link makes zero.
    assert len(robot.free_parameters) == 25


def test_cepheus_like_is_the_surrogate():
    robot = load_robot("cepheus-like")
    assert robot.motion == "planar"
    assert robot.theta[:, 0].tolist() == [13.44, 0.06, 0.06]
    polar = [inertia_about_com(theta_i)[2, 2] for theta_i in robot.theta]
    np.testing.assert_allclose(polar, [0.1411, 0.00115, 0.0005], rtol=1e-12)
    # Eq. 44's r_joint1/s, and r0 from the base's CM.
    p_SJ = robot.joints[0].p_PJ
    np.testing.assert_array_equal(p_SJ, [0.173, 0.091, 0])
    r0 = p_SJ - robot.theta[0, 1:4] / 13.44
    np.testing.assert_allclose(r0, [0.1593, 0.0766, 0], atol=1e-15)
    # Eq. 46.
    assert [joint.position for joint in robot.joints] == [(-1.05, 2.5), (-2.09, 1.4)]
    assert [joint.velocity for joint in robot.joints] == [0.7, 0.5]


def test_dual_arm_has_two_arms_of_seven_joints_and_no_special_structure():
    robot = load_robot("dual-arm")
    names = [f"{side}_joint{k}" for side in ("left", "right") for k in range(1, 8)]
    assert list(robot.joint_names) == names
    assert [joint.parent for joint in robot.joints] == [
        0,
        *range(1, 7),
        0,
        *range(8, 14),
    ]
    assert not robot.structure
    # Every first moment and product of inertia is there to be identified.
    assert np.all(robot.theta != 0)
