"""The dynamics of base parameters: what they rest on, their deviations, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.model.equations_of_motion import Wrench
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.robot.description import Friction, Robot
from orbident.robot.robot_file import load_robot

Q = np.array([0.4, -0.7, 1.1])
V = np.array([0.1, -0.2, 0.3, 0.2, 0.1, -0.3, 0.5, -0.4, 0.6, 90.0, -50.0, 20.0])


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("paper-spatial")


@pytest.fixture(scope="module")
def beta(robot: Robot) -> np.ndarray:
    return minimal_sets(robot).beta(robot.theta)


@pytest.fixture(scope="module")
def C(beta: np.ndarray) -> np.ndarray:
    """Deviations of a millionth, correlated."""
    random = np.random.default_rng(0)
    root = 1e-6 * beta[:, None] * random.standard_normal((beta.size, beta.size))
    return root @ root.T


@pytest.fixture(scope="module")
def model(robot: Robot, beta: np.ndarray, C: np.ndarray) -> Dynamics:
    return reconstructed(robot, beta, C)


def test_the_nominal_inertia_does_not_matter(robot, beta, C, model):
    """With any other `theta` everything is the same to the last bit."""
    other = replace(robot, theta=robot.theta + np.arange(40.0).reshape(4, 10))
    same = reconstructed(other, beta, C)
    np.testing.assert_array_equal(same.H_plus(Q), model.H_plus(Q))
    np.testing.assert_array_equal(same.c_plus(Q, V), model.c_plus(Q, V))
    np.testing.assert_array_equal(same.H_plus_std(Q), model.H_plus_std(Q))
    point = np.array([0.1, 0.2, 0.3])
    for body in robot.bodies:
        np.testing.assert_array_equal(
            same.jacobian(Q, body, point), model.jacobian(Q, body, point)
        )
    torques = {"joint1": 2.0}, {"rw_y": 0.1}
    wrench = Wrench("link3", point, np.array([1.0, 0, 0]), np.zeros(3))
    np.testing.assert_array_equal(
        same.generalised_forces(Q, *torques, [wrench]),
        model.generalised_forces(Q, *torques, [wrench]),
    )


def test_generalised_forces(model):
    """Eq. 15, with Jacobians that are tested on their own."""
    point, force = np.array([0.1, 0.2, 0.3]), np.array([1.0, -2.0, 0.5])
    moment = np.array([0.3, 0.1, -0.2])
    wrench = Wrench("link2", point, force, moment)
    Q_found = model.generalised_forces(Q, {"joint2": 3.0}, {"rw_z": 0.2}, [wrench])
    J = model.jacobian(Q, "link2", point)
    expected = J.T @ np.concatenate([force, moment])
    expected[7] += 3.0
    expected[11] += 0.2
    np.testing.assert_allclose(Q_found, expected, rtol=1e-14)


def test_deviations_against_drawn_parameters(robot, beta, C, model):
    """First order, where deviations are small: 400 draws tell them to 10 %."""
    random = np.random.default_rng(1)
    draws = random.multivariate_normal(beta, C, 400)
    free = [reconstructed_fast(robot, model, draw) for draw in draws]
    H, c = (np.array(each) for each in zip(*free, strict=True))
    for found, drawn in (
        (model.H_plus_std(Q), H.std(axis=0)),
        (model.c_plus_std(Q, V), c.std(axis=0)),
    ):
        # Differences of numbers of 1e3 are rounded at 1e-12.
        shown = found > 1e-9
        np.testing.assert_allclose(found[shown], drawn[shown], rtol=0.2)
        assert (drawn[~shown] < 1e-9).all()


def reconstructed_fast(robot, model, beta):
    """`H+` and `c+` of other parameters, without checking them."""
    theta = (minimal_sets(robot).base.theta_of @ beta).reshape(-1, 10)
    other = replace(model, robot=replace(robot, theta=theta))
    return other.H_plus(Q), other.c_plus(Q, V)


def test_both_at_once(model):
    H, c = model.equations(Q, V)
    np.testing.assert_array_equal(H, model.H_plus(Q))
    np.testing.assert_array_equal(c, model.c_plus(Q, V))


def test_without_a_covariance_deviations_are_unknown(robot, beta, C):
    model = reconstructed(robot, beta, np.full_like(C, np.nan))
    # The wheels' inertia is known.
    assert np.isnan(model.H_plus_std(Q)[3:9, 3:9]).all()
    assert not model.H_plus_std(Q)[9:].any()
    assert np.isfinite(model.H_plus(Q)).all()


def test_many_states_at_once(model):
    q, v = np.tile(Q, (3, 1)) + np.arange(3)[:, None], np.tile(V, (3, 1))
    np.testing.assert_array_equal(model.H_plus(q), [model.H_plus(each) for each in q])
    found, expected = model.H_plus_std(q), [model.H_plus_std(each) for each in q]
    # BLAS may sum one state in another order than many.
    atol = 1e-13 * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=atol)
    found = model.c_plus(q, v)
    expected = [model.c_plus(*each) for each in zip(q, v, strict=True)]
    np.testing.assert_array_equal(found, expected)


def test_torques_with_friction(robot, beta, C, model):
    """Those of declared friction are added; what nobody knows is NaN."""
    qd, qdd = V[6:9], np.array([0.3, 0.2, -0.1])
    plain = model.torques(Q, qd, qdd, w=V[3:6], qd_rw=V[9:])
    assert np.isnan(model.torques(Q, qd, qdd, friction=True)).all()
    rubs = {"joint2": Friction(0.5, 0.25, 0.125)}
    rubbed = reconstructed(replace(robot, friction=rubs), beta, C)
    found = rubbed.torques(Q, qd, qdd, w=V[3:6], qd_rw=V[9:], friction=True)
    assert found[1] == pytest.approx(plain[1] + 0.5 * qd[1] - 0.25 + 0.125, rel=1e-12)
    assert np.isnan(found[[0, 2]]).all()


def test_torques_of_many_states_of_a_planar_robot():
    """They are those of the equations with the base's accelerations solved for."""
    robot = load_robot("cepheus-like")
    beta = minimal_sets(robot).beta(robot.theta)
    model = reconstructed(robot, beta, np.diag((0.01 * beta) ** 2))
    q, qd, qdd = np.random.default_rng(0).standard_normal((3, 4, 2))
    found = model.torques(q, qd, qdd)
    for k in range(4):
        np.testing.assert_array_equal(model.torques(q[k], qd[k], qdd[k]), found[k])
        H = model.H_plus(q[k])
        v = np.concatenate([np.zeros(6), qd[k], [0.0]])
        v[5] = -H[5, 6:8] @ qd[k] / H[5, 5]
        c = model.c_plus(q[k], v)
        turn = -(H[5, 6:8] @ qdd[k] + c[5]) / H[5, 5]
        expected = H[6:8, 5] * turn + H[6:8, 6:8] @ qdd[k] + c[6:8]
        np.testing.assert_allclose(found[k], expected, rtol=1e-9)


