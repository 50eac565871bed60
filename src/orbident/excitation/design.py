"""The exciting trajectory of a robot: conditions, search, guarantee, scores."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.conditions import Conditions, conditions_for
from orbident.excitation.criterion import OBJECTIVES, Objective
from orbident.excitation.design_problem import problem_for
from orbident.excitation.guarantee import Flown, Proven, floated, proven_within
from orbident.excitation.information import weights_of
from orbident.excitation.joint_limits import check_ends, inner_point, polytope_of
from orbident.excitation.outside_changes import anything_may_act
from orbident.excitation.scores import CriterionValues, information_of, scores_of
from orbident.excitation.search import (
    Effort,
    Feasible,
    JointSearch,
    Progress,
    SearchSpace,
)
from orbident.excitation.swinging import design_swinging
from orbident.excitation.thruster_pulses import design_pulses
from orbident.files.json_parts import nulled
from orbident.files.names import listed
from orbident.robot.description import Robot
from orbident.robot.joint_schema import coupled_joints
from orbident.threads import one_blas_thread
from orbident.trajectories.trajectory import Trajectory

STARTS = 24
"""So many at least, where nothing is asked for."""

EVALUATIONS = 1500
"""And so many evaluations of the criterion in the first descents, some 2 ms each."""

HARMONICS = (3, 6, 10, 16, 32)
"""Numbers that the search tries; the first is the paper's."""

MOST_COORDINATES = 128
"""Of all joints together: a step of SLSQP with more takes longer than the criterion."""

LIMIT_STEPS = 64
"""Steps between the nodes at which the second descents keep the joints' limits, at
least."""

LIMIT_STEPS_A_PERIOD = 16
"""The same, in a period of the highest harmonic."""

COARSER = 2
"""The first descents keep them at so many times fewer: they only compare starts."""

FINER = 8
"""The best are descended once more under limits at so many times more nodes: between
these, limits hold to 2 in 10000."""

JUDGED = 3
"""So many optima, and so many random motions, are scored on their true motion."""

ALIKE = 1.05
"""Times: how large what acts is, and so the criterion, is known no better than that."""

RESERVED = 0.1
"""Share of a budget that is kept for the proof and the scores."""


class Judged(NamedTuple):
    """A motion that keeps to its limits for all times, and what it is worth."""

    proven: Proven
    scores: CriterionValues
    value: float
    """The criterion on the true motion; infinite where not all is determined."""
    searched: float
    """The same on the search's grid."""


