"""A push for a short time, such as a thruster's burst, is no reason to refuse.

After it both momenta are others. Eqs. 24 and 31 are linear in all that is unknown, so
that the time at which a jump of the momenta explains most is found without a search:
with `r` the residuals without a jump, and `J` its columns less what the others explain,
their squares fall by

    r' J (J' J)^-1 J' r,        J = (1 - Q Q') N [t >= time]

where `N` are the columns of a constant momentum, and `Q` spans those of all unknowns.
What the push adds is then an unknown of maximum likelihood, from which samples while it
lasts are left out.
"""

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import FREE
from orbident.estimation.checks import only_vague
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimator, Progress, Solved
from orbident.estimation.levels import limit
from orbident.estimation.linear_fits import rows_of
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.acting import LONGEST
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.hypotheses import TRIED
from orbident.estimation.output_error.least_cost import FEW_STEPS
from orbident.estimation.solve import in_whole, solved_by
from orbident.model.core_robot import wheels_of
from orbident.preprocessing.leaps import jumps_of

RANK = 1e-9
"""Part of the largest singular value below which columns are dependent."""

TINY = 1e-300
"""Where nothing is left its logarithm is finite, and a part of it a number."""

AROUND = 10
"""Samples before and after the jump in which the push may last."""

FEWEST = 4 * AROUND
"""Samples of a recording in which a jump is looked for."""

LEAVES = 0.5
"""The most that a jump leaves of the squares of what Eq. 24, or Eq. 31, did not explain
without it. Of 28 pushes of random robots that were seen none left more, and where one
left more the jump was another time's."""


def with_push(solved: Solved, estimator: Estimator, progress: Progress) -> Solved:
    """Solve again with a push among the unknowns, if only that makes it acceptable.

    Args:
        solved: a recording without a push.
        estimator: by which it was solved.
        progress: is called with the fraction of the work that is done.
    """
    problem, t = solved.problem, solved.problem.samples.t
    # An exact recording shows none: its sensors are not fitted.
    by_sensors = solved.shown is not None and (
        isinstance(estimator, OutputError) or in_whole(problem)
    )
    sized = FEWEST <= t.size <= LONGEST and by_sensors
    # Eqs. 24 and 31 tell when only where all joints are measured.
    sized = sized and not problem.robot.passive
    # What a robot does after it changed is no push that one robot got.
    history = solved.estimate.history
    sized = sized and not (history and history.changes)
    if solved.hindered or not sized or _fits(solved):
        return solved
    # As it was recorded: nothing is subtracted that was taken for something else.
    problem = problem.amended()
    row, left = jump_of_momenta(problem)
    first, last = t[row - AROUND], t[row + AROUND]
    if left > LEAVES or _a_joint_jumps(problem, first, last):
        return solved
    pushed = problem.amended(pushed=(first, last))
    fit = OutputError(steps=FEW_STEPS, tested=False)
    shown = fit.estimate(pushed, progress)
    # Only where a push explains the recording is it asked what else acts. Any method is
    # judged beside what output error shows.
    if not _fits(Solved(pushed, [], shown, shown)):
        return solved
    assert shown.tested is not None
    shown = shown.tested()
    if not _fits(Solved(pushed, [], shown, shown)):
        return solved
    if _fits_with_an_error(solved):
        return solved
    again = solved_by(estimator, pushed, shown, progress)
    return again if _fits(again) else solved


def _a_joint_jumps(problem: MomentumProblem, first: float, last: float) -> bool:
    """Whether an encoder jumps meanwhile: no push does that, and a slip explains it."""
    recording = problem.recording
    columns = [f"joint.{name}.position" for name in problem.robot.joint_names]
    jumps = [
        jump
        for column in columns
        if recording.has(column)
        for jump in jumps_of(column, recording.t, recording.column(column)[:, None])
    ]
    return any(first <= recording.t[jump.row] <= last for jump in jumps)


def _fits(solved: Solved) -> bool:
    """Whether nothing is wrong; an uncertain mass is no sign of a push."""
    return only_vague(judge(solved, dict(solved.estimate.masses)).checks)


def _fits_with_an_error(solved: Solved) -> bool:
    """Whether an error of an instrument, one number, makes it acceptable as well.

    Then that is likelier than a push, which takes as many numbers as momenta, and hides
    what the samples show that it leaves out.
    """
    problem = solved.problem
    if solved.shown is None or solved.shown.sensitivity is None:
        return False
    alone = solved.shown.sensitivity().alone
    chance = limit("instrument", 1, len(alone))
    likely = sorted(
        (name for name in alone if alone[name].fall > chance),
        key=lambda name: -alone[name].fall,
    )
    for name in likely[:TRIED]:
        freed = OutputError(steps=FEW_STEPS, tested=False, free={name: FREE})
        shown = freed.estimate(problem, lambda _: None)
        if _fits(Solved(problem, [], shown, shown)):
            return True
    return False


def jump_of_momenta(problem: MomentumProblem) -> tuple[int, float]:
    """The first sample after the jump of both momenta that explains most.

    Returns:
        Its row, and the least part that the jump leaves of the squares of what one of
        the equations does not explain without it.
    """
    samples, regressors = problem.samples, problem.sets.regressors
    wheels, batch = wheels_of(problem.robot), samples.batch(0, samples.t.size)
    rows_h, rows_v = rows_of(regressors, wheels, None, batch, samples.drift())
    parts = [_left_by_jumps(rows_h, len(regressors.momentum_axes))]
    if samples.tracked:
        parts.append(_left_by_jumps(rows_v, len(regressors.velocity_axes)))
    # Minus twice the logarithm of the likelihood is, of each equation, its rows times
    # that of its squares. A jump at either end is a constant momentum or none.
    rows = (len(rows_h), len(rows_v))
    costs = [n * np.log(part) for n, part in zip(rows, parts, strict=False)]
    row = AROUND + int(np.argmin(np.sum(costs, axis=0)[AROUND:-AROUND]))
    return row, min(float(part[row]) for part in parts)


def _left_by_jumps(
    rows: Float[np.ndarray, "rows columns"], axes: int
) -> Float[np.ndarray, " samples"]:
    """The part of the residuals' squares that a jump at each sample leaves.

    Args:
        rows: of one equation, first the columns of a constant momentum.
        axes: in which it is conserved.
    """
    N, C, z = rows[:, :axes], rows[:, :-1], rows[:, -1]
    U, size, _ = np.linalg.svd(C, full_matrices=False)
    Q = U[:, size > RANK * size[0]]
    r = z - Q @ (Q.T @ z)
    by_sample = (-1, axes)

    def later(products: Float[np.ndarray, "samples ..."]) -> np.ndarray:
        """Sums over all samples from each one on."""
        return np.cumsum(products[::-1], axis=0)[::-1]

    n = N.reshape(*by_sample, axes)
    b = later(np.einsum("kia,ki->ka", n, r.reshape(by_sample)))
    QN = later(np.einsum("kic,kia->kca", Q.reshape(*by_sample, Q.shape[1]), n))
    M = later(np.einsum("kia,kib->kab", n, n)) - np.swapaxes(QN, 1, 2) @ QN
    fallen = np.einsum("ka,kab,kb->k", b, np.linalg.pinv(M, RANK, hermitian=True), b)
    return np.maximum(1 - fallen / max(float(r @ r), TINY), TINY)
