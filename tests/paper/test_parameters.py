"""The paper's minimal sets (its [21], A.4, A.6, A.7 and Table 4) against ours."""

from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
from obvious_momentum import system_motion
from random_robots import random_planar_robot

from orbident.errors import InputError
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.studies.paper_tables import (
    paper_basis,
    planar_columns,
    spatial_columns,
)

TABLE_4_PI = np.array(
    [
        *(843.15, -111.75, 120.82, 843.15, 120.82, 1123.50, 310.86, 310.87),
        *(-246.37, 246.42, -64.39, 64.44),
        *(-143.50, 158.56, -143.50, -47.83, 52.85, -47.83, 93.24),
    ]
)
TABLE_4_PHI = np.array([-0.96, -0.96, 0.05, 0.14, -0.56])
PRINTED = 0.005 + 1e-9
"""Half of the last digit printed."""

SAMPLES = 60


class SpatialArm(NamedTuple):
    """Table 1's quantities: masses, inertias about the CMs and lengths."""

    r0: np.ndarray
    m: np.ndarray = np.array([1000.0, 10.0, 50.0, 50.0])
    I: np.ndarray = np.array(
        [
            [600, 600, 900],
            [0.21, 0.21, 0.01],
            [0.05, 16.69, 16.69],
            [0.05, 16.69, 16.69],
        ]
    )
    l: tuple[float, ...] = (0.25, 1.0, 1.0)
    r: tuple[float, ...] = (0.25, 1.0, 1.0)

    def pi(self) -> np.ndarray:
        """The 19 parameters, by way of the mass covariances `C(f, g)`."""
        (l1, l2, l3), (r1, r2, _), z = self.l, self.r, np.array([0.0, 0.0, 1.0])
        P = np.array([np.zeros(3), *(self.r0 + c * z for c in (l1, l1 + r1, l1 + r1))])
        a, b = np.array([0, 0, l2, l2 + r2]), np.array([0, 0, 0, l3])

        def C(f, g):
            m = self.m
            return (m * f) @ g - (m @ f) * (m @ g) / m.sum()

        C_PP = np.array([[C(P[:, i], P[:, j]) for j in range(3)] for i in range(3)])
        I0, I1, I2, I3 = self.I
        D0 = np.diag(I0) + np.trace(C_PP) * np.eye(3) - C_PP
        D0 += I1[1] * np.diag([1, 1, 0])
        A2 = I2 + C(a, a) * np.array([0, 1, 1])
        A3 = I3 + C(b, b) * np.array([0, 1, 1])
        C_a, C_b = ([C(P[:, i], f) for i in (1, 2, 0)] for f in (a, b))
        return np.array(
            [
                *(D0[i, j] for i, j in ENTRIES),
                I1[0] - I1[1] + A2[1] + A3[1],
                I1[2] + A2[1] + A3[1],
                A2[0] - A2[1],
                A2[2],
                A3[0] - A3[1],
                A3[2],
                *C_a,
                *C_b,
                C(a, b),
            ]
        )

    def phi(self) -> np.ndarray:
        """A.6, with the signs of phi_5 that Table 4 needs."""
        (m0, m1, m2, m3), (l1, l2, l3), (r1, r2, _) = self.m, self.l, self.r
        phi_5 = -m0 * self.r0[2] + (m1 + m2 + m3) * l1 + (m2 + m3) * r1
        xy = m0 * self.r0[:2]
        a = (m2 + m3) * l2 + m3 * r2
        return np.array([*xy, m3 * l3, a, phi_5]) / self.m.sum()


class PlanarArm(NamedTuple):
    """The surrogate of Cepheus: masses, polar inertias and lengths of A.4."""

    m: tuple[float, ...] = (13.44, 0.06, 0.06)
    I: tuple[float, ...] = (0.1411, 0.00115, 0.0005)
    r0: tuple[float, float] = (0.1593, 0.0766)
    l: tuple[float, float] = (0.15, 0.0904)
    r1: float = 0.15

    def pi(self) -> np.ndarray:
        """A.4, as printed."""
        (m0, m1, m2), (I0, I1, I2), (x, y), (l1, l2), r1 = self
        M, (arm, tip) = sum(self.m), self.moments()
        link_1 = m0 * (m1 + m2) * l1**2 + 2 * m0 * m2 * l1 * r1 + m2 * (m0 + m1) * r1**2
        return np.array(
            [
                m0 * x * arm / M,
                m0 * x * tip / M,
                m0 * y * arm / M,
                m0 * y * tip / M,
                I0 + m0 * (m1 + m2) * (x**2 + y**2) / M,
                tip * (m0 * l1 + (m0 + m1) * r1) / M,
                I1 + link_1 / M,
                I2 + m2 * (m0 + m1) * l2**2 / M,
            ]
        )

    def phi(self) -> np.ndarray:
        """A.7, with `phi_3 = ((m1 + m2) l1 + m2 r1) / M`: its subscripts are stray."""
        m0, (x, y) = self.m[0], self.r0
        return np.array([m0 * x, m0 * y, *self.moments()]) / sum(self.m)

    def moments(self) -> tuple[float, float]:
        (_, m1, m2), (l1, l2) = self.m, self.l
        return (m1 + m2) * l1 + m2 * self.r1, m2 * l2


ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
# The r0 of which Table 1 prints two decimals, and which reproduces Table 4.
ARM = SpatialArm(np.array([-1.06191, -1.06191, 0.67082]))
PLANAR_ARM = PlanarArm()


