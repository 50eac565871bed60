"""Any robot, for hypothesis: joints that slide, massless links, wheels, the plane."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_wheels,
)

from orbident.robot.description import Robot

Z = np.array([0.0, 0.0, 1.0])


class Tree(NamedTuple):
    """A robot, and random numbers that go with it."""

    robot: Robot
    random: np.random.Generator


SHAPES = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10**6),
        "joints": st.integers(0, 5),
        "wheels": st.integers(0, 3),
        "planar": st.booleans(),
        "massless": st.booleans(),
    }
)
"""What `tree_of` takes."""


def tree_of(seed: int, joints: int, wheels: int, planar: bool, massless: bool) -> Tree:
    """About a third of the joints slide; one that carries another may be massless."""
    random = np.random.default_rng(seed)
    parents = random_parents(random, joints)
    sliding = np.flatnonzero(random.random(joints) < 1 / 3).tolist()
    modes = random.choice(["held", "free"], wheels).tolist()
    rotors = random_wheels(seed, modes)
    if planar:
        rotors = tuple(replace(wheel, axis=Z) for wheel in rotors)
    made = random_planar_robot if planar else random_robot
    robot = made(seed, parents, sliding, rotors)
    theta = robot.theta.copy()
    carriers = [parent for parent in parents if parent > 0]
    if massless and carriers:
        theta[carriers[0]] = 0.0
    return Tree(replace(robot, theta=theta), random)
