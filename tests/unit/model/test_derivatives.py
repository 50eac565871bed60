"""How `pi` and `phi` change with the base parameters."""

import numpy as np
import pytest
from random_robots import DUAL_ARM, random_planar_robot, random_robot

import orbident as oi
from orbident.model.minimal_sets import minimal_sets

ROBOTS = {
    "paper-spatial": oi.load_robot("paper-spatial"),
    "dual arm": random_robot(1, DUAL_ARM, prismatic=(4,)),
    "planar": random_planar_robot(2, (0, 1)),
}


@pytest.fixture(params=ROBOTS)
def robot(request):
    return ROBOTS[request.param]


def test_pi_and_phi_of_beta_are_those_of_theta(robot):
    sets = minimal_sets(robot)
    pi, phi = sets.pi_and_phi(sets.beta(robot.theta))
    np.testing.assert_allclose(pi, sets.pi(robot.theta), rtol=1e-14)
    np.testing.assert_allclose(phi, sets.phi(robot.theta), rtol=1e-14)


def test_derivatives_by_differences(robot):
    """Through a `theta` for each change of `beta`."""
    sets = minimal_sets(robot)
    beta = sets.beta(robot.theta)
    dpi, dphi = sets.derivatives(beta)
    step = 1e-7 * robot.mass
    for k in range(beta.size):
        direction = sets.base.theta_of[:, k].reshape(robot.theta.shape)
        more, less = (robot.theta + s * step * direction for s in (1, -1))
        for function, found in ((sets.pi, dpi), (sets.phi, dphi)):
            difference = (function(more) - function(less)) / (2 * step)
            # Truncation (1e-7)^2, rounding 1e-16 / 1e-7 of the largest.
            tolerance = 1e-8 * max(
                1.0, np.abs(function(robot.theta)).max() / robot.mass
            )
            np.testing.assert_allclose(found[:, k], difference, rtol=0, atol=tolerance)
