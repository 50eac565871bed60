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
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from orbident.compilation import compiled
from orbident.dynamics.tree import Tree, tree_of
from orbident.precision import in_float64
from orbident.regressors.independent import independent_columns
from orbident.regressors.momentum import Momentum, momentum
from orbident.robot.description import Robot
from orbident.robot.parameters import MASS, PER_BODY
from orbident.spatial.arrays import AnyArray


class BaseParameters(NamedTuple):
    """`beta = T theta`, ordered `[M, sigma, iota]`, and a `theta` for every `beta`."""

    T: Float[np.ndarray, "beta theta"]
    theta_of: Float[np.ndarray, "theta beta"]
    """`T theta_of = 1`: columns that give a `theta` with the momentum of `beta`."""
    sigmas: int


class Regressors(eqx.Module):
    """`Y` and `W` of a robot, in the coordinates of its minimal sets."""

    tree: Tree
    theta_of_linear: Float[AnyArray, "theta linear"]
    theta_of_sigma: Float[AnyArray, "theta sigma"]
    first: Int[AnyArray, " products"]
    second: Int[AnyArray, " products"]
    momentum_axes: tuple[int, ...] = eqx.field(static=True)
    """Base axes in which angular momentum is conserved: all, or z in the plane."""
    velocity_axes: tuple[int, ...] = eqx.field(static=True)

    def __call__(
        self,
        q: Float[AnyArray, " joints"],
        qd: Float[AnyArray, " joints"],
        w: Float[AnyArray, "3"],
    ) -> tuple[Float[AnyArray, "h pi"], Float[AnyArray, "v phi"]]:
        """`Y` (Eq. 19) and `W` (Eq. 29) of one sample, base axes.

        Args:
            q: joint positions, rad or m.
            qd: joint rates.
            w: base angular velocity, rad/s, base axes.
        """
        at = momentum(self.tree, q, qd, w)
        S, P = at.S @ self.theta_of_sigma, at.P @ self.theta_of_sigma
        products = product_columns(S, P, self.first, self.second)
        Y = jnp.concatenate([at.A @ self.theta_of_linear, products], axis=1)
        return Y[self.momentum_axes, :], -P[self.velocity_axes, :]


@dataclass(frozen=True)
class MinimalSets:
    """The minimal sets of a robot, and the regressors that go with them."""

    regressors: Regressors
    base: BaseParameters
    pi_of_beta: Float[np.ndarray, "pi beta"]
    """`pi = pi_of_beta beta + pi_of_products (sigma_a sigma_b / M)`."""
    pi_of_products: Float[np.ndarray, "pi pairs"]
    pairs: Int[np.ndarray, "pairs 2"]

    @property
    def iotas(self) -> int:
        """So many of `pi`, the first, hold one `iota` each; the others hold none."""
        return self.base.T.shape[0] - 1 - self.base.sigmas

    def beta(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " beta"]:
        """The free-flying base parameters `[M, sigma, iota]`."""
        return self.base.T @ theta.ravel()

    def phi(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " phi"]:
        """`sigma / M`: what the velocity of S depends on (Eq. 29)."""
        M, sigma, _ = self.split(self.beta(theta))
        return sigma / M

    def pi(self, theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, " pi"]:
        """What the angular momentum depends on, linearly (Eq. 19)."""
        beta = self.beta(theta)
        M, sigma, _ = self.split(beta)
        products = sigma[self.pairs[:, 0]] * sigma[self.pairs[:, 1]] / M
        return self.pi_of_beta @ beta + self.pi_of_products @ products

    def split(self, beta):
        """`M, sigma, iota` of `beta`."""
        sigmas = self.base.sigmas
        return beta[0], beta[1 : 1 + sigmas], beta[1 + sigmas :]