def test_a_planar_robot_does_not_tilt():
    """What no planar motion shows is NaN, never a number."""
    robot = load_robot("cepheus-like")
    beta = minimal_sets(robot).beta(robot.theta)
    model = reconstructed(robot, beta, np.diag((0.01 * beta) ** 2))
    q, v = np.array([0.3, -0.2]), np.array([0.1, 0.2, 0, 0, 0, 0.5, 0.3, -0.4, 9.0])
    seen = np.array([0, 1, 2, 5, 6, 7, 8])
    hidden = np.setdiff1d(np.arange(9), seen)
    for matrix in (model.H_plus(q), model.H_plus_std(q)):
        assert np.isfinite(matrix[np.ix_(seen, seen)]).all()
        assert np.isnan(matrix[hidden]).all()
        assert np.isnan(matrix[:, hidden]).all()
    for vector in (model.c_plus(q, v), model.c_plus_std(q, v)):
        assert np.isnan(vector[hidden]).all()
        assert np.isfinite(vector[seen]).all()
    assert np.isnan(model.jacobian(q, "link2", np.zeros(3))[:, hidden]).all()
    tilting = v.copy()
    tilting[3] = 0.1
    with pytest.raises(InputError, match="leaves the plane"):
        model.c_plus(q, tilting)


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        (lambda m: m.H_plus(Q[:2]), r"q: found shape \(2,\), expected \(3,\)"),
        (lambda m: m.torques(Q, Q[:2], Q), r"qd: found shape \(2,\), expected \(3,\)"),
        (
            lambda m: m.torques([Q, Q], [Q], [Q]),
            r"q has shape \(2, 3\) and qd \(1, 3\)",
        ),
        (lambda m: m.torques(Q, Q, Q, qd_rw=[9.0]), r"qd_rw: found shape \(1,\)"),
        (lambda m: m.c_plus(Q, V[:-1]), r"v: found shape \(11,\), expected \(12,\)"),
        (lambda m: m.c_plus(Q, np.tile(V, (2, 1))), "one row of each"),
        (lambda m: m.jacobian(Q, "link4", np.zeros(3)), "did you mean 'link3'"),
        (lambda m: m.jacobian(Q, "link3", np.zeros(2)), r"point: found shape \(2,\)"),
        (lambda m: m.generalised_forces(Q[:1], {}, {}), r"q: found shape \(1,\)"),
        (lambda m: m.generalised_forces(Q, {"joint9": 1.0}, {}), "no joint 'joint9'"),
        (lambda m: m.generalised_forces(Q, {}, {"rw": 1.0}), "no wheel 'rw'"),
    ],
)
def test_refusals(monkeypatch, model, refused, message):
    # As installed: in tests a wrong shape is refused before the code can see it.
    monkeypatch.setattr("jaxtyping.config.jaxtyping_disable", True)
    with pytest.raises(InputError, match=message):
        refused(model)


def test_parameters_that_cannot_be(robot, beta, C):
    def refused(changed, message, covariance=C):
        with pytest.raises(InputError, match=message):
            reconstructed(robot, changed, covariance)

    refused(beta[:-1], "found 17 base.*'paper-spatial' has 18", C[:-1, :-1])
    unknown = beta.copy()
    unknown[[2, 5]] = np.nan
    refused(unknown, r"2 of 18 .* not determined \(sigma_2, sigma_5\)")
    # iota_12 is link 3's inertia about its joint: less than nothing.
    impossible = np.append(beta[:-1], -80.0)
    refused(impossible, "singular or indefinite at q = .* 'joint[23]'")
