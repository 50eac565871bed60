"""Descents: inside the limits, with exact gradients, ended when time is up."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.excitation.conditions import conditions_for, limits_of
from orbident.excitation.design_problem import DesignProblem, problem_for
from orbident.excitation.joint_limits import inner_point, polytope_of
from orbident.excitation.search import (
    OUTSIDE,
    Effort,
    Feasible,
    JointSearch,
    Searched,
    SearchSpace,
)


@pytest.fixture(scope="module")
def given(emulator):
    limits = limits_of(emulator, base_rate=2.42)
    return replace(conditions_for(emulator, 20.0, 2), limits=limits)


@pytest.fixture(scope="module")
def case(emulator, given):
    problem = problem_for(emulator, given, "cond", 0.0)
    polytope = polytope_of(problem.motions.resampled(65), given.limits)
    middle = inner_point(polytope, given.limits, dict(enumerate(emulator.joint_names)))
    return SearchSpace(problem, (polytope, polytope, polytope), middle)


def run(case, effort, seed=0, report=lambda _: None) -> Searched:
    return JointSearch(effort, report, [case], seed).run()


@pytest.mark.slow
def test_descends_inside_the_limits(case):
    problem, (polytope, _, _), _ = case
    searched = run(case, Effort(3, None))
    assert searched.starts == len(searched.random) == 3
    best = searched.optima[0]
    assert best.value < min(found.value for found in searched.random)
    for found in (*searched.optima, *searched.random):
        candidate = problem.evaluate(found.y, 2.0)
        assert candidate.exact == found.value
        assert (candidate.used <= 1).all()
        assert polytope.slack(found.y).min() > -OUTSIDE


@pytest.mark.slow
def test_a_limit_of_the_base_costs(emulator, given, case):
    free = replace(given, limits=limits_of(emulator))
    problem = problem_for(emulator, free, "cond", 0.0)
    with_limit, without = (
        run(each, Effort(3, None)) for each in (case, case._replace(problem=problem))
    )
    assert without.optima[0].value < with_limit.optima[0].value


def test_stops_when_time_is_up(case):
    searched = run(case, Effort(3, 1e-6))
    assert searched.starts == 1
    assert len(searched.optima) == 1
    # The random motion alone, made smaller for the base's limit: there is no step.
    assert searched.optima[0].value == searched.random[0].value


def test_an_interrupt_keeps_what_was_found(case):
    def interrupted(progress):
        raise KeyboardInterrupt

    searched = run(case, Effort(5, None), report=interrupted)
    assert searched.interrupted
    assert searched.starts == 1
    assert searched.optima


def test_an_interrupt_in_a_descent_keeps_the_random_motion(case, monkeypatch):
    calls = []
    evaluate = DesignProblem.evaluate

    def interrupted(self, y, p):
        calls.append(p)
        if len(calls) > 3:
            raise KeyboardInterrupt
        return evaluate(self, y, p)

    monkeypatch.setattr(DesignProblem, "evaluate", interrupted)
    searched = run(case, Effort(5, None))
    assert searched.interrupted
    assert len(searched.random) == 1
    assert searched.optima[0].value <= searched.random[0].value


def test_of_optima_that_are_alike_the_better_is_kept(case):
    searched, y = Searched(), np.zeros((1, 1))
    for value in (2.0, 1.0, 1.0005, 0.9995):
        searched.keep(Feasible(case, value, y))
    assert [found.value for found in searched.optima] == [0.9995, 2.0]
