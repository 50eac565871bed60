"""The deviations of `H+` and `c+`, in one state or in batches of them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics import equations_of_motion as one
from orbident.dynamics.batches import in_batches
from orbident.dynamics.equations_of_motion import Model
from orbident.spatial.arrays import AnyArray

STATES = 32
"""At once: each has a matrix for every parameter."""


def over(function: Callable[..., Any], *state: Any) -> Any:
    """Of one state, or of each of many: `q`, and perhaps `v`."""
    if state[0].ndim == 1:
        alone = (x[None] for x in state)
        return jax.tree.map(lambda x: x[0], in_batches(function, *alone, size=1))
    return in_batches(function, *state, size=STATES)


_H_plus = jax.vmap(one.H_plus, (None, 0))
_c_plus = jax.vmap(one.c_plus, (None, 0, 0))


@compiled
def H_plus_std(
    model: Model,
    directions: Float[AnyArray, "beta bodies 10"],
    q: Float[AnyArray, "n joints"],
):
    """Deviations of `H+`, where `theta` has these independent ones."""
    return _spread(model, directions, lambda model: _H_plus(model, q))


@compiled
def c_plus_std(
    model: Model,
    directions: Float[AnyArray, "beta bodies 10"],
    q: Float[AnyArray, "n joints"],
    v: Float[AnyArray, "n speeds"],
):
    """Deviations of `c+`, where `theta` has these independent ones."""
    return _spread(model, directions, lambda model: _c_plus(model, q, v))


def _spread(
    model: Model,
    directions: Float[AnyArray, "beta bodies 10"],
    function: Callable[[Model], Float[AnyArray, "*n"]],
) -> Float[AnyArray, "*n"]:
    """Root of the sum of squares along columns of the root of the covariance."""

    def along(direction):
        def of_theta(theta):
            return function(replace(model, theta=theta))

        return jax.jvp(of_theta, (jnp.asarray(model.theta),), (direction,))[1]

    return jnp.sqrt(jnp.sum(jax.vmap(along)(directions) ** 2, axis=0))