@one_blas_thread
def design_excitation(
    robot: Robot,
    duration: float = 60.0,
    harmonics: int | None = None,
    objective: Objective | None = None,
    starts: int | None = None,
    budget: float | None = None,
    uncertainty: float = 0.0,
    seed: int = 0,
    conditions: Conditions | None = None,
    beside: Sequence[Trajectory] = (),
    progress: Callable[[Progress], object] = lambda _: None,
) -> Trajectory:
    """Design a trajectory of Eq. 41 that excites all parameters.

    The same seed and number of starts give the same trajectory on the same machine; a
    budget of seconds does not. An interrupt ends the search and keeps the best so far.

    A robot without joints is excited by its thrusters, as `design_pulses` says, and one
    with passive joints by the best motion of its stiff twin, as `design_swinging` says.

    Args:
        robot: with limits of its joints; its inertia is nominal.
        duration: t_f, s.
        harmonics: N_f; by default the search chooses, up to 32, where anything may act
            from outside, or swings, and the objective is of deviations, else 3.
        objective: `"cond"` for the condition number of `Y-hat`; `"d"`, `"a"` or `"e"`
            for the information of all parameters under the robot file's sensors. By
            default `"d"` where the robot file declares the noise of a sensor of the
            base and the conditions name no basis, else `"cond"`.
        starts: so many starts; by default 24, and more where their descents are short.
        budget: instead of `starts`, seconds for all of it.
        uncertainty: relative, of the bodies' masses and sizes; the worst of several
            plausible robots counts.
        seed: of the random starts.
        conditions: instead of duration and harmonics.
        beside: motions that are recorded too: parameters are common, and momentum,
            biases and what acts are each recording's own. Scores are of all together.
        progress: is called after each descent.

    Returns:
        The best one found, on the motion that it really makes, random motions
        included; `design` holds its scores and the extremes that it is proven to keep
        for all times, with nominal inertia.

    Raises:
        InputError: no motion keeps to the limits, or an argument makes no sense.
    """
    _check(objective, starts, budget, uncertainty)
    began = time.perf_counter()
    given = conditions or conditions_for(robot, duration, harmonics)
    if not robot.joints or robot.passive:
        _check_bounded(robot, given, objective, uncertainty, len(beside) + 1)
        effort = Effort(starts or STARTS, budget, began=began)
        if not robot.joints:
            return design_pulses(robot, given, effort, seed, progress)
        numbers = harmonics_tried(robot, given, "d")
        like_this = partial(design_excitation, uncertainty=uncertainty, seed=seed)
        return design_swinging(robot, given, effort, numbers, like_this, progress)
    objective = objective or usual_objective(robot, given)
    if beside:
        _check_adds_up(objective)
    ordered = [each.for_robot(robot) for each in beside]
    flown = [(each, floated(robot, each)) for each in ordered]
    known = information_of(robot, flown) if flown else 0.0
    check_ends(robot.joint_names, given.limits, given.start, given.end)
    spaces = [
        _space(robot, replace(given, harmonics=number), objective, uncertainty, known)
        for number in harmonics_tried(robot, given, objective)
    ]
    effort = Effort(
        starts or STARTS,
        None if budget is None else (1 - RESERVED) * budget,
        # With more harmonics they take several times as long.
        0 if starts else EVALUATIONS // len(spaces),
        began,
    )
    searched = JointSearch(effort, progress, spaces, seed).run()
    drawn = sorted(searched.random, key=lambda found: found.value)
    optima, random = (
        _judged(robot, given, objective, flown, found[:JUDGED])
        for found in (searched.optima, drawn)
    )
    by_chance = min(random, key=lambda each: each.value)
    best = _most_certain([*optima, by_chance])
    scores = best.scores._asdict()
    del scores["deviations"]
    made = {
        "objective": objective,
        "value": nulled(best.value),
        "searched_value": nulled(best.searched),
        "harmonics": best.proven.trajectory.a.shape[1],
        "best_random_start": nulled(by_chance.value),
        "price_of_random_start": by_chance.scores.price,
        "uncertainty": uncertainty,
        "seed": seed,
        "starts": searched.starts,
        "interrupted": searched.interrupted,
        "evaluations": searched.evaluations,
        "median_random_start": float(np.exp(np.median([x.value for x in drawn]))),
        "scores": scores,
        **_margins(robot, given, best.proven),
    }
    return replace(best.proven.trajectory, design=made)


def _check_bounded(
    robot: Robot,
    given: Conditions,
    objective: Objective | None,
    uncertainty: float,
    recordings: int,
) -> None:
    """Refuse what motions that are judged by their bound are not designed for."""
    wrong = {
        f"objective {objective}": objective not in (None, "d"),
        "several recordings": recordings > 1,
    }
    how = "with joints that swing, motions are flown one by one"
    if not robot.joints:
        wrong |= {
            "harmonics": given.harmonics is not None,
            "uncertainty": bool(uncertainty),
        }
        how = "without joints, pulses of thrusters are designed"
    named = [name for name, found in wrong.items() if found]
    if named:
        raise InputError(
            f"{robot.name}: {listed(named)}: {how}, for the objective d and one "
            "recording; leave this out"
        )


def _check_adds_up(objective: Objective) -> None:
    if objective == "cond":
        raise InputError(
            "several recordings: condition numbers do not add up; use the objective d, "
            "a or e"
        )


def design_recordings(
    robot: Robot,
    recordings: int,
    conditions: Conditions,
    objective: Objective | None = None,
    budget: float | None = None,
    **others: Any,
) -> Iterator[Trajectory]:
    """Design a motion for each of several recordings, the best beside those before it.

    An interrupt ends it: the motion that was searched is the last. The conditions are
    those of each recording, and the budget, s, is for all of them. All else is as of
    `design_excitation`.

    Raises:
        InputError: as of `design_excitation`.
    """
    objective = objective or usual_objective(robot, conditions)
    if recordings > 1:
        if not robot.joints or robot.passive:
            _check_bounded(robot, conditions, objective, 0.0, recordings)
        _check_adds_up(objective)
    share = None if budget is None else budget / recordings
    made: list[Trajectory] = []
    while len(made) < recordings:
        found = design_excitation(
            robot,
            objective=objective,
            budget=share,
            conditions=conditions,
            beside=made,
            **others,
        )
        design = {"recordings": recordings, **(found.design or {})}
        made.append(replace(found, design=design))
        yield made[-1]
        if design["interrupted"]:
            return


