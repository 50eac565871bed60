"""Why a recording is refused: causes are tried, and what explains it is named."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from orbident.choices import CauseSearch
from orbident.diagnosis.events import event
from orbident.diagnosis.filters import smoothed
from orbident.diagnosis.frames import missing_wheel, point_of_a_link
from orbident.diagnosis.jumps import jumps
from orbident.diagnosis.late_clocks import already_corrected, clocks, far_off
from orbident.diagnosis.likeliest import LIKELIEST, Scored, every_score, likeliest
from orbident.diagnosis.linear_test import (
    FALLS,
    CorrectedConvention,
    tried_conventions,
)
from orbident.diagnosis.noisier_sensors import (
    lasting_errors,
    noisier_sensors,
    spikes,
)
from orbident.diagnosis.recorded_pulses import pulses_put_right, slow_duty
from orbident.diagnosis.rings import rigid_motion, ring_of
from orbident.diagnosis.stale import stale
from orbident.diagnosis.trial import (
    Rival,
    Trial,
    amended_trial,
    best_trial,
    chi_square_left,
    is_as_noise,
    rank,
    sure_trial,
)
from orbident.environment.agents import AGENTS
from orbident.estimation.allowance import Allowance, GivenUpError, limited_to
from orbident.estimation.checks import Check
from orbident.estimation.clock_search import WORTH, misfit
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.obstacles import MASS_BESIDE_NOMINAL, scale_beside_nominal
from orbident.estimation.output_error.joint_laws import elsewhere
from orbident.estimation.residual_checks import leaves_nothing
from orbident.files.names import joined
from orbident.recordings.column_checks import float32_step
from orbident.robot.description import KnownQuantities
from orbident.threads import one_blas_thread

EXPLAINS = 100.0
"""Fall in chi-square from which on a cause is worth a word though others are left."""

MOST = 0.5
"""Part of what a trial explains that clocks did which had been corrected before it; and
part of chi-square that a trial leaves which explains most."""

SEARCH_ON = "; the search ended after some seconds, and '--causes all' goes on"
"""What is said where not all causes were tried."""

LOST = 6
"""Trials without a least cost, after which nothing is tried any more: where many things
are wrong, putting one of them right does not bring a fit."""

ANSWER = 1.3e5
"""Samples that a fit and a quick search go through together (`allowance.py`): some ten
seconds of CPU. Then it gives up what it is at: an event takes ten fits."""

BEGUN = 4e4
"""With fewer of these left, no further trial of a cause begins."""

LEAST = 6.5e4
"""So many a quick search has in any case."""


@one_blas_thread
def causes(solved: Solved, search: CauseSearch = "quick") -> tuple[Check, ...]:
    """What is most likely wrong with a refused recording; it takes some seconds.

    Args:
        solved: what the result was judged by.
        search: whether it ends after some seconds, with the likeliest causes tried.
    """
    said = {one.name for one in solved.hindered} & {"cause", "motion", "velocity of S"}
    if search == "none" or said:
        return ()
    left = max(ANSWER - solved.work, LEAST) if search == "quick" else np.inf
    allowance, found = Allowance(left), list[Check]()
    try:
        with limited_to(allowance):
            found.extend(_causes(solved, allowance))
    except GivenUpError:
        if not found:
            # Whether something rings needs no further fit.
            ring = _ring(solved.problem, solved.shown)
            found = [ring or _nothing("", SEARCH_ON)]
    return tuple(found)


def _causes(solved: Solved, allowance: Allowance) -> Iterator[Check]:
    problem, shown = solved.problem, solved.shown
    plain = next(_seen_by_themselves(problem), None)
    if plain is not None:
        yield plain
        return
    swings = shown and elsewhere(problem.robot.passive, shown.springs)
    if swings or _of_the_scale(solved):
        # That is said: with other joints, or without a scale, anything may explain it.
        return
    # Trials are compared with a fit in which nothing acts more than it may.
    usual = shown.expected() if shown and shown.expected else shown
    # A jump spoils the linear equations, where it may look like a wrong sign.
    now = misfit(usual) if usual else np.inf
    jumped = (
        [sure_trial(one, now) for one in jumps(problem, usual, now)] if usual else []
    )
    if any(one.accepted for one in jumped):
        yield _explained(min(jumped, key=rank), now)
        return
    wrong, *_ = conventions = tried_conventions(problem)
    if usual:
        # That parameters are of a likelier sign is not enough where it can be tried.
        yield from _by_trials(solved, usual, conventions, jumped, allowance)
    else:
        # Without a fit nothing else can be scored.
        found = [_explained(one, now) for one in missing_wheel(problem) if one.accepted]
        happened = event(problem) if solved.hindered and not found else None
        if happened is not None:
            found = [_found(happened.words(), happened.remedy)]
        # Linear equations know nothing of thrust.
        plain = not problem.samples.unknown_thrust and wrong.falls > FALLS
        if plain and not solved.hindered:
            found = found or [wrong.check()]
        yield from found


def _seen_by_themselves(problem: MomentumProblem) -> Iterator[Check]:
    """What samples and commands show without a fit of all sensors."""
    step = float32_step(problem.recording.t)
    if step:
        yield _found(
            f"the times were kept as float32, in steps of {step:.2g} s",
            "write times as float64, or seconds from a start that is near",
        )
    for words in stale(problem.robot, problem.recording):
        yield _found(
            words, "record each sample once, when it is taken, with all its digits"
        )
    pulses, slow = [*pulses_put_right(problem)], slow_duty(problem)
    if slow and not any(one.accepted for one in pulses):
        yield _found(slow, "record a row at every switching of a thruster")
    for one in pulses:
        now = "accepted" if one.accepted else "still refused, so that more is wrong"
        words = f"{one.cause}: with that corrected the recording is {now}"
        yield _found(words, "correct the recording or the robot file")


def _of_the_scale(solved: Solved) -> bool:
    """Whether there is no scale, or a unit of the wheels' speeds explains the mass."""
    found, shown, unit = solved.estimate, solved.shown, scale_beside_nominal(solved)
    # A unit leaves the residuals as they are.
    alone = found.converged and (shown is None or leaves_nothing(solved.problem, shown))
    wrong = [*solved.hindered, *(unit if alone else [])]
    return any(
        one.level == "do not trust" and one.name in {"scale", MASS_BESIDE_NOMINAL}
        for one in wrong
    )


