"""The minimal parameter sets of any robot: base parameters, `phi` and `pi`.

Everything is found from the ranks of the momentum regressors over random motion, so
trees, prismatic joints and what is known of the bodies need no case of their own.

- The free-flying base parameters `beta = [M, sigma, iota] = T theta` are all that the
  momentum shows: total mass, first moments (the row space of `P`) and inertias (what
  `A` adds to those).
- `phi = sigma / M` is linear in the velocity of S (Eq. 29).
- `pi` makes `h_rs` linear (Eq. 19). With `S theta = S_s sigma` and the like, `h_rs` is
  a combination of the columns of `A` over `beta` and of
  `-(S_a x P_b + S_b x P_a)` over the products `sigma_a sigma_b / M`; those that are
  independent are `Y`, and their coefficients are `pi`.
"""

import itertools
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, NoReturn

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array

from orbident import _core
from orbident.errors import InputError
from orbident.model.core_robot import core_tree, theta_with_rotors
from orbident.model.dependencies import (
    DEPENDENT,
    Columns,
    dependencies,
    independent_columns,
    random_motion,
)
from orbident.model.kinematics import JointState, momentum_regressors
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    inertia_matrix,
)
from orbident.threads import one_blas_thread, processors

MOST_PRODUCTS = 8000
"""Most products of first moments: with so many in `pi` it takes some seconds."""
ROUNDING = 1e-12
"""Coefficients of a relation between columns below this part of the largest are 0."""
MOST_JOINTS = 125
"""A joint shows one first moment at least, and products of so many are `MOST_PRODUCTS`.
Random motion of more joints is not tried: its table grows with their square."""


class BaseParameters(NamedTuple):
    """`beta = T theta`, ordered `[M, sigma, iota]`, and a `theta` for every `beta`."""

    T: Float[np.ndarray, "beta theta"]
    theta_of: Float[np.ndarray, "theta beta"]
    """`T theta_of = 1`: columns that give a `theta` with the momentum of `beta`."""
    sigmas: int


class Regressors(NamedTuple):
    """`Y` and `W` of a robot, in the coordinates of its minimal sets."""

    core: _core.MinimalSets
    joints: int
    momentum_axes: tuple[int, ...]
    """Base axes in which angular momentum is conserved: all, or z in the plane."""
    velocity_axes: tuple[int, ...]

    def __call__(
        self,
        q: Float[np.ndarray, "n joints"],
        qd: Float[np.ndarray, "n joints"],
        w: Float[np.ndarray, "n 3"],
    ) -> tuple[Float[np.ndarray, "n h pi"], Float[np.ndarray, "n v phi"]]:
        """`Y` (Eq. 19) and `W` (Eq. 29) of many samples, base axes.

        Joint positions `q` are in rad or m, base rates `w` in rad/s, base axes.
        """
        Y, W = _core.regressors(self.core, q, qd, w, threads=processors())
        return Y[:, self.momentum_axes], W[:, self.velocity_axes]

    def momentum_rate(
        self,
        joints: JointState,
        w: Float[np.ndarray, "n 3"],
        pi: Float[np.ndarray, " pi"],
    ) -> Float[np.ndarray, "n h"]:
        """`d/dt (Y pi)` by the joints alone, the base rate held; base axes, N m.

        The joints are `q`, `qd` and `qdd`; `w` is in rad/s, base axes, and `pi` in kg
        m^2.
        """
        rate = _core.momentum_rate(self.core, *joints, w, pi, threads=processors())
        return rate[:, self.momentum_axes]


