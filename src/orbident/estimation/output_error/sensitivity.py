"""What calibration errors that are taken for zero would do to an estimate.

At a solution the equations of the undeclared errors `c`, after those of all other
unknowns `x`, are

    R_x dx + R_xc c = 0
             R_c  c = z

An error `c` therefore shifts an estimate that takes it for zero by `R_x^-1 R_xc c`. If
one error alone were an unknown, it would be `r z / |r|^2` with `r` its column of `R_c`,
and chi-square would fall by `(r z)^2 / |r|^2` (score test).

An error of scale may seem likely only because it makes all momentum smaller, and with
it the waves `w` of a walk, which are about zero (`walks.py`). That less of a walk is
left to be explained too is not in these equations; so what `|w|^2` falls by does not
count.

What may act from outside, and is too faint to be sure of.

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

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.environment.agents import IN_WORDS, WALKS
from orbident.estimation.levels import limit
from orbident.estimation.output_error.disturbance_sizes import places_of
from orbident.estimation.output_error.problem import Problem, common_factor
from orbident.estimation.solution import OUTSIDE, Solution
from orbident.estimation.unknowns import (
    UNSEEN,
    Calibration,
    Freed,
    Sensitivity,
    explained,
)

SMALL_ERROR = {
    "rad": ("mrad", 1e-3),
    "m": ("mm", 1e-3),
    "1": ("%", 1e-2),
    "s": ("ms", 1e-3),
}
"""What a table counts errors in, by their SI unit."""


@dataclass(frozen=True)
class TakenForZero:
    """What a solution takes for zero: errors of instruments, and what may act."""

    problem: Problem
    solution: Solution
    groups: Collection[str] = ()
    """The groups of disturbances whose zeros are considered too."""

    @cached_property
    def errors(self) -> tuple[Calibration, ...]:
        """The errors of instruments that the solution takes for zero."""
        selected = self.solution.state.selected
        return tuple(
            each for each in self.problem.calibrations if each.place not in selected
        )

    @cached_property
    def places(self) -> Float[np.ndarray, " zeros"]:
        """Where the core has them: errors first."""
        acts = places_of(self.problem, self.groups) if self.groups else []
        of_errors = [each.place for each in self.errors]
        unselected = np.setdiff1d(acts, self.solution.state.selected)
        return np.array([*of_errors, *unselected], float)

    @cached_property
    def factor(self) -> Float[np.ndarray, "n n"]:
        """Triangular, over changes of the solution's unknowns, of these, and rhs."""
        state = self.solution.state.selecting(self.places)
        factor = common_factor(self.problem, self.solution.weights, state)
        self.problem.acting.forget()
        prior = self.solution.prior.extended(np.full(self.places.size, np.inf))
        return prior.added(factor, state)

    def equations(
        self, places: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "zeros columns"]:
        """`[R_c, z]` of what is at these places, after those of the unknowns."""
        left = self.factor[-1 - self.places.size : -1, -1 - self.places.size :]
        return left[:, [*np.flatnonzero(np.isin(self.places, places)), -1]]


def sensitivity(zeros: TakenForZero) -> Sensitivity:
    """The effect of each calibration error that is not among a solution's unknowns.

    Args:
        zeros: of the solution.
    """
    errors, state = zeros.errors, zeros.solution.state
    size = state.common.size
    x = slice(size)
    of_beta = slice(OUTSIDE, OUTSIDE + state.beta.size)
    left = zeros.equations(zeros.places[: len(errors)])
    R_x = zeros.factor[x, x]
    by = solve_triangular(R_x, zeros.factor[x, size : size + len(errors)])
    root = solve_triangular(R_x, np.eye(size))[of_beta]
    small = [SMALL_ERROR[each.unit] for each in errors]
    freed = [
        _freed(each.name, column, left[:, -1])
        for each, column in zip(errors, left[:, :-1].T, strict=True)
    ]
    by_walks = _fall_of_walks(zeros, by, np.array([each.value for each in freed]))
    return Sensitivity(
        names=tuple(each.name for each in errors),
        units=tuple(unit for unit, _ in small),
        shift=by[of_beta] * np.array([one for _, one in small]),
        covariance=root @ root.T,
        freed=tuple(
            each._replace(chi2_drop=each.chi2_drop - float(fallen))
            for each, fallen in zip(freed, by_walks, strict=True)
        ),
        left=left,
    )


def _fall_of_walks(
    zeros: TakenForZero,
    by: Float[np.ndarray, "unknowns errors"],
    values: Float[np.ndarray, " errors"],
) -> Float[np.ndarray, " errors"]:
    """How much smaller the waves of walks would be, in squared deviations, not below 0.

    Args:
        zeros: of the solution.
        by: the change of all unknowns by each error, with the other sign.
        values: of the errors.
    """
    solution = zeros.solution
    selected = solution.state.selected
    if np.all(selected < zeros.problem.recorded.places):
        # Instruments alone: to work out what may act takes some 3 kB a row.
        return np.zeros(values.size)
    walks = np.isin(selected, places_of(zeros.problem, WALKS))
    here = solution.state.common.size - walks.size + np.flatnonzero(walks)
    std = solution.prior.std[here, None]
    waves = solution.state.common[here, None] / std
    after = waves - by[here] * values / std
    return np.maximum(np.sum(waves**2 - after**2, axis=0), 0.0)


def _freed(
    name: str, column: Float[np.ndarray, " n"], z: Float[np.ndarray, " n"]
) -> Freed:
    """An error that nothing shows has an infinite deviation."""
    size = float(np.linalg.norm(column))
    if not size:
        return Freed(name, 0.0, np.inf, 0.0)
    along = float(column @ z) / size
    return Freed(name, along / size, 1 / size, along**2)


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
            explained(left[:, :-1], left[:, -1]).fall,
            limit("suspicion", places.size, len(zeros.groups)),
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