def _by_trials(
    solved: Solved,
    usual: Estimate,
    conventions: list[CorrectedConvention],
    jumped: list[Trial],
    allowance: Allowance,
) -> Iterator[Check]:
    """What output error finds, or what may have happened."""
    shown, now = solved.shown or usual, misfit(usual)
    corrected = already_corrected(solved.problem)
    before = corrected.before.misfit if corrected else now
    if corrected and before < now and corrected.before.estimate:
        # Clocks seemed late because of what is looked for.
        shown = usual = corrected.before.estimate
        now = before
        solved = solved._replace(problem=corrected.recorded)
    compared = solved._replace(shown=usual)
    trials = [*jumped, *_tried(compared, conventions, before, allowance)]
    if corrected and now < before:
        trials.append(Trial(corrected.cause, False, now))
    best = best_trial(trials, before)
    if best is not None and best.accepted:
        if corrected and before - now > MOST * (before - best.misfit):
            best = best._replace(cause=f"{corrected.cause}, and {best.cause}")
        yield _explained(best, before)
        return
    if leaves_nothing(solved.problem, shown):
        # Nothing is left to explain: the numbers themselves say what is wrong.
        return
    ring = _ring(solved.problem, shown)
    if ring is not None:
        # What is left rings, so it is no event, nor what explains some of it.
        yield ring
        return
    # As an event, too, makes clocks seem late, parts are on the clocks as recorded.
    problem = corrected.recorded if corrected else solved.problem
    yield from _unexplained(problem, shown, best, before, allowance)


def _ring(problem: MomentumProblem, shown: Estimate | None) -> Check | None:
    """What rings, in what a fit leaves."""
    moved = rigid_motion(problem.robot, problem.samples)
    ring = ring_of(shown.signals if shown else (), moved)
    return ring and _found(ring.reason, ring.remedy)


def _unexplained(
    problem: MomentumProblem,
    shown: Estimate,
    best: Trial | None,
    before: float,
    allowance: Allowance,
) -> Iterator[Check]:
    """What may have happened, or explains most, where no trial is accepted."""
    falls = before - best.misfit if best else -np.inf
    # Then no event is left to explain, though the residuals may not be white.
    shrunk = best is not None and is_as_noise(best.estimate) and not is_as_noise(shown)
    ended, happened = allowance.left < BEGUN, None
    try:
        happened = None if shrunk else event(problem)
    except GivenUpError:
        ended = True
    more = SEARCH_ON if ended else ""
    likeliest = best.cause if best is not None and falls > EXPLAINS else ""
    if happened is not None and (happened.sure or not likeliest):
        # What leaves most of it is no help beside what happened.
        left = chi_square_left(best.estimate if best else None)
        helps = left < MOST * chi_square_left(shown)
        yield _found(happened.words(likeliest if helps else ""), happened.remedy)
    elif likeliest:
        yield _found(
            f"perhaps {likeliest}: correcting it lowers chi-square by {falls:.2g}, "
            "more than any other cause that was tried, but not enough",
            "see whether more than one thing is wrong: with tolerances in the robot "
            f"file errors of several instruments are estimated at once{more}",
            falls,
        )
    else:
        yield _nothing(
            "" if ended or shrunk else "no part of the recording fits, and ", more
        )