@dataclass(frozen=True, repr=False)
class MinimalSets:
    """The minimal sets of a robot, and the regressors that go with them."""

    regressors: Regressors
    """The functions that give `Y` and `W`."""
    base: BaseParameters
    """The base parameters `beta = [M, sigma, iota]`, as combinations of `theta`."""
    pi_of_beta: Float[np.ndarray, "pi beta"]
    """`pi = pi_of_beta beta + pi_of_products (sigma_a sigma_b / M)`."""
    pi_of_products: Any
    """Sparse, a `scipy.sparse.csr_array`: most products have a `pi` of their own."""
    pairs: Int[np.ndarray, "pairs 2"]
    """Which two `sigma`, `a` and `b`, each product is of."""
    rotors: Float[np.ndarray, " theta"]
    """What the robot's declared rotors add to `theta` in all that is momentum."""

    def __repr__(self) -> str:
        """How many parameters each set has."""
        sigmas, base = self.base.sigmas, self.base.T.shape[0]
        return (
            f"{base} base parameters (M, {sigmas} sigma, {base - 1 - sigmas} iota), "
            f"{sigmas} phi, {self.pi_of_beta.shape[0]} pi"
        )

    @property
    def iotas(self) -> int:
        """So many of `pi`, the first, hold one `iota` each; the others hold none."""
        return self.base.T.shape[0] - 1 - self.base.sigmas

    def beta(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " beta"]:
        """The free-flying base parameters `[M, sigma, iota]`, with declared rotors."""
        return self.base.T @ (theta.ravel() + self.rotors)

    def of_mass(self, body: int) -> Float[np.ndarray, " beta"] | None:
        """A body's mass as a combination of `beta`; None where no motion shows it."""
        T, theta_of = self.base.T, self.base.theta_of
        mass = np.eye(1, T.shape[1], PER_BODY * body)[0]
        by_beta = mass @ theta_of
        shown = np.allclose(by_beta @ T, mass, atol=DEPENDENT)
        return by_beta if shown else None

    def theta(self, beta: Float[np.ndarray, " beta"]) -> Float[np.ndarray, "bodies 10"]:
        """Bodies that have these base parameters, their declared rotors apart."""
        return (self.base.theta_of @ beta - self.rotors).reshape(-1, PER_BODY)

    def phi(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " phi"]:
        """`sigma / M`: what the velocity of S depends on (Eq. 29)."""
        return self.pi_and_phi(self.beta(theta))[1]

    def pi(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " pi"]:
        """What the angular momentum depends on, linearly (Eq. 19)."""
        return self.pi_and_phi(self.beta(theta))[0]

    def pi_and_phi(
        self, beta: Float[np.ndarray, " beta"]
    ) -> tuple[Float[np.ndarray, " pi"], Float[np.ndarray, " phi"]]:
        """`pi` and `phi` of `beta = [M, sigma, iota]`."""
        M, sigma, _ = self.split(beta)
        a, b = self.pairs.T
        products = sigma[a] * sigma[b] / M
        return self.pi_of_beta @ beta + self.pi_of_products @ products, sigma / M

    def derivatives(
        self, beta: Float[np.ndarray, " beta"]
    ) -> tuple[Float[np.ndarray, "pi beta"], Float[np.ndarray, "phi beta"]]:
        """The derivatives of `pi` and of `phi = sigma / M` by `beta`."""
        M, sigma, iota = self.split(beta)
        n = sigma.size
        dphi = np.hstack(
            [-sigma[:, None] / M**2, np.eye(n) / M, np.zeros((n, iota.size))]
        )
        a, b = self.pairs.T
        products = np.zeros((len(self.pairs), beta.size))
        # sigma_a sigma_b / M; += twice, for squares.
        rows = np.arange(len(self.pairs))
        products[:, 0] = -sigma[a] * sigma[b] / M**2
        products[rows, 1 + a] += sigma[b] / M
        products[rows, 1 + b] += sigma[a] / M
        return self.pi_of_beta + self.pi_of_products @ products, dphi

    def split(
        self, beta: Float[np.ndarray, " beta"]
    ) -> tuple[float, Float[np.ndarray, " sigma"], Float[np.ndarray, " iota"]]:
        """`M, sigma, iota` of `beta`."""
        sigmas = self.base.sigmas
        return beta[0], beta[1 : 1 + sigmas], beta[1 + sigmas :]


