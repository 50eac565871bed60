"""A scene shows every body and every wheel of any robot."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from random_robots import DUAL_ARM, random_robot, random_wheels

from orbident.robot.parameters import PER_BODY, from_mass_com_inertia
from orbident.robot.robot_file import bundled_robots, load_robot
from orbident.scene.replay import MotionHistory, placed
from orbident.scene.scene import Scene, made_shapes, robot_size, scene_of
from orbident.scene.shapes import BASE

BASE_LINK = (
    '<link name="base"><inertial><mass value="10"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
)


def frames(scene: Scene) -> set[int]:
    return {shape.frame for shape in scene.shapes}


@pytest.mark.parametrize("name", bundled_robots())
def test_bundled_robots(name: str):
    robot = load_robot(name)
    scene = scene_of(robot)
    assert frames(scene) == set(range(len(robot.bodies) + len(robot.wheels)))
    assert scene.warnings == ()


def test_a_robot_without_pictures():
    robot = random_robot(1, DUAL_ARM, wheels=random_wheels(1, ["held", "held", "free"]))
    scene = scene_of(robot)
    assert frames(scene) == set(range(len(robot.bodies) + len(robot.wheels)))
    for shape in scene.shapes:
        assert np.isfinite(shape.vertices).all()
        assert np.abs(shape.vertices).max() < 5 * scene.size


def test_massless_and_single_bodies():
    robot = random_robot(2, (0, 1))
    nothing = replace(robot, theta=np.zeros((3, PER_BODY)))
    assert all(made_shapes(nothing, body, 1.0) for body in range(3))
    alone = random_robot(3, ())
    assert frames(scene_of(alone)) == {0}
    point = from_mass_com_inertia(1.0, np.zeros(3), np.zeros((3, 3)))
    assert robot_size(replace(alone, theta=point[None])) == 1.0


@pytest.mark.parametrize("turned", [False, True])
def test_the_base_is_the_box_with_its_inertia(turned: bool):
    a, b, c, m = 0.4, 0.6, 1.1, 30.0
    I = m / 12 * np.diag([b**2 + c**2, a**2 + c**2, a**2 + b**2])
    R = np.eye(3)
    if turned:
        R = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
        R *= np.linalg.det(R)
    com = np.array([0.1, -0.2, 0.3])
    theta = from_mass_com_inertia(m, com, R @ I @ R.T)[None]
    (box,) = made_shapes(replace(random_robot(0, ()), theta=theta), 0, 1.0)
    corners = (box.vertices - com) @ R
    assert np.allclose(np.abs(corners), [a / 2, b / 2, c / 2], atol=1e-9)
    assert box.colour == BASE


def test_a_wheel_that_is_a_joint_turns_with_what_is_fixed_to_it(tmp_path: Path):
    (tmp_path / "r.urdf").write_text(
        f'<robot name="r">{BASE_LINK}'
        '<link name="rotor"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" '
        'ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
        '<visual><geometry><cylinder radius="0.2" length="0.1"/></geometry></visual>'
        '</link><link name="mark"><visual><geometry><box size="0.1 0.1 0.1"/>'
        '</geometry></visual></link><joint name="spin" type="continuous">'
        '<parent link="base"/><child link="rotor"/><origin xyz="0.3 0 0" '
        'rpy="0 1.5707963267948966 0"/><axis xyz="0 0 1"/></joint>'
        '<joint name="glue" type="fixed"><parent link="rotor"/><child link="mark"/>'
        '<origin xyz="0.2 0 0"/></joint></robot>'
    )
    (tmp_path / "r.yaml").write_text(
        "schema: orbident/robot/1\nurdf: r.urdf\nfeature_point: [0, 0, 0.5]\n"
        "wheels:\n- {joint: spin}\n"
    )
    robot = load_robot(tmp_path / "r.yaml")
    scene = scene_of(robot)
    assert [shape.frame for shape in scene.shapes].count(1) == 2
    none = np.zeros((2, 3))
    x_WB = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    q, qd_rw = np.zeros((2, 0)), np.zeros((2, 1))
    still = MotionHistory(np.arange(2.0), q, q, x_WB, none, none, none, qd_rw)
    at = placed(scene, still, np.array([[0.0], [np.pi / 2]]))
    mark = next(s for s in scene.shapes if s.frame == 1 and len(s.vertices) == 8)
    middle = mark.vertices.mean(axis=0)
    before, after = (at.R[k, 1] @ middle + at.p[k, 1] for k in (0, 1))
    # About base x, at [0.3, 0, -0.5] from S: the rotor's x is base -z, then base y.
    assert np.allclose(before, [0.3, 0, -0.7], atol=1e-12)
    assert np.allclose(after, [0.3, 0.2, -0.5], atol=1e-12)