def _nothing(fits: str, more: str) -> Check:
    """Nothing that was tried is a cause."""
    return _found(
        f"{fits}no cause that was tried explains it (perhaps something moves in the "
        "robot: a loose mass, sloshing, flexible joints)",
        f"see whether anything in it is loose or acts on it{more}",
    )


def _explained(best: Trial, before: float) -> Check:
    """A trial that is accepted: the cause, if no other one may explain as much."""
    falls = before - best.misfit
    acting = [AGENTS[x] for x in best.estimate.unexpected] if best.estimate else []
    if acting:
        # Either may stand for what the other one is.
        acts = joined([each.words for each in acting])
        return _found(
            f"perhaps {acts}, and {best.cause}: with both the recording is accepted "
            f"(chi-square falls by {falls:.2g})",
            "; ".join(filter(None, (each.remedy for each in acting)))
            or "see whether it acts",
            falls,
        )
    words = (
        f"{best.cause}: with that corrected the recording is accepted "
        f"(chi-square falls by {falls:.2g})"
    )
    remedy = "correct it"
    if best.tolerable:
        remedy = "correct it, or declare its tolerance in the robot file"
    elif best.score is not None:
        # Its size was held fixed: standard deviations do not include its own error.
        remedy = "measure how large it is, and correct it"
    if best.seen or falls > best.rival.falls + WORTH:
        return _found(words, remedy, falls)
    other = best.rival.cause
    return _found(
        f"perhaps {words}; or perhaps {other}, which may look like it",
        f"find out which of them it is, and then {remedy}",
        falls,
    )


def _tried(
    solved: Solved,
    conventions: list[CorrectedConvention],
    before: float,
    allowance: Allowance,
) -> list[Trial]:
    """Where some of these explain all, the rest need not be tried.

    That goes on while enough may be done.
    """
    trials, untried = list[Trial](), list[Scored]()
    with suppress(GivenUpError):
        for some in _stages(solved, conventions, untried, before):
            for one in some:
                trials.append(sure_trial(one, before))
                if sum(each.lost for each in trials) == LOST or allowance.left < BEGUN:
                    return [_beside(one, untried, before) for one in trials]
            if any(one.accepted for one in trials):
                break
    return [_beside(one, untried, before) for one in trials]


def _stages(
    solved: Solved,
    conventions: list[CorrectedConvention],
    untried: list[Scored],
    before: float,
) -> Iterator[Iterable[Trial]]:
    """What is tried, in this order; and what has a score and is not tried yet."""
    problem = solved.problem
    yield _not_as_weighed(solved)
    yield smoothed(problem)
    yield _written(conventions, problem)
    yield point_of_a_link(problem)
    # What the linear equations see is no small error, which others would follow.
    late = far_off(problem)
    far = any(late.values())
    yield clocks(problem, late) if far else ()
    scores = every_score(solved, before, far)
    untried += sorted(scores, key=lambda each: -each.falls)
    yield likeliest(untried)
    # A part that swings fast looks like noise, and like spikes.
    yield from (noisier_sensors(problem), spikes(problem))
    # Wrong inertias of known wheels may look like another one.
    yield missing_wheel(problem)
    yield lasting_errors(problem, shown=solved.shown)


def _beside(one: Trial, untried: list[Scored], before: float) -> Trial:
    """A trial, and the best of what was not tried, which may look like it.

    Between two that have a score, that says by how much more one of them explains.
    """
    if not untried:
        return one
    falls = untried[0].falls
    if one.score is not None:
        falls += before - one.misfit - one.score
    return one._replace(rival=max(one.rival, Rival(falls, untried[0].cause)))


def _not_as_weighed(solved: Solved) -> Iterator[Trial]:
    """What scales and balances said, left out where the recording says otherwise."""
    if solved.shown and solved.shown.weighed.is_no_chance("other parameters"):
        robot = replace(solved.problem.robot, known=KnownQuantities())
        cause = (
            "what was weighed (known in the robot file) contradicts what gives the "
            "recording its scale, such as the wheels' inertia"
        )
        yield amended_trial(cause, solved.problem, robot)


def _written(
    conventions: list[CorrectedConvention], problem: MomentumProblem
) -> Iterator[Trial]:
    """Conventions that make parameters likelier, and leave residuals as they are."""
    first = [one.convention for one in conventions if one.falls > FALLS]
    for convention in first[:LIKELIEST]:
        right = convention.written(problem)
        yield amended_trial(convention.cause, problem, recording=right)


def _found(reason: str, remedy: str, statistic: float = float("nan")) -> Check:
    return Check("cause", "do not trust", reason, remedy, statistic)
