import numpy as np
from random_robots import DUAL_ARM, random_robot

from orbident.dynamics.tree import tree_of


def test_a_joint_moves_all_that_is_below_it():
    """Two arms of three: joints 0, 1, 2 and 3, 4, 5."""
    arm = np.array([[1, 1, 1], [0, 1, 1], [0, 0, 1]])
    expected = np.zeros((6, 7))
    expected[:3, 1:4] = expected[3:, 4:] = arm
    tree = tree_of(random_robot(0, DUAL_ARM))
    np.testing.assert_array_equal(tree.moves, expected)
    np.testing.assert_array_equal(tree.parent, DUAL_ARM)


def test_branches_in_any_topological_order():
    tree = tree_of(random_robot(0, (0, 0, 1, 2, 1)))
    below = [set(np.flatnonzero(row)) for row in np.asarray(tree.moves)]
    assert below == [{1, 3, 5}, {2, 4}, {3}, {4}, {5}]


def test_kinds_and_geometry_are_the_joints():
    robot = random_robot(0, (0, 1, 0), prismatic=(1,))
    tree = tree_of(robot)
    np.testing.assert_array_equal(tree.revolute, [1, 0, 1])
    for k, joint in enumerate(robot.joints):
        np.testing.assert_array_equal(tree.axis[k], joint.axis)
        np.testing.assert_array_equal(tree.R_PJ[k], joint.R_PJ)
        np.testing.assert_array_equal(tree.p_PJ[k], joint.p_PJ)


def test_no_joints_still_have_shapes():
    tree = tree_of(random_robot(0, ()))
    shapes = [tree.axis.shape, tree.R_PJ.shape, tree.p_PJ.shape, tree.moves.shape]
    assert shapes == [(0, 3), (0, 3, 3), (0, 3), (0, 1)]
    assert tree.parent.dtype == np.int64