def paper_spatial_Y(q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> np.ndarray:
    """The 19 columns of `Y`, base axes (theory, Section 3)."""
    x, y, z = np.eye(3)
    x1 = np.cos(q[0]) * x + np.sin(q[0]) * y
    # z = n x x1: a positive rotation raises the arm towards z.
    n = np.cross(x1, z)
    a, b = (np.cos(t) * x1 + np.sin(t) * z for t in (q[1], q[1] + q[2]))
    w1 = w + qd[0] * z
    w2 = w1 + qd[1] * n
    w3 = w2 + qd[2] * n
    a_dot, b_dot = np.cross(w2, a), np.cross(w3, b)
    columns = []
    for i, j in ENTRIES:
        E = np.zeros((3, 3))
        E[i, j] = E[j, i] = 1.0
        columns.append(E @ w)
    columns += [x1 * (x1 @ w), z * (z @ w1)]
    columns += [a * (a @ w2), n * (n @ w2), b * (b @ w3), n * (n @ w3)]
    for f, f_dot in ((a, a_dot), (b, b_dot)):
        for e in (y, z, x):
            columns.append(np.cross(e, f_dot) + np.cross(f, np.cross(w, e)))
    columns.append(np.cross(a, b_dot) + np.cross(b, a_dot))
    return np.array(columns).T


def paper_planar_Y(q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> np.ndarray:
    """The eight columns of A.4's parameters."""
    w0, w1, w2 = np.cumsum([w[2], *qd])
    c1, c2, c12 = np.cos([q[0], q[1], q[0] + q[1]])
    s1, s12 = np.sin([q[0], q[0] + q[1]])
    turning = [c1 * (w0 + w1), c12 * (w0 + w2), s1 * (w0 + w1), s12 * (w0 + w2)]
    return np.array([[*turning, w0, c2 * (w1 + w2), w1, w2]])


class Paper(NamedTuple):
    """A robot of the paper: ours, our sets, and both regressors over random motion."""

    robot: Robot
    sets: MinimalSets
    q: np.ndarray
    qd: np.ndarray
    w: np.ndarray
    Y: np.ndarray
    W: np.ndarray
    Y_paper: np.ndarray
    h_rs: np.ndarray


def over_random_motion(name: str, paper_Y, axes: list[int]) -> Paper:
    robot = load_robot(name)
    sets = minimal_sets(robot)
    random = np.random.default_rng(1)
    q, qd = random.standard_normal((2, SAMPLES, len(robot.joints)))
    w = np.zeros((SAMPLES, 3))
    w[:, axes] = random.standard_normal((SAMPLES, len(axes)))
    Y, W = (np.concatenate(X) for X in sets.regressors(q, qd, w))
    states = list(zip(q, qd, w, strict=True))
    return Paper(
        robot,
        sets,
        q,
        qd,
        w,
        Y,
        W,
        np.concatenate([paper_Y(*state) for state in states]),
        np.concatenate([system_motion(robot, *s).h_rs[axes] for s in states]),
    )


@pytest.fixture(scope="module")
def spatial() -> Paper:
    return over_random_motion("paper-spatial", paper_spatial_Y, [0, 1, 2])


@pytest.fixture(scope="module")
def planar() -> Paper:
    return over_random_motion("cepheus-like", paper_planar_Y, [2])


def test_table_4_true_pi():
    np.testing.assert_allclose(ARM.pi(), TABLE_4_PI, rtol=0, atol=PRINTED)


def test_table_4_true_phi():
    np.testing.assert_allclose(ARM.phi(), TABLE_4_PHI, rtol=0, atol=PRINTED)


def test_erratum_table_1_prints_too_few_digits_of_r0():
    """With r0 as printed pi_18 comes out as -47.75, Table 4 has -47.83."""
    printed = SpatialArm(np.array([-1.06, -1.06, 0.67])).pi()
    assert printed[17] == pytest.approx(-47.75, abs=PRINTED)


def test_erratum_phi_5_as_printed_in_A_6():
    """The printed signs give +0.60, Table 4 has -0.56."""
    (m0, m1, m2, m3), (l1, _, _), (r1, _, _) = ARM.m, ARM.l, ARM.r
    as_printed = m0 * ARM.r0[2] - (m1 + m2 + m3) * l1 + (m2 + m3) * r1
    assert as_printed / ARM.m.sum() == pytest.approx(0.60, abs=PRINTED)


def test_eq_42_products_of_phi():
    """pi_13 to pi_19 are `M` times products of phi (Eq. 42 has pi_18)."""
    (f1, f2, f3, f4, f5), M = ARM.phi(), ARM.m.sum()
    (l1, l2, _), (r1, r2, _) = ARM.l, ARM.r
    z, a = l1 + r1 - f5, l2 + r2 - f4
    products = [f2 * f4, f4 * z, f1 * f4, f2 * f3, f3 * z, f1 * f3, f3 * a]
    # A dozen float64 operations.
    np.testing.assert_allclose(ARM.pi()[12:], M * np.array(products), rtol=1e-13)


def test_bundled_robot_is_table_1s(spatial):
    """Its momentum, body by body, is the paper's `Y pi` with Table 4's formulas."""
    difference = spatial.Y_paper @ ARM.pi() - spatial.h_rs
    # Terms of 1e3 kg m^2 times 1 rad/s, in float64; the worst observed is 2e-12.
    assert np.abs(difference).max() < 1e-10


def test_our_pi_are_table_4s_up_to_sign_and_order(spatial):
    ours = np.sort(np.abs(spatial.sets.pi(spatial.robot.theta)))
    np.testing.assert_allclose(ours, np.sort(np.abs(TABLE_4_PI)), atol=PRINTED)


def test_our_phi_are_table_4s_up_to_sign_and_order(spatial):
    ours = np.sort(np.abs(spatial.sets.phi(spatial.robot.theta)))
    np.testing.assert_allclose(ours, np.sort(np.abs(TABLE_4_PHI)), atol=PRINTED)


@pytest.mark.parametrize("name", ["spatial", "planar"])
def test_our_regressor_and_the_papers_span_the_same_space(name, request):
    paper = request.getfixturevalue(name)
    assert paper.Y.shape == paper.Y_paper.shape
    for basis, other in ((paper.Y, paper.Y_paper), (paper.Y_paper, paper.Y)):
        T = np.linalg.lstsq(basis, other)[0]
        # Entries of the order of 1; the worst observed is 1e-14.
        assert np.abs(basis @ T - other).max() < 1e-10


@pytest.mark.parametrize("name", ["spatial", "planar"])
def test_our_pi_give_the_momentum(name, request):
    paper = request.getfixturevalue(name)
    h_rs = paper.Y @ paper.sets.pi(paper.robot.theta)
    # Twenty float64 terms; the worst observed is 8e-16.
    np.testing.assert_allclose(h_rs, paper.h_rs, atol=1e-13 * np.abs(paper.h_rs).max())


def test_A_4_gives_the_planar_momentum(planar):
    # Terms below 1, in float64; the worst observed is 2e-16.
    np.testing.assert_allclose(
        planar.Y_paper @ PLANAR_ARM.pi(), planar.h_rs, atol=1e-13
    )


def test_change_of_basis_gives_table_4(spatial):
    """The values are in the paper's order and have its signs."""
    basis, theta = paper_basis(spatial.sets, spatial_columns), spatial.robot.theta
    pi = basis.pi(spatial.sets.pi(theta))
    phi = basis.phi(spatial.sets.phi(theta))
    # Least squares with a condition of 17, in float64.
    np.testing.assert_allclose(pi, ARM.pi(), rtol=1e-12)
    np.testing.assert_allclose(phi, ARM.phi(), rtol=1e-12)


def test_change_of_basis_gives_A_4_and_A_7(planar):
    basis, theta = paper_basis(planar.sets, planar_columns), planar.robot.theta
    pi = basis.pi(planar.sets.pi(theta))
    phi = basis.phi(planar.sets.phi(theta))
    # Terms below 1: the smallest pi, 2e-4, is a difference of larger ones.
    np.testing.assert_allclose(pi, PLANAR_ARM.pi(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(phi, PLANAR_ARM.phi(), rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", ["spatial", "planar"])
def test_eq_29_in_the_papers_basis(name, request):
    """`v_S - v_cm = W phi + x`, with the momentum from each body."""
    paper = request.getfixturevalue(name)
    columns, arm = (
        (spatial_columns, ARM) if name == "spatial" else (planar_columns, PLANAR_ARM)
    )
    moving = list(paper.sets.regressors.velocity_axes)
    for k in range(SAMPLES):
        total = system_motion(paper.robot, paper.q[k], paper.qd[k], paper.w[k])
        v = -total.linear[moving] / paper.robot.mass
        at = columns(paper.q[k], paper.qd[k], paper.w[k])
        # Metres a second of the order of 1.
        np.testing.assert_allclose(at.W @ arm.phi() + at.x, v, atol=1e-14)


def test_paper_basis_refuses_another_robot():
    """Two joints too, but nothing is known of where the links' CMs are."""
    sets = minimal_sets(random_planar_robot(0, (0, 1)))
    with pytest.raises(InputError, match="not those of this robot"):
        paper_basis(sets, partial(planar_columns, r_joint1=(0.2, 0.0)))


def test_counts_of_the_papers_systems(spatial, planar):
    """Nineteen and five; eight and four (Sections 4 and 5)."""
    for paper, pi, phi in ((spatial, 19, 5), (planar, 8, 4)):
        assert paper.Y.shape[1] == pi
        assert paper.W.shape[1] == phi
        assert np.linalg.matrix_rank(paper.Y) == pi
        assert np.linalg.matrix_rank(paper.W) == phi
