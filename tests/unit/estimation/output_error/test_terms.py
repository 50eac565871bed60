"""The inertia's terms and their derivatives, against automatic differentiation."""

from functools import partial

import jax
import numpy as np
import pytest
from random_robots import DUAL_ARM, random_planar_robot, random_robot

from orbident.dynamics.free_floating import Terms
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.estimation.output_error.terms import Body, JointState, expanded
from orbident.regressors.minimal_sets import minimal_sets

ROBOTS = {
    "dual arm with slides": random_robot(1, DUAL_ARM, prismatic=(2, 4)),
    "one slide": random_robot(3, (0,), prismatic=(0,)),
    "planar": random_planar_robot(4, (0, 1, 0), prismatic=(2,)),
}
ROUNDING = 1e-12
"""Of sums of some hundred products of numbers of the order of 10."""


def obvious(body: Body, beta, q, qd) -> Terms:
    at = inertia(body.tree, (body.theta_of @ beta).reshape(-1, 10), q)
    return Terms(at.D, at.D_q @ qd, at.r_cm, at.J_cm @ qd)


@pytest.mark.parametrize("name", ROBOTS)
def test_terms_and_their_derivatives(name):
    robot = ROBOTS[name]
    sets, random, n = minimal_sets(robot), np.random.default_rng(0), len(robot.joints)
    body, beta = Body(tree_of(robot), sets.base.theta_of), sets.beta(robot.theta)
    q, qd, qdd = random.standard_normal((3, n))
    basis = random.standard_normal((3, 4))

    def corrected(corrections, beta):
        at = q + basis[0] @ corrections, qd + basis[1] @ corrections
        return obvious(body, beta, *at)

    @jax.jit
    def expected(corrections, beta):
        terms, rates = jax.jvp(partial(obvious, body, beta), (q, qd), (qd, qdd))
        return terms, rates, jax.jacfwd(corrected, (0, 1))(corrections, beta)

    terms, rates, by = expected(np.zeros((4, n)), beta)
    found = jax.jit(expanded)(body, beta, JointState(q, qd, qdd), basis)
    for ours, expected in zip(found.terms, terms, strict=True):
        np.testing.assert_allclose(
            ours, np.asarray(expected), rtol=ROUNDING, atol=ROUNDING
        )
    for ours, expected in zip(found.rates, rates, strict=True):
        np.testing.assert_allclose(
            ours, np.asarray(expected), rtol=ROUNDING, atol=ROUNDING
        )
    for ours, (corrections, betas) in zip(found.by, by, strict=True):
        flat = corrections.reshape(*corrections.shape[:-2], -1)
        both = np.concatenate([flat, betas], axis=-1)
        np.testing.assert_allclose(ours, both, rtol=ROUNDING, atol=ROUNDING)
