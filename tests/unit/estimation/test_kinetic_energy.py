"""No robot has negative energy; but for noise an estimate may."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

import orbident as oi
from orbident.estimation.base_parameters import Known
from orbident.estimation.checks import Check
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.parameter_checks import positive_energy
from orbident.estimation.unknowns import DriveFit
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import GearedRotor


@pytest.fixture(scope="module", params=["paper-spatial", "cepheus-like"])
def problem(request: pytest.FixtureRequest) -> MomentumProblem:
    robot = oi.load_robot(request.param)
    planar = robot.motion == "planar"
    start = "spun up" if planar else "turning"
    recording = oi.simulate(robot, random_motion(robot, duration=10.0, start=start))
    known = "at-rest" if planar else "unknown"
    return momentum_problem(robot, recording, known, lambda _: None)


def check(problem: MomentumProblem, factor: float, std: float) -> Check:
    """The check of the energy, with the last inertia so many times as large."""
    beta = problem.sets.beta(problem.robot.theta)
    off = np.where(np.arange(beta.size) == beta.size - 1, factor, 1.0) * beta
    C = np.diag((std * np.abs(beta) + 1e-12) ** 2)
    known = Known(off, C, np.ones(beta.size, dtype=bool))
    (found,) = positive_energy(problem, known, {})
    return found


def test_a_robot_has_positive_energy(problem: MomentumProblem):
    assert check(problem, 1.0, 1e-3).passed


def test_negative_inertia_is_refused(problem: MomentumProblem):
    found = check(problem, -10.0, 1e-3)
    assert found.level == "do not trust"
    assert "no robot has such parameters" in found.reason
    assert found.statistic < found.limit < 0


def test_rotors_that_are_too_large(problem: MomentumProblem):
    """The momentum of one is a part of the last link's, or many times it."""
    robot, beta = problem.robot, problem.sets.beta(problem.robot.theta)
    known = Known(beta, 1e-12 * np.eye(beta.size), np.ones(beta.size, dtype=bool))
    for part, levels in ((0.01, ["trust"]), (10.0, ["trust", "with care"])):
        rotor = GearedRotor(100.0, part * float(beta[-1]) / 100.0)
        geared = replace(robot, rotors={robot.joint_names[-1]: rotor})
        seen = replace(problem, robot=geared, sets=minimal_sets(geared))
        assert [each.level for each in positive_energy(seen, known, {})] == levels


@pytest.mark.parametrize("problem", ["cepheus-like"], indirect=True)
def test_a_rotor_that_turns_against_its_joint_and_torques_showed(
    problem: MomentumProblem,
):
    """Its momentum makes the link's inertia negative, and its energy does not."""
    problem = replace(problem, robot=replace(problem.robot, rotors={}))
    beta = problem.sets.beta(problem.robot.theta)
    beta[-1] *= -2.0
    known = Known(beta, 1e-12 * np.eye(beta.size), np.ones(beta.size, dtype=bool))
    (found,) = positive_energy(problem, known, {})
    assert not found.passed
    armature = DriveFit(1.0, 0.1, *[0.0] * 6)
    drives = {problem.robot.joint_names[-1]: armature}
    (found,) = positive_energy(problem, known, drives)
    assert found.passed


def test_within_its_deviation_it_is_doubtful(problem: MomentumProblem):
    found = check(problem, -10.0, 100.0)
    assert found.level == "with care"
    assert "no robot" not in found.reason


def test_what_is_not_determined_is_not_judged(problem: MomentumProblem):
    beta = problem.sets.beta(problem.robot.theta)
    unknown = np.arange(beta.size) > 0
    C = np.eye(beta.size)
    assert not [*positive_energy(problem, Known(-beta, C, unknown), {})]


def test_links_without_mass(problem: MomentumProblem):
    """Their energy is zero, not negative."""
    light = problem.robot.theta.copy()
    light[1:] = 0.0
    robot = replace(problem.robot, theta=light)
    beta = problem.sets.beta(light)
    C = np.diag(np.full(beta.size, 1e-12))
    known = Known(beta, C, np.ones(beta.size, dtype=bool))
    (found,) = positive_energy(replace(problem, robot=robot), known, {})
    assert found.passed
