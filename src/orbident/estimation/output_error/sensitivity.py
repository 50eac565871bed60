"""What errors of instruments that are taken for zero would do to an estimate.

An error `c` shifts an estimate that takes it for zero by `-B c` (`taken_for_zero.py`).

An error of scale may seem likely only because it makes all momentum smaller, and with
it the sizes `w` of what may act, which are about zero. That less of it is left to be
explained too is not in these equations; so what `|w|^2` falls by does not count.
"""

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.output_error.taken_for_zero import TakenForZero
from orbident.estimation.unknowns import Sensitivity, score

SMALL_ERROR = {
    "rad": ("mrad", 1e-3),
    "m": ("mm", 1e-3),
    "1": ("%", 1e-2),
    "s": ("ms", 1e-3),
}
"""What a table counts errors in, by their SI unit."""


def sensitivity(zeros: TakenForZero) -> Sensitivity:
    """The effect of each calibration error that is not among a solution's unknowns.

    Args:
        zeros: of the solution.
    """
    names = [each.name for each in zeros.errors]
    by, left = -zeros.shift(names), zeros.equations(names)
    size = zeros.solution.state.common.size
    root = solve_triangular(zeros.factor[:size, :size], np.eye(size))[zeros.beta]
    small = [SMALL_ERROR[each.unit] for each in zeros.errors]
    alone = [score(column[:, None], left[:, -1]) for column in left[:, :-1].T]
    by_what_acts = _fall_of_what_acts(
        zeros, by, np.array([each.values[0] for each in alone])
    )
    return Sensitivity(
        names=tuple(names),
        units=tuple(unit for unit, _ in small),
        shift=by[zeros.beta] * np.array([one for _, one in small]),
        covariance=root @ root.T,
        alone={
            name: each._replace(fall=each.fall - float(fallen))
            for name, each, fallen in zip(names, alone, by_what_acts, strict=True)
        },
        left=left,
    )


def _fall_of_what_acts(
    zeros: TakenForZero,
    by: Float[np.ndarray, "unknowns errors"],
    values: Float[np.ndarray, " errors"],
) -> Float[np.ndarray, " errors"]:
    """How much smaller what acts would be, in squared deviations, not below 0.

    Args:
        zeros: of the solution.
        by: the change of all unknowns by each error, with the other sign.
        values: of the errors.
    """
    solution, acts = zeros.solution, len(zeros.problem.expected)
    if not acts:
        return np.zeros(values.size)
    here = slice(solution.state.common.size - acts, None)
    std = solution.prior.std[here, None]
    before = solution.state.common[here, None] / std
    after = before - by[here] * values / std
    return np.maximum(np.sum(before**2 - after**2, axis=0), 0.0)