@lru_cache(maxsize=16)
@one_blas_thread
def minimal_sets(robot: Robot) -> MinimalSets:
    """Find the minimal sets of a robot under what its `structure` says is known.

    Found once for each robot of a process.

    Raises:
        InputError: the robot has too many joints.
    """
    if len(robot.joints) > MOST_JOINTS:
        _refuse(robot, f"has {len(robot.joints)} joints")
    axes_h, axes_v = robot.conserved_axes
    samples = 2 * PER_BODY * len(robot.bodies)
    n, planar = -(-samples // len(axes_h)), robot.motion == "planar"
    at = momentum_regressors(robot, *random_motion(n, len(robot.joints), planar))
    base = _base_parameters(robot, _rows(at.P, axes_v), _rows(at.A, axes_h))

    sigma = slice(1, 1 + base.sigmas)
    pairs = np.array(
        list(itertools.combinations_with_replacement(range(base.sigmas), 2)), dtype=int
    ).reshape(-1, 2)
    columns = Columns(robot, base.theta_of, sigma, pairs, axes_h)
    if len(pairs) > MOST_PRODUCTS:
        products = f"{len(pairs)} products of first moments"
        _refuse(robot, f"has {len(robot.joints)} joints, and so {products}")
    betas = base.T.shape[0]
    kept, pi_of_beta, pi_of_products = _first_that_span(
        dependencies(columns), betas, 1 + base.sigmas
    )
    return MinimalSets(
        regressors=Regressors(
            core=_core.MinimalSets(
                tree=core_tree(robot),
                theta_of_linear=base.theta_of[:, kept[kept < betas]],
                theta_of_sigma=base.theta_of[:, sigma],
                pairs=pairs[kept[kept >= betas] - betas].astype(float),
            ),
            joints=len(robot.joints),
            momentum_axes=axes_h,
            velocity_axes=axes_v,
        ),
        base=base,
        pi_of_beta=pi_of_beta,
        pi_of_products=pi_of_products,
        pairs=pairs,
        rotors=(theta_with_rotors(robot) - robot.theta).ravel(),
    )


def _refuse(robot: Robot, has: str) -> NoReturn:
    raise InputError(
        f"{robot.name}: {has}; minimal sets are found of up to {MOST_PRODUCTS} "
        "products of first moments, or some 60 joints: make fixed what need not move"
    )


def _first_that_span(
    zero: Float[np.ndarray, "columns m"], betas: int, shown: int
) -> tuple[Int[np.ndarray, " pi"], Float[np.ndarray, "pi beta"], csr_array]:
    """The first columns that span all, and how they make up all: `X = X[:, kept] T`.

    `T` is given in two parts, over `beta` and over the products.

    Args:
        zero: combinations of the columns that are zero.
        betas: how many columns are those of `beta`; the others are products.
        shown: how many of them, the first, come last: iota is first, so that each has a
            `pi` of its own, and the rest of `pi` is free of them.
    """
    order = np.roll(np.arange(len(zero)), -shown)
    # A column goes where a combination that is zero makes it up of those before it.
    last_first = order[::-1]
    left_out, relations = independent_columns(zero[last_first].T)
    left_out = last_first[left_out]
    kept = order[~np.isin(order, left_out)]
    # Products, the last columns, make up the last of pi.
    kept = np.concatenate([kept[kept < betas], kept[kept >= betas]])
    relations = relations[:, np.argsort(last_first)[kept]]
    size = np.abs(relations)
    largest = size.max(axis=1, initial=0.0, keepdims=True)
    which, row = np.nonzero(size > ROUNDING * largest)
    values = np.concatenate([np.ones(len(kept)), -relations[which, row]])
    rows = np.concatenate([np.arange(len(kept)), row])
    columns = np.concatenate([kept, left_out[which]])
    T = csr_array((values, (rows, columns)), shape=(len(kept), len(zero)))
    return kept, T[:, :betas].toarray(), T[:, betas:]


def _rows(
    X: Float[np.ndarray, "n 3 m"], axes: tuple[int, ...]
) -> Float[np.ndarray, "r m"]:
    return X[:, axes, :].reshape(-1, X.shape[-1])


def _base_parameters(
    robot: Robot, P: Float[np.ndarray, "p theta"], A: Float[np.ndarray, "a theta"]
) -> BaseParameters:
    """`[M, sigma, iota]`: the total mass, what `P` shows, and what `A` adds."""
    free = np.array(robot.free_parameters)
    P, A = P[:, free], A[:, free]
    mass = (free % PER_BODY == MASS).astype(float)
    shown, T_sigma = independent_columns(P)
    T_shown = np.vstack([mass, T_sigma])
    # The base's mass (column 0) stands for M: it moves with S, so P never shows it.
    pivots = [0, *shown]
    theta_of_shown = np.zeros((len(free), len(pivots)))
    theta_of_shown[pivots] = np.linalg.inv(T_shown[:, pivots])
    # The part of theta that changes neither M nor sigma.
    rest = np.eye(len(free)) - theta_of_shown @ T_shown
    added, T_iota = independent_columns(A @ rest)

    everything = PER_BODY * len(robot.bodies)
    T = np.zeros((len(pivots) + len(added), everything))
    T[:, free] = np.vstack([T_shown, T_iota])
    theta_of = np.zeros((everything, T.shape[0]))
    theta_of[free] = np.hstack([theta_of_shown, rest[:, added]])
    return BaseParameters(T, theta_of, len(shown))


def unseen_part(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " theta"]:
    """What remains of the nominal `theta` beside what its base parameters give.

    No motion shows anything of it, so that it is taken as declared. It has no momentum
    in the geometry that is declared. With joints elsewhere it has, by the product of
    its own size and the change of geometry.
    """
    bodies = _flat(robot) if robot.motion == "planar" else robot.theta
    beta = sets.beta(robot.theta)
    return bodies.ravel() + sets.rotors - sets.base.theta_of @ beta


def _flat(robot: Robot) -> Float[np.ndarray, "bodies 10"]:
    """The bodies of a planar robot, all in the plane of S.

    Nothing there shows how high a CM is, but a height couples tilts to positions.
    """
    # Of each body: the plane's normal in its axes, and its origin's height, m.
    places = [(np.array([0.0, 0.0, 1.0]), 0.0)]
    for joint in robot.joints:
        n, height = places[joint.parent]
        places.append((joint.R_PJ.T @ n, height + float(n @ joint.p_PJ)))
    flat = []
    for theta, (n, height) in zip(robot.theta, places, strict=True):
        m, s = theta[MASS], theta[FIRST_MOMENT]
        about_n = (n @ inertia_matrix(theta) @ n) * np.outer(n, n)
        in_plane = s - n * (n @ s + m * height)
        flat.append([m, *in_plane, *(about_n[entry] for entry in INERTIA_ENTRIES)])
    return np.array(flat)
