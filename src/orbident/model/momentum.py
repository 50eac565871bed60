"""The momentum of many samples, linear in `theta` (Eqs. 3 and 19).

`S theta` is the first moment about the feature point S, `P theta` the linear momentum
relative to S and `A theta` the angular momentum about S, all in base axes; the
angular momentum about the system CM is

    h_rs = A theta - (S theta) x (P theta) / M.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_tree
from orbident.robot.description import Robot
from orbident.threads import processors


class MomentumRegressors(NamedTuple):
    """The regressors of the samples; columns are the flat `theta`, base first."""

    S: Float[np.ndarray, "n 3 theta"]
    P: Float[np.ndarray, "n 3 theta"]
    A: Float[np.ndarray, "n 3 theta"]


def momentum_regressors(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    qd: Float[np.ndarray, "n joints"],
    w: Float[np.ndarray, "n 3"],
) -> MomentumRegressors:
    """`S`, `P` and `A` at joint states and base rates (rad/s, base axes)."""
    state = (np.ascontiguousarray(x) for x in (q, qd, w))
    return MomentumRegressors(
        *_core.momentum(core_tree(robot), *state, threads=processors())
    )
