"""How the unknowns that are no parameters change from sample to sample.

    h_cm' = (integral of R_0) (b_g + n) x h_cm    where the attitude is integrated
    v_cm' = (integral of R_0) b_a + white         where the velocity is
    b_g' = white,   b_a' = white

The axes in which momentum and velocity are known drift with the sensors; in these axes
both constants do.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.estimation.recursive.equations import Model
from orbident.estimation.recursive.noise import Noise
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross_matrix


def changed(
    model: Model,
    noise: Noise,
    top: Float[AnyArray, "n all"],
    h_cm: Float[AnyArray, "3"],
    integral: Float[AnyArray, "3 3"],
    dt: Float[AnyArray, ""],
) -> Float[AnyArray, "rows columns"]:
    """The rows `[N | Y | z]`, of `N x + Y y = z`, for the nuisances a time later.

    With `x_before = back x - kick w`, `w` of unit variance, they are

        w = 0
        -N kick w + N back x + Y y = z

    Args:
        model: of the robot.
        noise: of its sensors.
        top: the rows before; `n` nuisances `x = [h_cm, v_cm, b_g, b_a]`.
        h_cm: the momentum known so far, N m s.
        integral: of `R_WB` since then, s.
        dt: since then, s.
    """
    h, v = model.axes
    n_h, n_v, n = len(h), len(v), len(top)
    bias = slice(n_h + n_v, 2 * n_h + n_v)
    turn = noise.integrated * (-cross_matrix(h_cm) @ integral)[h, :][:, h]
    back = jnp.eye(n).at[:n_h, bias].add(-turn)
    walks = [
        jnp.zeros((n, n_h)).at[:n_h].set(noise.gyro * turn),
        jnp.zeros((n, n_h)).at[bias].set(noise.gyro_walk * jnp.sqrt(dt) * jnp.eye(n_h)),
    ]
    if model.accelerometer:
        white = jnp.sqrt(dt) * jnp.eye(n_v)
        moved = jnp.zeros((n, 2 * n_v))
        moved = moved.at[n_h : n_h + n_v, :n_v].set(noise.velocity_walk * white)
        walks.append(moved.at[-n_v:, n_v:].set(noise.accelerometer_walk * white))
        back = back.at[n_h : n_h + n_v, -n_v:].add(-integral[v, :][:, v])
    kick = jnp.concatenate(walks, axis=1)
    w = kick.shape[1]
    N = jnp.triu(top[:, :n])
    none = jnp.eye(w, w + top.shape[1])
    return jnp.concatenate(
        [none, jnp.concatenate([-N @ kick, N @ back, top[:, n:]], axis=1)]
    )


def walks_of(model: Model) -> int:
    """How many random walks there are: the columns before those of the nuisances."""
    h, v = model.axes
    return 2 * len(h) + (2 * len(v) if model.accelerometer else 0)


def nuisances_of(model: Model) -> tuple[np.ndarray, ...]:
    """Where `h_cm`, `v_cm`, `b_g` and `b_a` are among the nuisances."""
    h, v = (len(axes) for axes in model.axes)
    sizes = [h, v, h, v if model.accelerometer else 0]
    return tuple(np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1]))
