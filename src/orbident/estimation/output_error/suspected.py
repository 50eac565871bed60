"""What may act from outside, and is too faint to be sure of.

A group of disturbances is taken for zero unless noise hardly ever looks like it. Where
the robot's own motion shows nearly as the group does, parameters take its place, and
are then far off though sensors show little. So where noise alone looks as much like it
in fewer than one of a hundred recordings, deviations hold both that the group acts and
that it does not, unless the robot file says what acts. If its numbers `c` were
unknowns, the others would change by `B c`,

    R_x B = -R_xc,   C_c = (R_c' R_c)^-1,   c = C_c R_c' z,

and the mean square error of an estimate that takes them for zero is, beside `C`,

    B (C_c + c c') B'                                   (as in Hausman 1978)

What is fainter is in no deviation. The sensitivity table says how far off it could be.
Where that is far, the result calls for care unless the robot file says what acts.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular
from scipy.special import chdtri

from orbident.estimation.output_error.disturbance_sizes import places_of
from orbident.estimation.output_error.forms import IN_WORDS
from orbident.estimation.output_error.sensitivity import TakenForZero
from orbident.estimation.solution import OUTSIDE
from orbident.estimation.unknowns import UNSEEN, Sensitivity, fall

SUSPICIOUS = 1e-2
"""Probability that noise alone looks as much like any of the groups."""


class Faint(NamedTuple):
    """A group that is taken for zero."""

    falls: float
    """How far chi-square would fall if it were among the unknowns."""
    limit: float
    """Beyond which it is suspected."""
    off: Float[np.ndarray, "beta n"]
    """Deviations of `beta` by it, which are independent of each other; the last is by
    what it seems to be, the others are of that."""

    @property
    def suspected(self) -> bool:
        """Whether chance hardly explains what it seems to be."""
        return self.falls >= self.limit

    @property
    def unseen(self) -> Float[np.ndarray, " beta"]:
        """How far `beta` could be off by it while it is not suspected.

        The largest of `B c` with `|R_c c|` at its limit.
        """
        return np.sqrt(self.limit) * np.linalg.norm(self.off[:, :-1], axis=1)


def taken_for_zero(zeros: TakenForZero) -> dict[str, Faint]:
    """Every group of disturbances that a solution takes for zero, by its name."""
    found, state = {}, zeros.solution.state
    size, of_beta = state.common.size, slice(OUTSIDE, OUTSIDE + state.beta.size)
    for group in sorted(zeros.groups):
        places = places_of(zeros.problem, [group])
        left = zeros.equations(places)
        columns = size + np.flatnonzero(np.isin(zeros.places, places))
        R_x, R_xc = zeros.factor[:size, :size], zeros.factor[:size, columns]
        B = -solve_triangular(R_x, R_xc)[of_beta]
        inverse = np.linalg.pinv(left[:, :-1])
        found[group] = Faint(
            fall(left, np.arange(places.size)),
            float(chdtri(places.size, SUSPICIOUS / len(zeros.groups))),
            B @ np.column_stack([inverse, inverse @ left[:, -1]]),
        )
    return found


def with_unseen(
    table: Sensitivity, unseen: Mapping[str, Float[np.ndarray, " beta"]]
) -> Sensitivity:
    """The sensitivity table with how far what acts unseen could shift parameters.

    Args:
        table: of errors of instruments.
        unseen: the largest shifts of `beta`, by the group of what acts.
    """
    return table._replace(
        names=(*table.names, *unseen),
        units=(*table.units, *(UNSEEN for _ in unseen)),
        shift=np.column_stack([table.shift, *unseen.values()]),
    )


def suspects_in_words(falls: Mapping[str, float]) -> Iterator[str]:
    """Notes on what may act, by its group: how far chi-square would fall."""
    for group, each in falls.items():
        yield (
            f"perhaps {IN_WORDS[group]}: chi-square would fall by {each:.3g} if that "
            "were among the unknowns, as by chance it does in fewer than one of a "
            "hundred recordings; deviations hold that it acts and that it does not: "
            f"if it acts, say so (--disturbance {group}); if it does not, say in the "
            "robot file what does (disturbances: [] for nothing)"
        )
