"""No trajectory ever leaves a limit, on a grid a hundred times finer than any used."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_robots import random_planar_robot, random_robot, random_wheels

from orbident.errors import InputError
from orbident.excitation.conditions import Conditions, Limits, conditions_for
from orbident.excitation.design import (
    FINER,
    LIMIT_STEPS,
    LIMIT_STEPS_A_PERIOD,
    design_excitation,
)
from orbident.excitation.guarantee import NODES, floated, proven_within
from orbident.excitation.joint_limits import inner_point, joint_motions, polytope_of
from orbident.robot.description import Robot
from orbident.robot.joint_schema import coupled_joints
from orbident.trajectories.trajectory import Trajectory

# Rounding of coefficients that cancel: of some hundred, to 1e-13.
ROUNDING = 1e-11


class Recipe(NamedTuple):
    """Any limits, ends and duration; made into a robot in the test."""

    seed: int
    planar: bool
    prismatic: bool
    duration: float
    harmonics: int
    far: float
    """How far the ends are from the middle of the limits, of their half range."""

    def robot(self) -> Robot:
        make = random_planar_robot if self.planar else random_robot
        wheels = random_wheels(self.seed, ("held", "free"))
        robot = make(self.seed, (0, 1), (1,) if self.prismatic else (), wheels)
        random = np.random.default_rng(self.seed)
        joints = []
        for joint in robot.joints:
            low, high = np.sort(random.uniform(-3.0, 3.0, 2))
            limits = (float(low), float(high) + 0.2)
            rate = float(random.uniform(0.2, 2.0))
            joints.append(replace(joint, position=limits, velocity=rate))
        return replace(robot, joints=tuple(joints))

    def conditions(self, robot: Robot) -> Conditions:
        random = np.random.default_rng(self.seed + 1)
        given = conditions_for(robot, self.duration, self.harmonics)
        lower, upper = given.limits.position.T
        ends = np.zeros((2, len(lower), 3))
        far = self.far * random.uniform(-1, 1, (2, len(lower)))
        ends[:, :, 0] = (lower + upper) / 2 + far * (upper - lower) / 2
        limits = replace(given.limits, acceleration=given.limits.velocity * 2.0)
        return replace(given, start=ends[0], end=ends[1], limits=limits)


recipes = st.builds(
    Recipe,
    seed=st.integers(0, 999),
    planar=st.booleans(),
    prismatic=st.booleans(),
    duration=st.floats(8.0, 60.0),
    harmonics=st.integers(1, 6),
    far=st.floats(0.0, 0.95),
)


def check(trajectory: Trajectory, limits: Limits) -> None:
    t = np.linspace(0.0, trajectory.duration, 100 * NODES)
    q, qd, qdd = trajectory.at(t)
    lower, upper = limits.position.T
    assert (q >= lower - ROUNDING).all()
    assert (q <= upper + ROUNDING).all()
    assert (np.abs(qd) <= limits.velocity + ROUNDING).all()
    assert (np.abs(qdd) <= limits.acceleration + ROUNDING).all()


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(recipes)
def test_no_motion_that_was_let_through_leaves_a_limit(recipe):
    """Random motions that touch their limits at the nodes, as the search's do."""
    robot = recipe.robot()
    conditions = recipe.conditions(robot)
    steps = FINER * max(LIMIT_STEPS, LIMIT_STEPS_A_PERIOD * conditions.harmonics)
    motions = joint_motions(conditions, coupled_joints(robot), steps + 1)
    polytope = polytope_of(motions, conditions.limits)
    try:
        middle = inner_point(
            polytope, conditions.limits, dict(enumerate(robot.joint_names))
        )
    except InputError:
        return
    direction = np.random.default_rng(recipe.seed).standard_normal(middle.shape)
    y = middle + polytope.reach(middle, direction)[:, None] * direction
    proven = proven_within(robot, conditions, motions, middle, y)
    check(proven.trajectory, conditions.limits)


@settings(max_examples=3, deadline=None)
@given(st.integers(0, 99))
def test_no_design_leaves_a_limit(seed):
    """Whole designs, with limits of the base and of wheels that are free."""
    recipe = Recipe(seed, True, False, 20.0, 2, 0.3)
    robot = recipe.robot()
    conditions = recipe.conditions(robot)
    initial = conditions.initial
    first = float(np.abs(initial.angular_velocity[2]))
    wheels = max(abs(speed) for speed in initial.wheel_speed.values())
    limits = replace(
        conditions.limits, base_rate=first + 0.3, wheel_speed=wheels + 0.25
    )
    conditions = replace(conditions, limits=limits)
    try:
        found = design_excitation(robot, conditions=conditions, starts=1, seed=seed)
    except InputError:
        return
    check(found, limits)
    motion = floated(robot, found)
    assert np.linalg.norm(motion.w, axis=1).max() <= limits.base_rate
    assert np.abs(motion.qd_rw).max() <= limits.wheel_speed
