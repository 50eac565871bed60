"""The exciting trajectory of a robot: conditions, search, proof, scores."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.excitation.assembly import motions_for, problem_for
from orbident.excitation.conditions import Conditions, conditions_for
from orbident.excitation.polytope import check_ends, inner_point, polytope_of
from orbident.excitation.proof import Proven, proven_within
from orbident.excitation.scores import Scores, scores_of
from orbident.excitation.search import Effort, Progress, Searched, search
from orbident.excitation.spectra import OBJECTIVES, Objective
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import Trajectory

STARTS = 24


@in_float64
def design_excitation(
    robot: Robot,
    duration: float = 60.0,
    harmonics: int = 3,
    objective: Objective = "cond",
    starts: int | None = None,
    budget: float | None = None,
    uncertainty: float = 0.0,
    seed: int = 0,
    conditions: Conditions | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> Trajectory:
    """Design a trajectory of Eq. 41 that excites all parameters.

    The same seed and number of starts give the same trajectory on the same machine; a
    budget of seconds does not. An interrupt ends the search and keeps the best so far.

    Args:
        robot: with limits of its joints; its inertia is nominal.
        duration: t_f, s.
        harmonics: N_f.
        objective: `"cond"` for the condition number of `Y-hat`; `"d"`, `"a"` or `"e"`
            for the information of all parameters under the robot file's sensors.
        starts: so many random starts; 24 by default.
        budget: instead of `starts`, seconds of search.
        uncertainty: relative, of the bodies' masses and sizes; the worst of several
            plausible robots counts.
        seed: of the random starts.
        conditions: instead of duration and harmonics.
        progress: is called after each start.

    Returns:
        The best one found; `design` holds its scores and the extremes that it is
        proven to keep for all times, with nominal inertia.

    Raises:
        InputError: no motion keeps to the limits, or an argument makes no sense.
    """
    _check(objective, starts, budget, uncertainty)
    given = conditions or conditions_for(robot, duration, harmonics)
    names = robot.joint_names
    check_ends(names, given.limits, given.start, given.end)
    motions = motions_for(robot, given, objective)
    polytope = polytope_of(motions, given.limits)
    middle = inner_point(polytope, given.limits, names)
    problem = problem_for(robot, given, motions, objective, uncertainty)
    effort = Effort(starts or STARTS, budget)
    searched = search(problem, polytope, middle, effort, seed, progress)
    proven = proven_within(robot, given, motions, middle, searched.y)
    scores = scores_of(robot, proven.trajectory, proven.motion, given.basis)
    made = {
        "objective": objective,
        "value": _value(scores, objective),
        "uncertainty": uncertainty,
        "seed": seed,
        **_effort(searched),
        "scores": _scores(scores),
        **_margins(robot, given, proven),
    }
    return replace(proven.trajectory, design=made)


def _value(scores: Scores, objective: Objective) -> float | None:
    return scores.cond_Y if objective == "cond" else getattr(scores, objective)


def _effort(searched: Searched) -> dict[str, Any]:
    return {
        "starts": len(searched.values),
        "evaluations": searched.evaluations,
        "median_random_start": float(np.exp(np.median(searched.first_values))),
    }


def _scores(scores: Scores) -> dict[str, Any]:
    found = scores._asdict()
    del found["deviations"]
    return found


def _margins(robot: Robot, given: Conditions, proven: Proven) -> dict[str, Any]:
    """The extremes for all times beside their limits; None where there is none."""
    limits, joints, base = given.limits, proven.joints, proven.base
    entries = {}
    for k, name in enumerate(robot.joint_names):
        entries[name] = {
            "position": joints.position[k].tolist(),
            "position_limit": [_finite(x) for x in limits.position[k]],
            "velocity": float(joints.velocity[k]),
            "velocity_limit": _finite(limits.velocity[k]),
            "acceleration": float(joints.acceleration[k]),
            "acceleration_limit": _finite(limits.acceleration[k]),
        }
    of_base = {}
    for name in ("rate", "excursion", "wheel_speed"):
        limit = limits.base_rate if name == "rate" else getattr(limits, name)
        of_base[name] = _finite(getattr(base, name))
        of_base[f"{name}_limit"] = _finite(limit)
    return {"amplitude_kept": proven.share, "proven": {"joints": entries, **of_base}}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _check(
    objective: str, starts: int | None, budget: float | None, uncertainty: float
) -> None:
    if objective not in OBJECTIVES:
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
