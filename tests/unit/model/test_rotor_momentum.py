"""What momentum sees of geared rotors: no more than the links they are between."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import exact_result
from random_robots import random_robot, random_wheels

from orbident.model.core_robot import (
    lacking_rotors,
    rotor_directions,
    rotors_of,
    theta_with_rotors,
    undeclared_rotors,
    with_armatures,
)
from orbident.model.formulas import formulas_of, not_identifiable
from orbident.model.kinematics import inertia, momentum_regressors, poses
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import NO_ROTOR, Coupling, GearedRotor, Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import TorqueSpec

SAMPLES = 40

ROTOR = GearedRotor(100.0, 1e-4, 0.2)

ROUNDING = 1e-12
"""Of sums of some tens of products, over the largest entry."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    """A branching arm, one joint of which slides."""
    wheels = random_wheels(0, ("held",))
    return random_robot(3, (0, 1, 1, 3), prismatic=(2,), wheels=wheels)


def motion(robot: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    q, qd = random.standard_normal((2, SAMPLES, len(robot.joints)))
    return q, qd, random.standard_normal((SAMPLES, 3))


def test_their_momentum_is_that_of_other_links(robot):
    """`N J qd a` is `A` of the direction; no rank is added to all of momentum."""
    q, qd, w = motion(robot)
    at = momentum_regressors(robot, q, qd, w)
    rank = np.linalg.matrix_rank(at.A.reshape(3 * SAMPLES, -1))
    for k, direction in enumerate(rotor_directions(robot)):
        column = qd[:, k, None] * poses(robot, q).field_w[:, k]
        found = at.A @ direction
        np.testing.assert_allclose(found, column, rtol=0, atol=10 * ROUNDING)
        assert not np.any(at.P @ direction)
        both = np.column_stack([at.A.reshape(3 * SAMPLES, -1), column.ravel()])
        assert np.linalg.matrix_rank(both) == rank


def test_nothing_but_the_joints_feels_them(robot):
    """`D` is as without; `D_q` has `N J a`, and `D_qq` `N^2 J` on its diagonal."""
    q, _, _ = motion(robot)
    geared = replace(robot, rotors={"joint2": ROTOR})
    without, found = inertia(robot, q), inertia(geared, q)
    a = poses(robot, q).field_w[:, 1]
    momentum = ROTOR.gear * ROTOR.inertia
    np.testing.assert_allclose(found.D, without.D, rtol=ROUNDING, atol=ROUNDING)
    more = found.D_q - without.D_q
    np.testing.assert_allclose(more[:, :, 1], momentum * a, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(more[:, :, [0, 2, 3]], 0, atol=ROUNDING)
    own = (found.D_qq - without.D_qq)[:, 1, 1]
    np.testing.assert_allclose(own, ROTOR.gear * momentum, rtol=1e-9)


def test_base_parameters_are_those_that_momentum_sees(robot):
    geared = replace(robot, rotors={"joint1": ROTOR, "joint2": ROTOR})
    sets, plain = minimal_sets(geared), minimal_sets(robot)
    beta = sets.beta(robot.theta)
    np.testing.assert_array_equal(beta, plain.beta(theta_with_rotors(geared)))
    np.testing.assert_allclose(sets.beta(sets.theta(beta)), beta, rtol=1e-9, atol=1e-9)


def test_no_rotor_has_less_than_nothing(robot):
    """What torques show below zero is none, as well known as before."""
    found = with_armatures(robot, {"joint1": (-0.1, 0.2), "joint2": (0.3, 0.06)})
    of_A = rotors_of(found)
    np.testing.assert_allclose(of_A.armature, [0, 0.3, 0, 0], rtol=0, atol=1e-8)
    std = of_A.tolerance * of_A.armature
    np.testing.assert_allclose(std, [0.2, 0.06, 0, 0], rtol=1e-12)


def test_formulas_name_the_rotors():
    robot = replace(load_robot("paper-spatial"), rotors={})
    sets = minimal_sets(robot)
    words = formulas_of(robot, sets).base.formulas
    assert "4 m(link3) + Iyy(link2) + rotor(joint2) - rotor(joint3)" in words
    (first, *_) = not_identifiable(robot, sets)
    assert first.startswith("the rotors of geared motors, if 'joint1', 'joint2'")
    assert "torques" not in first
    with_torques = robot.sensors.model_copy(update={"torques": TorqueSpec(std=0.1)})
    told = replace(robot, sensors=with_torques)
    first = not_identifiable(told, minimal_sets(told))[0]
    assert "torques show gear * (gear - 1) times inertia too" in first
    declared = replace(robot, rotors={"joint1": NO_ROTOR, "joint2": ROTOR})
    words = formulas_of(declared, sets).base.formulas
    assert "4 m(link3) + Iyy(link2) + rotor(joint2) - rotor(joint3)" in words
    assert not any("rotor(joint1)" in formula for formula in words)
    assert "of 'joint3', which" in lacking_rotors(declared)


def test_who_may_have_one(robot):
    """Not what slides or follows, and not where it is said that there is none."""
    assert undeclared_rotors(robot) == ("joint1", "joint2", "joint4")
    follows = replace(robot, couplings=(Coupling("joint4", "joint1", 1.0, 0.0),))
    assert undeclared_rotors(follows) == ("joint1", "joint2")
    none = dict.fromkeys(robot.joint_names, NO_ROTOR)
    assert lacking_rotors(replace(robot, rotors=none)) == ""


def test_links_alone_are_less_sure():
    """A rotor is taken out, its tolerance put in: where two cancel too."""
    plain = replace(load_robot("paper-spatial"), rotors={})
    robot = replace(plain, rotors={"joint2": ROTOR, "joint3": ROTOR})
    result = exact_result(robot)
    links, own = result.links, minimal_sets(plain).beta(robot.theta)
    at = [result.base.names.index(name) for name in links.names]
    np.testing.assert_allclose(links.values, own[at], rtol=1e-12)
    both = links.formulas.index("4 m(link3) + Iyy(link2)")
    off = ROTOR.tolerance * ROTOR.gear * ROTOR.inertia
    assert links.std[both] == pytest.approx(np.sqrt(2) * off)
    assert not exact_result(plain).links.names
