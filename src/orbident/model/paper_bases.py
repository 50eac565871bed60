"""The paper's own parameters for its two robots.

They span the same spaces as the minimal sets found automatically; the change of basis
between the two is found from samples, so an estimate in the one is an estimate in the
other.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.model.dependencies import random_motion
from orbident.model.minimal_sets import MinimalSets
from orbident.model.rotations import axis_rotation

# Two bases of one space agree to rounding, others not at all.
SAME_SPACE = 1e-8
SAMPLES = 64
"""Random ones: far more equations than the paper has parameters."""


class PaperColumns(NamedTuple):
    """One sample of the regressors as the paper has them."""

    Y: Float[np.ndarray, "h pi"]
    W: Float[np.ndarray, "v phi"]
    x: Float[np.ndarray, " v"]
    """What of the velocity is known from geometry alone (Eq. 29)."""


class PaperBasis(NamedTuple):
    """How the paper's parameters follow from the automatic minimal sets."""

    pi_of_pi: Float[np.ndarray, "paper pi"]
    """The paper's `pi` is this times the automatic one."""
    phi_of_phi: Float[np.ndarray, "paper phi"]
    phi_offset: Float[np.ndarray, " paper"]
    """The paper's `phi` is `phi_of_phi phi + phi_offset`."""

    def pi(self, pi: Float[np.ndarray, " pi"]) -> Float[np.ndarray, " paper"]:
        """The paper's `pi`."""
        return self.pi_of_pi @ pi

    def phi(self, phi: Float[np.ndarray, " phi"]) -> Float[np.ndarray, " paper"]:
        """The paper's `phi`."""
        return self.phi_of_phi @ phi + self.phi_offset


Columns = Callable[
    [
        Float[np.ndarray, " joints"],
        Float[np.ndarray, " joints"],
        Float[np.ndarray, "3"],
    ],
    PaperColumns,
]


def spatial_columns(
    q: Float[np.ndarray, "3"], qd: Float[np.ndarray, "3"], w: Float[np.ndarray, "3"]
) -> PaperColumns:
    """The 19 + 5 columns of the spatial arm (Table 4, Eqs. 42 and A.6), base axes.

    Joint 1 turns about base z at S, joints 2 and 3 about `n`, perpendicular to z and
    positive where it raises the arm; `x1` is the arm's horizontal direction, `a` and
    `b` are the directions of links 2 and 3.
    """
    x, y, z = np.eye(3)
    x1 = axis_rotation(z, np.asarray(q[0])) @ x
    n = np.cross(x1, z)

    def u(angle: float) -> Float[np.ndarray, "3"]:
        return np.cos(angle) * x1 + np.sin(angle) * np.cross(n, x1)

    w1 = w + qd[0] * z
    w2 = w1 + qd[1] * n
    w3 = w2 + qd[2] * n
    a, b = u(q[1]), u(q[1] + q[2])
    a_dot, b_dot = np.cross(w2, a), np.cross(w3, b)

    def about(
        e: Float[np.ndarray, "3"],
        f: Float[np.ndarray, "3"],
        f_dot: Float[np.ndarray, "3"],
    ):
        return np.cross(e, f_dot) + np.cross(f, np.cross(w, e))

    along = [(x1, w), (z, w1), (a, w2), (n, w2), (b, w3), (n, w3)]
    Y = [
        *(_symmetric(e, f) @ w for e, f in ((x, x), (x, y), (x, z))),
        *(_symmetric(e, f) @ w for e, f in ((y, y), (y, z), (z, z))),
        *(e * (e @ rate) for e, rate in along),
        *(about(e, a, a_dot) for e in (y, z, x)),
        *(about(e, b, b_dot) for e in (y, z, x)),
        np.cross(a, b_dot) + np.cross(b, a_dot),
    ]
    W = [np.cross(w, x), np.cross(w, y), -b_dot, -a_dot, -np.cross(w, z)]
    return PaperColumns(np.stack(Y, axis=1), np.stack(W, axis=1), np.zeros(3))


def planar_columns(r_joint1: tuple[float, float]) -> Columns:
    """The 8 + 4 columns of the planar arm (Eqs. A.4 and A.7), base axes.

    `r_joint1` is from S to the first joint, base axes, m.
    """

    def columns(
        q: Float[np.ndarray, "2"], qd: Float[np.ndarray, "2"], w: Float[np.ndarray, "3"]
    ) -> PaperColumns:
        w0 = w[2]
        w1 = w0 + qd[0]
        w2 = w1 + qd[1]
        c1, s1 = np.cos(q[0]), np.sin(q[0])
        c12, s12 = np.cos(q[0] + q[1]), np.sin(q[0] + q[1])
        c2 = np.cos(q[1])
        Y = [c1 * (w0 + w1), c12 * (w0 + w2), s1 * (w0 + w1), s12 * (w0 + w2)]
        Y += [w0, c2 * (w1 + w2), w1, w2]
        # z x e for the base's axes and the links' directions
        W = np.stack(
            [
                w0 * np.array([0.0, 1.0]),
                w0 * np.array([-1.0, 0.0]),
                -w1 * np.stack([-s1, c1]),
                -w2 * np.stack([-s12, c12]),
            ],
            axis=1,
        )
        x = -w0 * np.array([-r_joint1[1], r_joint1[0]])
        return PaperColumns(np.stack(Y)[None], W, x)

    return columns


def paper_basis(sets: MinimalSets, columns: Columns) -> PaperBasis:
    """The change from the automatic minimal sets to the paper's.

    The columns are `spatial_columns`, or what `planar_columns` gives.

    Raises:
        InputError: the robot is not the paper's: its regressors span another space.
    """
    planar = len(sets.regressors.momentum_axes) == 1
    motion = random_motion(SAMPLES, sets.regressors.joints, planar)
    Y, W = sets.regressors(*motion)
    samples = [columns(*state) for state in zip(*motion, strict=True)]
    paper = PaperColumns(*(np.array(part) for part in zip(*samples, strict=True)))
    phi = _coordinates(paper.W, np.concatenate([W, -paper.x[:, :, None]], axis=2))
    return PaperBasis(_coordinates(paper.Y, Y), phi[:, :-1], phi[:, -1])


def _coordinates(
    basis: Float[np.ndarray, "n axes k"], columns: Float[np.ndarray, "n axes m"]
) -> Float[np.ndarray, "k m"]:
    """`C` such that `columns = basis C`."""
    B = basis.reshape(-1, basis.shape[-1])
    X = columns.reshape(-1, columns.shape[-1])
    C = np.linalg.lstsq(B, X, rcond=None)[0]
    if np.abs(B @ C - X).max() > SAME_SPACE * np.abs(X).max():
        raise InputError("the paper's parameters are not those of this robot")
    return C


def _symmetric(
    e: Float[np.ndarray, "3"], f: Float[np.ndarray, "3"]
) -> Float[np.ndarray, "3 3"]:
    """The symmetric matrix with one at the entries `ef` and `fe`."""
    E = e[:, None] * f
    return np.maximum(E, E.T)
