"""What recordings of one robot have in common, and what each says of it.

Base parameters and the errors of instruments are the same in all recordings; momentum,
attitudes, biases and what acts from outside are each one's own. A recording's equations
without its own unknowns, `R x = z` of `x = [beta | errors]`, are all that another one
needs: with them beside its own it is fitted as if both were fitted at once.
"""

from collections.abc import Sequence

import numpy as np

from orbident.estimation.output_error.problem import Problem, common_factor
from orbident.estimation.shared import Shared, _triangular
from orbident.estimation.solution import NO_EQUATIONS, OUTSIDE, Solution


def shared_of(problem: Problem, solution: Solution) -> Shared:
    """What a recording says of what it shares, its own unknowns eliminated.

    Args:
        problem: a recording's equations.
        solution: of these.
    """
    state, prior, errors = solution.state, solution.prior, problem.declared
    common = common_factor(problem, solution.weights, state)
    first = OUTSIDE + state.beta.size + len(errors)
    shared = np.arange(OUTSIDE, first)
    own = [*range(OUTSIDE), *range(first, state.common.size)]
    # What is known of the shared ones beforehand is known once, not in each recording.
    std = prior.std.copy()
    std[shared] = np.inf
    alone = prior._replace(std=std, others=NO_EQUATIONS)
    factor = alone.added(common, state)
    left = _triangular(factor[:, [*own, *shared, -1]])[len(own) : -1, len(own) :]
    left[:, -1] += left[:, :-1] @ state.common[shared]
    return Shared(state.beta, errors, left)


def together(parts: Sequence[Shared]) -> Shared:
    """What several recordings say.

    Args:
        parts: what each of them says; the last was linearised nearest to the truth.
    """
    errors = {each.name: each for part in parts for each in part.errors}
    every = tuple(errors.values())
    rows = np.vstack([part.over(every) for part in parts])
    return Shared(parts[-1].beta, every, _triangular(rows)[: rows.shape[1] - 1])
