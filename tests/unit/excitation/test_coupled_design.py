"""Joints that follow others do so in a design, within their own limits too."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.excitation.conditions import conditions_for, limits_of
from orbident.excitation.criterion import basis_of
from orbident.excitation.design import design_excitation
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Coupling, Robot
from orbident.robot.robot_file import load_robot


def coupled(factor: float = -2.0, offset: float = 0.3) -> Robot:
    """Its second joint follows the first: from -0.55 to 1.195 rad of [-2.09, 1.4]."""
    robot = load_robot("cepheus-like")
    return replace(robot, couplings=(Coupling("joint2", "joint1", factor, offset),))


def test_limits_of_the_leader_hold_those_of_its_follower():
    limits = limits_of(coupled())
    # (1.4 - 0.3) / -2 and (-2.09 - 0.3) / -2; 0.5 rad/s of the follower.
    np.testing.assert_allclose(limits.position[0], [-0.55, 1.195], rtol=1e-15)
    assert limits.velocity[0] == 0.25
    with pytest.raises(InputError, match="limits of 'joint2', which follows it, leave"):
        limits_of(coupled(offset=30.0))


def test_the_ends_follow():
    conditions = conditions_for(coupled(), 10.0)
    np.testing.assert_array_equal(conditions.start, [[0, 0, 0], [0.3, 0, 0]])


def test_a_design():
    robot = coupled()
    found = design_excitation(robot, 20.0, starts=1)
    q, qd, _ = found.at(np.linspace(0.0, 20.0, 101))
    # Rounding of coefficients that are hundreds of times the motion.
    np.testing.assert_allclose(q[:, 1], 0.3 - 2 * q[:, 0], atol=1e-10)
    np.testing.assert_allclose(qd[:, 1], -2 * qd[:, 0], atol=1e-10)
    assert np.ptp(q[:, 0]) > 0.5
    # What does not show when the two move as one is no part of the criterion.
    assert found.design is not None
    assert found.design["value"] < 1e3


def test_the_criterion_counts_what_coupled_joints_show():
    robot = coupled()
    sets = minimal_sets(robot)
    alone = basis_of(load_robot("cepheus-like"), sets).pi_of
    np.testing.assert_array_equal(alone, np.eye(len(alone)))
    assert basis_of(robot, sets).pi_of.shape[1] < len(alone)