def harmonics_tried(
    robot: Robot, given: Conditions, objective: Objective
) -> tuple[int, ...]:
    """Numbers of harmonics to search.

    More avoid the band of what acts slowly, and ring what swings.
    """
    if given.harmonics is not None:
        return (given.harmonics,)
    if objective == "cond" or not (robot.passive or anything_may_act(robot)):
        return HARMONICS[:1]
    joints = max(len(coupled_joints(robot).free), 1)
    most = max(MOST_COORDINATES / joints / 2, HARMONICS[0])
    return tuple(number for number in HARMONICS if number <= most)


def _space(
    robot: Robot,
    given: Conditions,
    objective: Objective,
    uncertainty: float,
    known: Float[np.ndarray, "common common"] | float,
) -> SearchSpace:
    problem = problem_for(robot, given, objective, uncertainty, known)
    steps = max(LIMIT_STEPS, LIMIT_STEPS_A_PERIOD * problem.motions.harmonics)
    few, more, many = (
        polytope_of(problem.motions.resampled(nodes + 1), given.limits)
        for nodes in (steps // COARSER, steps, FINER * steps)
    )
    free = {k: robot.joint_names[k] for k in problem.motions.coupled.free}
    middle = problem.gentlest(more, inner_point(many, given.limits, free))
    return SearchSpace(problem, (few, more, many), middle)


def usual_objective(robot: Robot, given: Conditions) -> Objective:
    """`d` where sensors are declared: errors are then several times smaller.

    A basis is named for its condition number. What is judged by its bound has no other.
    """
    if not robot.joints or robot.passive:
        return "d"
    return "d" if given.basis is None and weights_of(robot.sensors) else "cond"


def _judged(
    robot: Robot,
    given: Conditions,
    objective: Objective,
    flown: list[Flown],
    candidates: list[Feasible],
) -> list[Judged]:
    """What motions are worth when they are made small enough for their limits."""
    judged = []
    for (problem, _, middle), _, y in candidates:
        proven = proven_within(robot, given, problem.motions, middle, y)
        scores = scores_of(
            robot, [*flown, (proven.trajectory, proven.motion)], given.basis
        )
        value = getattr(scores, "cond_Y" if objective == "cond" else objective)
        there = problem.evaluate(middle + proven.share * (y - middle), 1.0)
        judged.append(
            Judged(
                proven,
                scores,
                np.inf if value is None else value,
                float(np.exp(there.exact)),
            )
        )
    return judged


def _most_certain(found: list[Judged]) -> Judged:
    """The motion that what acts costs least, among those as good as the best one."""
    enough = ALIKE * min(each.value for each in found)
    alike = [each for each in found if each.value <= enough]
    return min(alike, key=lambda each: (each.scores.price or 1.0, each.value))


def _margins(robot: Robot, given: Conditions, proven: Proven) -> dict[str, Any]:
    """The extremes for all times beside their limits; None where there is none."""
    limits, base = given.limits, proven.base
    entries = proven.joints.beside(limits, robot.joint_names)
    of_base = {}
    for name in ("rate", "excursion", "wheel_speed"):
        limit = limits.base_rate if name == "rate" else getattr(limits, name)
        of_base[name] = nulled(getattr(base, name))
        of_base[f"{name}_limit"] = nulled(limit)
    if base.table:
        of_base["table"] = [nulled(side) for side in base.table]
        of_base["table_limit"] = [nulled(side) for side in limits.table]
    return {"amplitude_kept": proven.share, "proven": {"joints": entries, **of_base}}


def _check(
    objective: str | None, starts: int | None, budget: float | None, uncertainty: float
) -> None:
    if objective not in (None, *OBJECTIVES):
        raise InputError(
            f"objective '{objective}' is unknown; use {', '.join(OBJECTIVES)}"
        )
    if starts is not None and starts < 1:
        raise InputError(f"starts: found {starts}; give one or more")
    if budget is not None and not 0 < budget < np.inf:
        raise InputError(f"budget: found {budget:g}; give a number of seconds")
    if starts is not None and budget is not None:
        raise InputError("starts and budget exclude each other; give one of them")
    if not 0 <= uncertainty < 1:
        raise InputError(
            f"uncertainty: found {uncertainty:g}; give a fraction, 0.1 for 10 %"
        )
