"""The base parameters from the linear equations, against all of them stacked."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import orbident as oi
from orbident.estimation.base_parameters import (
    WIDE,
    beta_of_fits,
    parameters_of_beta,
    prior_std,
)
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import Fits, fit
from orbident.estimation.momentum_problem import momentum_problem
from orbident.model import minimal_sets as model
from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import Samples, samples_of
from orbident.robot.description import Robot

NOISE = 1e-4
"""Std of the velocity (m/s) and of the wheels' speeds (rad/s, times 10)."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return oi.load_robot("paper-spatial")


@pytest.fixture(scope="module")
def exact(robot: Robot) -> Samples:
    return samples_of(robot, oi.simulate(robot, random_motion(robot)))


def noisy(samples: Samples) -> Samples:
    random = np.random.default_rng(0)
    n = samples.t.size
    return replace(
        samples,
        v_S=tuple(v + NOISE * random.standard_normal(n) for v in samples.v_S),
        qd_rw=tuple(w + 10 * NOISE * random.standard_normal(n) for w in samples.qd_rw),
    )


def cad(robot: Robot) -> Robot:
    """Every entry of `theta` 20 % off."""
    signs = np.sign(np.random.default_rng(1).standard_normal(robot.theta.shape))
    return replace(robot, theta=robot.theta * (1 + 0.2 * signs))


def fitted(robot: Robot, samples: Samples) -> Fits:
    return fit(robot, minimal_sets(robot), samples, "unknown", lambda _: None)


def stacked(robot: Robot, samples: Samples):
    """Rows of Eqs. 24 and 31 over `[pi, h_cm]` and `[phi, v_cm]`, and targets."""
    regressors = model.minimal_sets(robot).regressors
    q, qd, w, x, qd_rw, v_S = (
        np.column_stack(getattr(samples, name))
        for name in ("q", "qd", "w", "x_WB", "qd_rw", "v_S")
    )
    Y, W = regressors(q, qd, w)
    R = Rotation.from_quat(x).as_matrix()
    h_rw = qd_rw @ wheels_of(robot).A_rw.T
    one = np.broadcast_to(np.eye(3), R.shape)
    turning = np.concatenate([R @ Y, -one], axis=2), -np.einsum("nij,nj->ni", R, h_rw)
    moving = np.concatenate([R @ W, one], axis=2), v_S
    return [(A.reshape(-1, A.shape[2]), b.ravel()) for A, b in (turning, moving)]


def test_exact_equations_give_the_parameters(robot, exact):
    sets = minimal_sets(robot)
    fits = fitted(robot, exact)
    found = beta_of_fits(cad(robot), sets, fits).values
    beta = sets.beta(robot.theta)
    # Conditions of some hundred, rounding of the simulated attitude 1e-9.
    np.testing.assert_allclose(found, beta, rtol=0, atol=1e-9 * np.abs(beta).max())


def test_against_all_equations_stacked(robot, exact):
    """Every sample's rows, momentum and CM velocity unknown with the rest."""
    samples = noisy(exact)
    sets = minimal_sets(robot)
    fits = fitted(robot, samples)
    found = beta_of_fits(cad(robot), sets, fits)
    (A_h, b_h), (A_v, b_v) = stacked(robot, samples)
    nominal, wide = sets.beta(cad(robot).theta), prior_std(cad(robot), sets)

    def residual(x):
        beta, h_cm, v_cm = np.split(x, [nominal.size, nominal.size + 3])
        pi, phi = sets.pi_and_phi(nominal + wide * beta)
        turning = (A_h @ np.append(pi, h_cm) - b_h) / fits.pi.rms
        moving = (A_v @ np.append(phi, v_cm) - b_v) / fits.phi.rms
        return np.concatenate([turning, moving, beta])

    start = np.concatenate([(found.values - nominal) / wide, np.zeros(6)])
    best = least_squares(residual, start, method="lm", xtol=1e-12, ftol=1e-12)
    J = best.jac
    C = np.linalg.inv(J.T @ J)[: nominal.size, : nominal.size] * np.outer(wide, wide)
    std = np.sqrt(np.diag(C))
    expected = nominal + wide * best.x[: nominal.size]
    # SciPy's derivatives are differences, good to 1e-7.
    assert np.abs((found.values - expected) / std).max() < 1e-3
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), std, rtol=1e-4)
    # And it is an estimate: five deviations from the truth at most.
    assert np.abs((found.values - sets.beta(robot.theta)) / std).max() < 5


def test_keeping_the_structure_makes_nothing_less_sure(robot):
    """`pi` holds products of what `phi` holds: fits apart do not use it.

    The mass by all forms of Eq. 32, weighed by their covariance, does already.
    """
    recording = oi.simulate(robot, random_motion(robot), noise="sensors", seed=2)
    problem = momentum_problem(robot, recording, "unknown", lambda _: None)
    apart = LeastSquares().estimate(problem, lambda _: None)
    estimate = beta_of_fits(robot, problem.sets, problem.fits)
    found = parameters_of_beta(robot, problem.sets, estimate)
    together, alone = (
        np.sqrt(np.diag(each.pi.covariance)) for each in (found, apart.parameters)
    )
    # The covariances are taken at slightly different estimates.
    assert estimate.mass[1] == pytest.approx(apart.mass.std, rel=1e-3)
    assert (together <= 1.001 * alone).all()
    assert (together < 0.9 * alone).any()


def test_what_no_motion_shows_is_as_unsure_as_the_prior(robot):
    """A joint that never moves: wide, but finite, and not determined."""
    still = samples_of(
        robot, oi.simulate(robot, random_motion(robot, still=["joint2"]))
    )
    sets = minimal_sets(robot)
    fits = fitted(robot, still)
    estimate = beta_of_fits(robot, sets, fits)
    assert np.isfinite(estimate.values).all()
    sure = np.sqrt(np.diag(estimate.covariance)) < prior_std(robot, sets) / WIDE
    assert not sure.all()
    assert sure.any()
