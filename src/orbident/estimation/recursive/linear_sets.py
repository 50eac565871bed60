"""`y = [pi, phi]` of `beta`, and its derivative."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.regressors.minimal_sets import MinimalSets


@dataclass(frozen=True)
class LinearSets:
    """What the conservation laws are linear in, as functions of `[M, sigma, iota]`."""

    pi_of_beta: Float[np.ndarray, "pi beta"]
    pi_of_products: Float[np.ndarray, "pi pairs"]
    a: Float[np.ndarray, "pairs sigma"]
    """`a sigma` and `b sigma` are the factors of the products."""
    b: Float[np.ndarray, "pairs sigma"]

    @classmethod
    def of(cls, sets: MinimalSets) -> "LinearSets":
        """Those of a robot's minimal sets."""
        unit = np.eye(sets.base.sigmas)
        a, b = (unit[column] for column in sets.pairs.T)
        return cls(sets.pi_of_beta, sets.pi_of_products, a, b)

    @property
    def size(self) -> int:
        """Of `y`."""
        return len(self.pi_of_beta) + self.a.shape[1]

    def at(
        self, beta: Float[np.ndarray, " beta"]
    ) -> tuple[Float[np.ndarray, " y"], Float[np.ndarray, "y beta"]]:
        """`y` and `dy / dbeta`."""
        M, sigma = beta[0], beta[1 : 1 + self.a.shape[1]]
        phi = sigma / M
        left, right = self.a @ phi, self.b @ phi
        # pi = pi_of_beta beta + pi_of_products (M phi_a phi_b)
        n, own = len(self.pi_of_beta), slice(1, 1 + sigma.size)
        y = np.empty(self.size)
        y[:n] = self.pi_of_beta @ beta + self.pi_of_products @ (M * left * right)
        y[n:] = phi
        J = np.zeros((self.size, beta.size))
        J[:n] = self.pi_of_beta
        J[:n, 0] -= self.pi_of_products @ (left * right)
        by_sigma = right[:, None] * self.a + left[:, None] * self.b
        J[:n, own] += self.pi_of_products @ by_sigma
        J[n:, 0] = -phi / M
        J[n:, own] = np.eye(sigma.size) / M
        return y, J
