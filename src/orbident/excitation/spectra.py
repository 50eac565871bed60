"""One number from the eigenvalues of an information matrix, smooth where it can be."""

from typing import Literal, NamedTuple, get_args

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.spatial.arrays import AnyArray

Objective = Literal["cond", "d", "a", "e"]
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)

# Below any eigenvalue that is more than rounding; keeps the logarithm finite.
SMALLEST = 1e-30


def log_eigenvalues(F: Float[AnyArray, "n n"]) -> Float[AnyArray, " n"]:
    """Of a symmetric matrix, ascending."""
    return jnp.log(jnp.maximum(jnp.linalg.eigvalsh(F), SMALLEST))


def log_squared_singular_values(rows: Float[AnyArray, "m n"]) -> Float[AnyArray, " n"]:
    """The eigenvalues of `rows^T rows`, ascending, whose digits that would halve."""
    s = jnp.linalg.svd(rows, compute_uv=False)[::-1]
    return 2 * jnp.log(jnp.maximum(s, SMALLEST))


class LogValue(NamedTuple):
    """The logarithm of a criterion, to be minimised."""

    smooth: Float[AnyArray, ""]
    exact: Float[AnyArray, ""]


def log_objective(
    objective: Objective,
    l: Float[AnyArray, " n"],
    p: float | Float[AnyArray, ""],
) -> LogValue:
    """The logarithm of a criterion of the eigenvalues of an information matrix.

        cond   (max l - min l) / 2, the condition number of the regressor
        d      -mean(l) / 2, the mean logarithm of the standard deviations
        a      log(mean(exp(-l))) / 2, of the root mean square standard deviation
        e      -min l / 2, of the largest standard deviation

    Extreme eigenvalues are not smooth where they meet, and at an optimum they do;
    generalised means of power p stand for them: never below, and the same for p = inf.

    Args:
        objective: which.
        l: logarithms of the eigenvalues, ascending.
        p: the greater, the closer to the extreme eigenvalues.
    """
    least, most = -_power_mean(-l, p), _power_mean(l, p)
    if objective == "cond":
        return LogValue((most - least) / 2, (l[-1] - l[0]) / 2)
    if objective == "e":
        return LogValue(-least / 2, -l[0] / 2)
    if objective == "d":
        value = -l.mean() / 2
    else:
        value = (_power_mean(-l, 1.0) - jnp.log(l.size)) / 2
    return LogValue(value, value)


def _power_mean(
    l: Float[AnyArray, " n"], p: float | Float[AnyArray, ""]
) -> Float[AnyArray, ""]:
    """`log (sum exp(l)^p)^(1/p)`: at least the greatest, and near it for great p."""
    return jax.nn.logsumexp(p * l) / p
