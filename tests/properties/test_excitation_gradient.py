"""The gradient of the criterion and of the limits, on any tree, by differences."""

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from random_robots import random_planar_robot, random_robot, random_wheels

from orbident.excitation.conditions import Conditions, conditions_for
from orbident.excitation.criterion import Objective
from orbident.excitation.design_problem import problem_for
from orbident.robot.description import AtRest, Robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import CALIBRATION_KINDS, Tolerances

pytestmark = pytest.mark.core

STEP = 1e-3
"""Step for the criterion, which is smooth."""

ASIDE = 1e-13
"""A step that changes nothing but how the criterion is rounded."""

LIMITS_STEP = 1e-6
"""Step for the largest use of a limit, which bends where another node uses more."""


class Recipe(NamedTuple):
    """Any tree, wheel modes and objective; made into a robot in the test."""

    seed: int
    planar: bool
    sliding: tuple[int, ...]
    massless: bool
    uncertainty: float
    objective: Objective
    off: bool
    """Whether instruments and geometry may be off, in every way."""

    def robot(self) -> Robot:
        make = random_planar_robot if self.planar else random_robot
        wheels = random_wheels(self.seed, ("held", "free"))
        robot = make(self.seed, (0, 1, 0), self.sliding, wheels)
        joints = tuple(
            replace(joint, position=None, velocity=1.0) for joint in robot.joints
        )
        theta = robot.theta.copy()
        if self.massless:
            theta[2] = 0.0
        sensors = {
            "rate": 10.0,
            "gyro": {"angle_random_walk": 1e-4},
            "accelerometer": {"velocity_random_walk": 1e-3},
            "attitude": {"angle": 1e-3},
            "position": {"std": 1e-3},
        }
        return replace(
            robot,
            tolerances=every_tolerance(robot) if self.off else Tolerances(),
            joints=joints,
            theta=theta,
            sensors=declared_sensors(sensors),
            # What may act has gradients good to its quadrature, tested by itself.
            disturbances={},
            at_rest=AtRest(0.0, 0.0),
        )

    def conditions(self, robot: Robot) -> Conditions:
        given = conditions_for(robot, 5.0, 2)
        rate = 2 * float(np.linalg.norm(given.initial.angular_velocity)) + 1.0
        limits = replace(given.limits, base_rate=rate, excursion=2.0, wheel_speed=250.0)
        return replace(given, limits=limits)


def every_tolerance(robot: Robot) -> Tolerances:
    """Of every kind; wide, so that each counts beside the sensors' noise."""
    each = dict.fromkeys(robot.joint_names, 0.02)
    stds: dict[str, Any] = {
        name: each if kind.name.startswith("joint.") else 0.02
        for name, kind in CALIBRATION_KINDS.items()
    }
    return Tolerances(**stds)


recipes = st.builds(
    Recipe,
    seed=st.integers(0, 999),
    planar=st.booleans(),
    sliding=st.sampled_from([(), (1,), (0, 2)]),
    massless=st.booleans(),
    uncertainty=st.sampled_from([0.0, 0.1]),
    objective=st.sampled_from(["cond", "d", "a"]),
    off=st.booleans(),
)


@pytest.mark.slow
@settings(max_examples=3, deadline=None)
@given(recipes)
# Each objective, and all that may be off, are in whatever is drawn.
@example(Recipe(78, False, (), True, 0.1, "d", False))
@example(Recipe(423, False, (), True, 0.0, "a", False))
@example(Recipe(999, True, (0, 2), True, 0.0, "a", True))
def test_gradients_by_differences(recipe):
    robot = recipe.robot()
    problem = problem_for(
        robot, recipe.conditions(robot), recipe.objective, recipe.uncertainty
    )
    random = np.random.default_rng(recipe.seed)
    shape = len(robot.joints), problem.motions.basis[0].shape[1]
    y, direction = 0.3 * random.standard_normal((2, *shape))

    @cache
    def differences(step: float) -> np.ndarray:
        more, less = (problem.evaluate(y + s * step * direction, 4.0) for s in (1, -1))
        return np.append(more.smooth - less.smooth, more.used - less.used) / (2 * step)

    def extrapolated(step: float) -> np.ndarray:
        # Richardson: what is left of the truncation is of fourth order.
        return (4 * differences(step / 2) - differences(step)) / 3

    coarse, expected = extrapolated(STEP)[0], extrapolated(STEP / 2)[0]
    candidate = problem.evaluate(y, 4.0)
    found = (candidate.gradient * direction).sum()
    # What differences leave open: their truncation, and the rounding of the criterion
    # itself, which no motion of the joints as small as this changes otherwise.
    beside = [problem.evaluate(y + k * ASIDE * direction, 4.0) for k in range(5)]
    rounding = np.ptp([each.smooth for each in beside]) / STEP
    # The condition number is the root of the eigenvalues' spread, and the gradient of
    # some random robots has fewer digits than six.
    spread = np.exp(2 * candidate.smooth) if recipe.objective == "cond" else 1.0
    digits = max(1e-6, 1e-16 * spread)
    left = max(digits * abs(expected), abs(coarse - expected)) + 6 * rounding
    assert found == pytest.approx(expected, rel=0, abs=left)
    assert (candidate.used_gradient * direction).sum(axis=(1, 2)) == pytest.approx(
        extrapolated(LIMITS_STEP)[1:], rel=1e-6, abs=1e-7
    )
