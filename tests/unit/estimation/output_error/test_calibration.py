"""Which calibration errors act, and estimates with instruments that have them."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from instruments import Errors, no_errors, shown_with
from small_problems import (
    NOISE,
    Small,
    noisy,
    noisy_in_space,
    small_flight,
    small_problem,
    small_recording,
    small_robot,
    small_robot_in_space,
)

from orbident.estimation.base_parameters import prior_std
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.estimation.output_error.covariance_parts import estimate_of
from orbident.estimation.output_error.problem import linear
from orbident.estimation.output_error.solver import solved
from orbident.estimation.solution import OUTSIDE, Solution
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import Tolerances

Z = np.array([0.0, 0.0, 1.0])
XY = np.array([1.0, 1.0, 0.0])
HALF_A_DEGREE = np.radians(0.5)

JOINT = "joint1"

PLANAR: dict[str, tuple[Tolerances, dict[str, np.ndarray]]] = {
    "encoder's zero": (
        Tolerances(joint_zero={JOINT: 5e-3}),
        {"zero": np.array([5e-3])},
    ),
    "encoder's scale": (
        Tolerances(joint_scale={JOINT: 5e-3}),
        {"scale": np.array([5e-3])},
    ),
    "wheel's inertia": (
        Tolerances(wheel_inertia=1e-2),
        {"wheel": np.array([1e-2])},
    ),
    "marker": (
        Tolerances(feature_point=2e-3),
        {"feature_point": 2e-3 * XY},
    ),
    "attitude": (
        Tolerances(attitude_misalignment=HALF_A_DEGREE),
        {"attitude": HALF_A_DEGREE * Z},
    ),
    "gyro's scale": (
        Tolerances(gyro_scale=5e-3),
        {"gyro_scale": 5e-3 * Z},
    ),
    "position's scale": (
        Tolerances(position_scale=1e-2),
        {"position": np.array([1e-2])},
    ),
    "joint's place": (
        Tolerances(joint_place={JOINT: 2e-3}),
        {"place": 2e-3 * XY},
    ),
    "clock of joints": (
        Tolerances(joint_clock=5e-3),
        {"clock": np.array([5e-3, 0.0, 0.0])},
    ),
    "clock of the attitude": (
        Tolerances(attitude_clock=2e-2),
        {"clock": np.array([0.0, 2e-2, 0.0])},
    ),
    "clock of the position": (
        Tolerances(position_clock=2e-2),
        {"clock": np.array([0.0, 0.0, 2e-2])},
    ),
}
"""What the robot file declares, and the standard deviation of each error."""

SPATIAL: dict[str, tuple[Tolerances, dict[str, np.ndarray]]] = {
    "gyro's misalignment": (
        Tolerances(gyro_misalignment=HALF_A_DEGREE),
        {"gyro": HALF_A_DEGREE * np.ones(3)},
    ),
    "wheels' axes": (
        Tolerances(wheel_axis=HALF_A_DEGREE),
        {"axis": HALF_A_DEGREE * np.ones(9)},
    ),
    "direction of a joint's axis": (
        Tolerances(joint_direction={JOINT: 5e-3}),
        {"direction": 5e-3 * XY},
    ),
    "all": (
        Tolerances(
            joint_zero={JOINT: 5e-3},
            joint_place={JOINT: 2e-3},
            wheel_inertia=1e-2,
            wheel_axis=HALF_A_DEGREE,
            feature_point=2e-3,
            attitude_misalignment=HALF_A_DEGREE,
            gyro_misalignment=HALF_A_DEGREE,
            position_scale=1e-2,
            joint_clock=5e-3,
            attitude_clock=5e-3,
            position_clock=5e-3,
        ),
        {
            "zero": np.array([5e-3]),
            "place": 2e-3 * np.ones(3),
            "wheel": 1e-2 * np.ones(3),
            "axis": HALF_A_DEGREE * np.ones(9),
            "feature_point": 2e-3 * np.ones(3),
            "attitude": HALF_A_DEGREE * np.ones(3),
            "gyro": HALF_A_DEGREE * np.ones(3),
            "position": np.array([1e-2]),
            "clock": 5e-3 * np.ones(3),
        },
    ),
}

SEEDS = 20


def knowing_its_noise(robot: Robot) -> Robot:
    """Here the noise is not to be estimated."""
    walk = NOISE["gyro"] * np.sqrt(0.05)
    sensors = {
        "gyro": {"angle_random_walk": walk},
        "attitude": {"angle": NOISE["attitude"]},
        "position": {"std": NOISE["position"]},
    }
    return replace(robot, sensors=declared_sensors(sensors))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return knowing_its_noise(small_robot())


@pytest.fixture(scope="module")
def recording(robot) -> Recording:
    return small_recording(robot)


def drawn(robot: Robot, stds: dict[str, np.ndarray], seed: int) -> Errors:
    random = np.random.default_rng(seed)
    errors = {
        name: std * random.standard_normal(std.size) for name, std in stds.items()
    }
    return replace(no_errors(robot), **errors)


def most_likely(small: Small) -> Solution:
    solution = solved(small.problem, small.problem.weights, small.prior, small.state)
    assert solution.converged
    return solution


def ratio(small: Small, solution: Solution) -> float:
    """Chi-square where `beta` is the true one, less that of the solution."""
    problem, prior, _, beta = small
    std = prior.std.copy()
    std[OUTSIDE : OUTSIDE + beta.size] *= 1e-9
    true = most_likely(small._replace(prior=prior._replace(std=std)))
    wide = prior._replace(std=np.where(std < prior.std, np.inf, std))
    there, here = (
        linear(problem, problem.weights, each.state).cost + wide.cost(each.state)
        for each in (true, solution)
    )
    return there - here


class Trial(NamedTuple):
    """Estimates with and without the tolerances, from instruments that are off."""

    z: list[np.ndarray]
    """Errors of `beta` over their deviations."""
    ratios: list[float]
    undeclared: list[float]
    """The largest error over its deviation, without tolerances."""


def trial(robot, tolerances, stds, noisy) -> Trial:
    declared = replace(robot, tolerances=tolerances)
    scale = prior_std(robot, minimal_sets(robot))
    found = Trial([], [], [])
    for seed in range(SEEDS):
        errors = drawn(robot, stds, seed)
        true = small_flight(errors.robot(robot))
        shown = noisy(shown_with(errors, robot, true), seed)
        small, exact = small_problem(declared, shown), small_problem(robot, shown)
        solution = most_likely(small)
        estimates = [estimate_of(s, scale) for s in (solution, most_likely(exact))]
        assert not any(each.hidden.size for each in estimates)
        z, z_undeclared = (
            (each.values - small.beta) / np.sqrt(np.diag(each.covariance))
            for each in estimates
        )
        found.z.append(z)
        found.ratios.append(ratio(small, solution))
        found.undeclared.append(float(np.abs(z_undeclared).max()))
    return found


def check(trial: Trial) -> None:
    """Every parameter is within its deviations; without the tolerance it is not.

    An error that is known to a percent, in data that are good to 1e-4, bends: the true
    parameters are compared by what they cost, which no bend changes.
    """
    dof = trial.z[0].size
    # The mean of 20 chi-squares.
    assert abs(np.mean(trial.ratios) - dof) < 3.5 * np.sqrt(2 * dof / SEEDS)
    # 140 to 340 numbers, correlated: beyond 4.5 with a probability below 0.003.
    assert np.abs(trial.z).max() < 4.5
    assert np.median(trial.undeclared) > 4.5


def kinds(every: dict[str, Any]) -> list[Any]:
    """All at once; `pytest -m long` has each by itself."""
    long = pytest.mark.long
    return [kind if kind == "all" else pytest.param(kind, marks=long) for kind in every]


@pytest.mark.parametrize("kind", kinds(PLANAR))
def test_declared_errors_are_in_the_deviations(robot, kind):
    check(trial(robot, *PLANAR[kind], noisy))


@pytest.mark.slow
@pytest.mark.parametrize("kind", kinds(SPATIAL))
def test_declared_errors_in_space(kind):
    robot = knowing_its_noise(small_robot_in_space())
    check(trial(robot, *SPATIAL[kind], noisy_in_space))


def test_errors_that_have_tolerances_are_estimated(robot, recording):
    """A scale of the position that other sensors contradict: the velocity's."""
    declared = replace(robot, tolerances=Tolerances(position_scale=1e-2))
    errors = replace(no_errors(robot), position=np.array([0.02]))
    small = small_problem(declared, noisy(shown_with(errors, robot, recording), 0))
    solution = most_likely(small)
    std = np.sqrt(solution.covariance[-1, -1])
    assert std < 5e-4
    assert abs(solution.state.calibration[0] - 0.02) < 4 * std