def conserved_axes(robot: Robot) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The base axes of angular and of linear momentum that are conserved.

    All; on a table (planar motion) z of the one, x and y of the other.
    """
    if robot.motion == "planar":
        return (2,), (0, 1)
    return (0, 1, 2), (0, 1, 2)


def product_columns(
    S: Float[AnyArray, "3 sigma"],
    P: Float[AnyArray, "3 sigma"],
    first: Int[AnyArray, " products"],
    second: Int[AnyArray, " products"],
) -> Float[AnyArray, "3 products"]:
    """`-(S_a x P_b + S_b x P_a)`, halved for squares: over `sigma_a sigma_b / M`."""
    # Columns stay last, where they are many: the cross product is along the rows.
    half = jnp.where(first == second, 0.5, 1.0)
    S_a, S_b = S[:, first], S[:, second]
    P_a, P_b = P[:, first], P[:, second]
    return -half * (jnp.cross(S_a, P_b, axis=0) + jnp.cross(S_b, P_a, axis=0))


@lru_cache(maxsize=16)
@in_float64
def minimal_sets(robot: Robot) -> MinimalSets:
    """Find the minimal sets of a robot under what its `structure` says is known.

    Found once for each robot of a process.
    """
    tree = tree_of(robot)
    turning, moving = conserved_axes(robot)
    at = _random_momentum(tree, robot, 3 * PER_BODY * len(robot.bodies))
    base = _base_parameters(robot, _rows(at.P, moving), _rows(at.A, turning))

    sigma = slice(1, 1 + base.sigmas)
    S, P = at.S @ base.theta_of[:, sigma], at.P @ base.theta_of[:, sigma]
    pairs = np.array(
        list(itertools.combinations_with_replacement(range(base.sigmas), 2)), dtype=int
    ).reshape(-1, 2)
    products = _product_columns(S, P, *pairs.T)
    A = _rows(at.A @ base.theta_of, turning)
    # iota first: then each has a pi of its own, and the rest of pi is free of them.
    of_beta = np.roll(np.arange(base.T.shape[0]), -1 - base.sigmas)
    iotas = len(of_beta) - 1 - base.sigmas
    columns = [A[:, of_beta[:iotas]], _rows(products, turning), A[:, of_beta[iotas:]]]
    kept, T = independent_columns(np.concatenate(columns, axis=1))

    kept = np.array(kept, dtype=int)
    is_product = (kept >= iotas) & (kept < iotas + len(pairs))
    chosen = pairs[kept[is_product] - iotas]
    rank = np.argsort(is_product, kind="stable")
    linear = kept[~is_product]
    linear = of_beta[np.where(linear < iotas, linear, linear - len(pairs))]
    T = T[rank]
    T_beta = np.delete(T, np.s_[iotas : iotas + len(pairs)], axis=1)
    return MinimalSets(
        regressors=Regressors(
            tree=tree,
            theta_of_linear=base.theta_of[:, linear],
            theta_of_sigma=base.theta_of[:, sigma],
            first=chosen[:, 0],
            second=chosen[:, 1],
            momentum_axes=turning,
            velocity_axes=moving,
        ),
        base=base,
        pi_of_beta=T_beta[:, np.argsort(of_beta)],
        pi_of_products=T[:, iotas : iotas + len(pairs)],
        pairs=pairs,
    )


def _random_momentum(tree: Tree, robot: Robot, samples: int) -> Momentum:
    """The regressors over motion that has nothing special about it."""
    random = np.random.default_rng(0)
    joints = len(robot.joints)
    q, qd = random.standard_normal((2, samples, joints))
    w = random.standard_normal((samples, 3))
    if robot.motion == "planar":
        w[:, :2] = 0.0
    return jax.tree.map(np.asarray, _momentum(tree, q, qd, w))


_momentum = compiled(jax.vmap(momentum, (None, 0, 0, 0)))
_product_columns = compiled(jax.vmap(product_columns, (0, 0, None, None)))


def _rows(
    X: Float[AnyArray, "n 3 m"], axes: tuple[int, ...]
) -> Float[np.ndarray, "r m"]:
    return np.asarray(X)[:, axes, :].reshape(-1, X.shape[-1])


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
