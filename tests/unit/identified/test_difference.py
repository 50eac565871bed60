"""Results with different structures, told in the same parameters."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import exact_result, known, made_result
from random_robots import DUAL_ARM, random_planar_robot, random_robot

from orbident.identified.difference import determined_combinations, difference_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import Structure

STRUCTURES = (
    Structure(),
    Structure(com_on_axis="y"),
    Structure(principal_axes=True),
    Structure(com_on_axis="x", principal_axes=True),
)


def obeying(robot: Robot, random: np.random.Generator) -> Robot:
    """A random `theta`, of no body that can exist, with what is known of it."""
    theta = np.zeros(robot.theta.size)
    free = list(robot.free_parameters)
    theta[free] = random.standard_normal(len(free))
    return replace(robot, theta=theta.reshape(robot.theta.shape))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_any_two_structures(seed, motion):
    """`d` is what `T_c` makes of the difference of any two `theta`."""
    make = random_planar_robot if motion == "planar" else random_robot
    robot = make(seed, DUAL_ARM, prismatic=[seed])
    random = np.random.default_rng(seed)
    com = "xyz"[seed % 3]
    pair = []
    for _ in range(2):
        chosen = {
            body: replace(each, com_on_axis=com if each.com_on_axis else None)
            for body in robot.bodies[1:]
            for each in [STRUCTURES[random.integers(4)]]
        }
        pair.append(obeying(known(robot, **chosen), random))
    before, after = pair
    found = difference_of(exact_result(before, 1), exact_result(after, 2))
    change = (after.theta - before.theta).ravel()
    # Both sides are over deviations of 1e-9 of the mass: sums of 70 terms of order 1.
    expected = found.T @ change
    size = np.abs(found.T).max() * np.abs(change).max()
    np.testing.assert_allclose(found.d, expected, rtol=0, atol=1e-12 * size)
    assert found.d.size == len(found.T_c)


def test_white():
    """`W e` has the length of `e` in deviations, however these differ in size."""
    robot = random_robot(1, (0, 1))
    random = np.random.default_rng(0)
    n = len(minimal_sets(robot).base.T)
    std = 10.0 ** random.uniform(-6, 3, n)
    root = np.diag(std) @ (np.eye(n) + 0.2 * random.standard_normal((n, n)))
    beta = np.zeros(n)
    a, b = (made_result(robot, beta, k * root @ root.T) for k in (0.3, 0.7))
    noise = root @ random.standard_normal((n, 50))
    lengths = []
    for e in noise.T:
        found = difference_of(a, made_result(robot, e, b.base_covariance))
        lengths.append(np.sum((found.W @ found.d) ** 2))
    # Mahalanobis lengths do not depend on the root that was taken.
    expected = np.einsum("ik,ik->k", noise, np.linalg.solve(root @ root.T, noise))
    np.testing.assert_allclose(lengths, expected, rtol=1e-6)


def test_shown():
    """A column of its own, two that are equal, one of zeros."""
    X = np.array([[1e3, 2.0, 2.0, 0.0], [0.0, 1e-3, 1e-3, 0.0], [0, 0, 0, 0]])
    V, alone = determined_combinations(X)
    assert alone.tolist() == [True, False, False, False]
    assert V.shape == (4, 2)
    assert np.linalg.matrix_rank(X @ V) == 2
    assert determined_combinations(np.zeros((0, 3)))[1].tolist() == [False] * 3