def test_without_tolerances_nothing_is_an_unknown(robot, recording):
    small = small_problem(robot, recording)
    assert small.state.selected.size == 0
    assert small.state.common.size == OUTSIDE + small.beta.size
    np.testing.assert_array_equal(small.state.beta, small.beta)


def test_which_errors_act():
    """Errors are in the core's order; in the plane those about z, or along x and y."""
    robot = load_robot("cepheus-like")
    found = {c.name: c for c in calibrations_of(robot, {"attitude", "position"})}
    assert list(found) == [
        "joint.joint1.zero",
        "joint.joint2.zero",
        "joint.joint1.scale",
        "joint.joint2.scale",
        "wheel.rw.inertia",
        "feature_point.x",
        "feature_point.y",
        "attitude.misalignment.z",
        "position.scale",
        "joints.clock",
        "position.clock",
        "joint.joint1.place.x",
        "joint.joint1.place.y",
        "joint.joint2.place.x",
        "joint.joint2.place.y",
    ]
    places = [each.place for each in found.values()]
    assert places == [0, 1, 2, 3, 4, 8, 9, 13, 20, 21, 23, 24, 25, 27, 28]
    assert found["joint.joint1.zero"].unit == "rad"
    assert found["feature_point.x"].unit == "m"
    gyro = {c.name for c in calibrations_of(robot, {"gyro"})} - set(found)
    assert gyro == {"gyro.scale.z"}
    # Behind that of the gyro: alone, an attitude is the measure itself.
    both = {c.name for c in calibrations_of(robot, {"attitude", "gyro"})}
    assert "attitude.clock" in both
    assert found["joints.clock"].unit == "s"
    spatial = calibrations_of(load_robot("paper-spatial"), {"gyro", "velocity"})
    assert sum(c.name.startswith("gyro.misalignment") for c in spatial) == 3
    assert sum(c.name.startswith("feature_point") for c in spatial) == 3
    # About its own axis, a wheel that is turned is as it was.
    of_wheel = {c.name for c in spatial if c.name.startswith("wheel.rw_x.axis")}
    assert of_wheel == {"wheel.rw_x.axis.y", "wheel.rw_x.axis.z"}
    # About its own axis, a joint that is turned has another zero.
    of_axis = {c.name for c in spatial if c.name.startswith("joint.joint1.direction")}
    assert of_axis == {"joint.joint1.direction.x", "joint.joint1.direction.y"}
