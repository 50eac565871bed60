"""What may act from outside, and is too faint to be sure of.

A group of disturbances is taken for zero unless noise hardly ever looks like it. Where
the robot's own motion shows nearly as the group does, parameters take its place, and
are then far off though sensors show little. So where noise alone looks as much like it
in fewer than one of a hundred recordings, deviations hold both that the group acts and
that it does not. If its numbers `c` were unknowns, the others would change by `B c`,

    R_x B = -R_xc,   C_c = (R_c' R_c)^-1,   c = C_c R_c' z,

and the mean square error of an estimate that takes them for zero is, beside `C`,

    B (C_c + c c') B'                                   (as in Hausman 1978)
"""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular
from scipy.special import chdtri

from orbident.estimation.output_error.disturbance_sizes import places_of
from orbident.estimation.output_error.forms import IN_WORDS
from orbident.estimation.output_error.problem import OUTSIDE
from orbident.estimation.output_error.sensitivity import TakenForZero, fall

SUSPICIOUS = 1e-2
"""Probability that noise alone looks as much like any of the groups."""


class Suspected(NamedTuple):
    """A group that may act, though nothing is sure."""

    falls: float
    """How far chi-square would fall if it were among the unknowns."""
    off: Float[np.ndarray, "beta n"]
    """Deviations of `beta` by it, which are independent of each other."""


def suspected(zeros: TakenForZero, groups: Collection[str]) -> dict[str, Suspected]:
    """The groups, of those taken for zero, that chance hardly explains.

    Args:
        zeros: of the solution.
        groups: that may act.
    """
    found, state = {}, zeros.solution.state
    size, of_beta = state.common.size, slice(OUTSIDE, OUTSIDE + state.beta.size)
    for group in sorted(groups):
        places = places_of(zeros.problem, [group])
        left = zeros.equations(places)
        falls = fall(left, np.arange(places.size))
        if falls < chdtri(places.size, SUSPICIOUS / len(groups)):
            continue
        columns = size + np.flatnonzero(np.isin(zeros.places, places))
        R_x, R_xc = zeros.factor[:size, :size], zeros.factor[:size, columns]
        B = -solve_triangular(R_x, R_xc)[of_beta]
        inverse = np.linalg.pinv(left[:, :-1])
        off = B @ np.column_stack([inverse, inverse @ left[:, -1]])
        found[group] = Suspected(falls, off)
    return found


def suspects_in_words(falls: Mapping[str, float]) -> Iterator[str]:
    """Notes on what may act, by its group: how far chi-square would fall."""
    for group, each in falls.items():
        yield (
            f"perhaps {IN_WORDS[group]}: chi-square would fall by {each:.3g} if that "
            "were among the unknowns, as by chance it does in fewer than one of a "
            "hundred recordings; deviations hold that it acts and that it does not: "
            f"if it acts, say so (--disturbance {group})"
        )
