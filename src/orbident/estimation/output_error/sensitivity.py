"""What is taken for zero, or not sure, would do to an estimate.

An error `c` shifts an estimate that takes it for zero by `-B c` (`taken_for_zero.py`).

An error of scale may seem likely only because it makes all momentum smaller, and with
it the waves `w` of a walk, which are about zero (`walks.py`). That less of a walk is
left to be explained too is not in these equations; so what `|w|^2` falls by does not
count.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.environment.agents import IN_WORDS, STEADY, WALKS
from orbident.estimation.levels import LEVELS, limit
from orbident.estimation.output_error.hypotheses import Search, Selection
from orbident.estimation.output_error.taken_for_zero import TakenForZero
from orbident.estimation.unknowns import UNSEEN, Sensitivity, score

LOSS = "wheel_loss"

TORQUES = tuple((mean, slow) for slow, mean in STEADY.items())
"""Every torque with what changes slowly of it."""

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
    by_walks = _fall_of_walks(zeros, by, np.array([each.values[0] for each in alone]))
    return Sensitivity(
        names=tuple(names),
        units=tuple(unit for unit, _ in small),
        shift=by[zeros.beta] * np.array([one for _, one in small]),
        covariance=root @ root.T,
        alone={
            name: each._replace(fall=each.fall - float(fallen))
            for name, each, fallen in zip(names, alone, by_walks, strict=True)
        },
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
    walks = np.isin(selected, [each.place for each in zeros.problem.unknowns(WALKS)])
    here = solution.state.common.size - walks.size + np.flatnonzero(walks)
    std = solution.prior.std[here, None]
    waves = solution.state.common[here, None] / std
    after = waves - by[here] * values / std
    return np.maximum(np.sum(waves**2 - after**2, axis=0), 0.0)


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


class Averaged(NamedTuple):
    """What the data leave undecided, as far as it concerns `beta`."""

    off: Float[np.ndarray, "beta n"]
    """Deviations of `beta` that deviations of the fit do not hold; independent."""
    suspected: dict[str, float]
    """What may act too, by its family: how far chi-square would fall."""
    unseen: dict[str, Float[np.ndarray, " beta"]]
    """How far off `beta` could be by what acts too faintly to be seen, by family."""
    instead: dict[str, Float[np.ndarray, " beta"]]
    """What may act in place of what was found: how far off `beta` is then."""


def averaged(
    search: Search, selection: Selection, asked: Collection[str], silent: bool
) -> Averaged:
    """Deviations by what may act, and is too faint to be sure of.

    A family is taken for zero unless noise hardly ever looks like it. Where the robot's
    own motion shows nearly as the family does, parameters take its place, and are then
    far off though sensors show little. So where noise alone looks as much like it in
    fewer than one of a hundred recordings, deviations hold both that it acts and that
    it does not. With `c` the numbers of its score, `C_c` their covariance and `B` their
    effect (`taken_for_zero.py`), the mean square error of an estimate that takes them
    for zero is, beside `C`,

        B (C_c + c c') B'                                   (as in Hausman 1978)

    What is fainter is in no deviation: the sensitivity table says how far off `beta`
    could be, and where that is far the result calls for care.

    Args:
        search: fits the recording.
        selection: what was freed, and what is taken for zero.
        asked: families that the user says act.
        silent: whether the user has not said what acts; who has said so has said that
            nothing else does: chance explains it.
    """
    instead = _instead(search, selection, asked)
    zeros = selection.zeros
    beta = zeros.solution.state.beta
    apart = np.reshape([*instead.values()], (-1, beta.size)).T
    off, suspected, unseen = [apart], dict[str, float](), {}
    for family in sorted(zeros.families):
        left = zeros.equations([family])
        found = zeros.score([family])
        # Of independent numbers of unit variance, then of what it seems to be.
        B = zeros.shift([family])[zeros.beta]
        by = B @ np.column_stack([np.linalg.pinv(left[:, :-1]), found.values])
        most = limit("suspicion", found.values.size, len(zeros.families))
        if silent and found.fall >= most:
            suspected[family] = found.fall
            off.append(by)
        else:
            # The largest of `B c` with `|R_c c|` at the limit.
            unseen[family] = np.sqrt(most) * np.linalg.norm(by[:, :-1], axis=1)
    return Averaged(np.hstack(off), suspected, unseen, instead)


def _instead(
    search: Search, selection: Selection, asked: Collection[str]
) -> dict[str, Float[np.ndarray, " beta"]]:
    """How far off `beta` is if a torque was a loss of wheels, or the other way round.

    A wheel that slows down while its recorded speed stays gives its momentum to the
    rest of the robot, as a torque would. In space the two differ by how the base turns:
    momentum that was lost turns with it, and what a torque has given does not. Where
    the recording does not say which of them it was, deviations hold how far apart both
    results are.

    The likelihood of what is wrong is more than `1 / level` times that of what is right
    with no more than that probability; every number beside what is right lowers
    chi-square by one in the mean.
    """
    problem, found, families = search.problem, selection.found, selection.families
    of_torques = {family for both in TORQUES for family in both}
    alike = {*families} & {*of_torques, LOSS}
    everything = {each.family for each in problem.acting.unknowns} if alike else ()
    # About the vertical of a table both are the same, whatever the base does.
    if LOSS not in everything or {*asked} & {*of_torques, LOSS}:
        return {}
    left = tuple(family for family in families if family not in alike)

    def worth(cost: float, families: Collection[str]) -> float:
        return cost + len(problem.unknowns(families))

    most = worth(found.assumed, families) - 2 * np.log(LEVELS["other explanation"])
    differences = {}
    for others in TORQUES if LOSS in alike else ((LOSS,),):
        other = search.freed((*left, *others))
        if worth(other.cost, (*left, *others)) < most:
            differences[others[-1]] = other.state.beta - found.solution.state.beta
    return differences


def undecided_in_words(
    suspected: Mapping[str, float], instead: Collection[str]
) -> Iterator[str]:
    """Notes on what may act too, and on what may act in place of what was found.

    Args:
        suspected: by family: how far chi-square would fall.
        instead: families.
    """
    for family, fall in suspected.items():
        yield (
            f"perhaps {IN_WORDS[family]}: chi-square would fall by {fall:.3g} if that "
            "were among the unknowns, as by chance it does in fewer than one of a "
            "hundred recordings; deviations hold that it acts and that it does not: "
            f"if it acts, say so (--disturbance {family}); if it does not, say in the "
            "robot file what does (disturbances: [] for nothing)"
        )
    for family in instead:
        yield (
            f"or else {IN_WORDS[family]}: that explains the recording as well, and "
            "deviations hold both; if you know which of them acts, say so "
            "(--disturbance), and they are narrower"
        )
