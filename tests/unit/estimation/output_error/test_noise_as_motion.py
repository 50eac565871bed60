"""What noise of encoders shows, against many draws of stacked equations."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from small_problems import SPIN, Small, noisy, small_problem, small_robot
from test_solving import dense

from orbident.estimation.output_error.covariance_parts import covariance_parts
from orbident.estimation.output_error.noise_as_motion import NoiseAsMotion
from orbident.estimation.output_error.problem import linear
from orbident.estimation.output_error.solver import solution_at
from orbident.estimation.solution import Solution
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.simulate import simulate

DRAWS = 10

LIKE = 0.1
"""Part of a deviation: one draw in place of many."""


NOISE = 1e-3
"""rad, of an encoder."""

POOR = 100.0
"""Times as noisy are sensors of the base, which else show how the joint moves."""


def small_with(part: float) -> tuple[Small, Solution]:
    """Where joints move so little, and the linearised equations at the start."""
    declared = declared_sensors({"rate": 10.0, "joints": {"position": NOISE}})
    robot = replace(small_robot(), sensors=declared)
    motion = random_motion(robot, 1, 20.0, SPIN, "spun up")
    motion = replace(motion, a=part * motion.a, b=part * motion.b)
    recording = noisy(simulate(robot, motion), 0)
    (joint,) = robot.joint_names
    column, random = f"joint.{joint}.position", np.random.default_rng(1)
    q = recording.column(column) + NOISE * random.standard_normal(recording.t.size)
    columns = {
        name: x for name, x in recording.columns.items() if not name.startswith("joint")
    }
    small = small_problem(robot, replace(recording, columns={**columns, column: q}))
    weights = {
        name: table if name == "joints" else table / POOR
        for name, table in small.problem.weights.items()
    }
    small = small._replace(problem=small.problem._replace(weights=weights))
    here = linear(small.problem, weights, small.state)
    return small, solution_at(small.state, here, small.prior, weights, True, 0.0)


@pytest.fixture(scope="module")
def hardly_moving() -> tuple[Small, Solution]:
    return small_with(0.008)


def of_common(solution: Solution) -> np.ndarray:
    """The covariance of what all intervals have in common."""
    local = solution.linear.local
    return solution.covariance[local:, local:]


def test_where_joints_move_far_it_is_nothing():
    small, solution = small_with(1.0)
    assert NoiseAsMotion(small.problem, solution).weakened is solution


def test_it_is_that_of_many_draws(hardly_moving):
    """`(I - N)^-1 I (I - N)^-1`, with the prior in `I`."""
    (problem, prior, state, _), solution = hardly_moving
    n, random = state.common.size, np.random.default_rng(2)

    def parts(state) -> tuple[np.ndarray, np.ndarray]:
        A = dense(problem, state).A
        return A[:, :-n], A[:, -n:]

    def information(state) -> np.ndarray:
        A_z, A_g = parts(state)
        left = A_g - A_z @ np.linalg.lstsq(A_z, A_g)[0]
        return left.T @ left

    A_z, _ = parts(state)
    size = np.linalg.norm(A_z, axis=0)
    root = np.linalg.inv(np.linalg.qr(A_z / size, mode="r")) / size[:, None]
    N = -information(state)
    for _ in range(DRAWS):
        e = (root @ random.standard_normal(len(root))).reshape(state.local.shape)
        for side in (e, -e):
            N += information(state.moved(side, np.zeros(n))) / (2 * DRAWS)
    known = information(state) + np.diag(prior.std**-2.0)
    gain = np.linalg.inv(known - N)
    expected = np.sqrt(np.diag(gain @ known @ gain))
    found = np.sqrt(np.diag(of_common(NoiseAsMotion(problem, solution).weakened)))
    naive = np.sqrt(np.diag(of_common(solution)))
    assert np.max(expected / naive) > 1.1
    assert np.abs(found / expected - 1).max() < LIKE


def test_what_noise_shows_nearly_all_of_is_not_known():
    small, solution = small_with(0.004)
    found = of_common(NoiseAsMotion(small.problem, solution).weakened)
    wider = np.sqrt(np.diag(found) / np.diag(of_common(solution)))
    assert wider.max() > 5
    # What does not need the joint is as well known as before.
    assert wider.min() < 1.01


def test_the_parts_add_up_to_the_covariance(hardly_moving):
    small, solution = hardly_moving
    found = covariance_parts(small.problem, solution)
    weakened = NoiseAsMotion(small.problem, solution).weakened
    beta = slice(9, 9 + small.beta.size)
    whole = of_common(weakened)[beta, beta]
    std = np.sqrt(np.diag(whole))
    total = np.sum([each.part for each in found.values()], axis=0)
    assert np.abs((total - whole) / np.outer(std, std)).max() < 1e-6
