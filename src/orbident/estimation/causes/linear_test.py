"""Which convention makes the linear equations 24 and 31 fit best."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.causes.convention import Convention
from orbident.estimation.causes.conventions import conventions
from orbident.estimation.linear_fits import fit
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.preprocessing.samples import Samples

ROWS = 1000
"""So many samples from the beginning of a recording show a wrong convention as well as
all of them do."""

FALLS = 2.0
"""Times that the residuals of both equations together must be smaller."""

PLAINLY = 1.1
"""Times better than a simpler suspicion, which comes before."""

UNLIKELY = 1e3
"""Times that residuals count where `pi` or `phi` is far from the nominal one: a gain
leaves the residuals as they are."""

TINY = 1e-300

FARTHEST = 5.0
"""Times: bodies are known better than that before they are built."""


class CorrectedConvention(NamedTuple):
    """A convention, put right."""

    convention: Convention
    falls: float
    """The residuals as recorded, over those with the convention put right."""


def tried_conventions(problem: MomentumProblem) -> list[CorrectedConvention]:
    """Each convention with the factor by which it lowers the residuals, best first.

    A later one counts only where it is plainly better than all before.
    """
    part = problem.beginning(ROWS)
    before = linear_misfit(part, part.samples)
    found = []
    for convention in conventions(part):
        left = _misfit(part, convention)
        found.append(
            CorrectedConvention(convention, before / left if left > 0 else 0.0)
        )
    best, worth = 0.0, {}
    for k, one in enumerate(found):
        if one.falls > PLAINLY * best:
            best = one.falls
            worth[k] = one
    others = [one for k, one in enumerate(found) if k not in worth]
    first = sorted(worth.values(), key=lambda one: -one.falls)
    return [*first[:1], *sorted([*first[1:], *others], key=lambda one: -one.falls)]


def _misfit(problem: MomentumProblem, convention: Convention) -> float:
    try:
        return linear_misfit(problem, convention.amended(problem))
    except InputError:
        return np.inf


def linear_misfit(problem: MomentumProblem, samples: Samples) -> float:
    """Residuals over all that there is to explain, of both equations.

    Args:
        problem: whose minimal sets count.
        samples: of its recording, as they would be.

    Raises:
        InputError: there are fewer equations than unknowns.
    """
    robot, sets = problem.robot, problem.sets
    fits = fit(robot, sets, samples, problem.initial_momentum, lambda _: None)
    left = [
        each.unexplained / np.hypot(each.explained, each.unexplained)
        for each in (fits.pi, fits.phi)
        if each.explained > 0
    ]
    if not np.isfinite(left).all():
        return np.inf
    far = _far(fits.pi.values, sets.pi(robot.theta)) + _far(
        fits.phi.values, sets.phi(robot.theta)
    )
    return float(np.prod(left)) * UNLIKELY**far


def _far(values: Float[np.ndarray, " n"], nominal: Float[np.ndarray, " n"]) -> bool:
    """Opposite, or of another size."""
    gain = float(values @ nominal) / max(float(nominal @ nominal), TINY)
    return not 1 / FARTHEST < gain < FARTHEST
