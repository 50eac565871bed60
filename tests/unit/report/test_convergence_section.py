"""How the search converged, in the report."""

import numpy as np

from orbident.estimation.solution import Step
from orbident.report.convergence_section import convergence
from orbident.report.page import embedded

ONE_ROUND = (Step(1e6, np.nan), Step(90.0, 2.0), Step(80.0, 4e-3))
TWO_ROUNDS = (*ONE_ROUND, Step(70.0, np.nan, 2), Step(69.0, 5e-4, 2))


def points(trace: dict, axis: str) -> list[float]:
    return trace[axis].tolist()


def test_one_round():
    section = convergence(ONE_ROUND)
    assert section is not None
    (words,) = section.words
    assert "took 2 steps" in words
    assert "more than 0.004 of its standard deviation" in words
    cost, size = (chart.figure for chart in section.charts)
    (curve,) = cost["data"]
    assert points(curve, "x") == [0, 1, 2]
    assert points(curve, "y") == [1e6, 90, 80]
    limit, curve = size["data"]
    assert points(limit, "y") == [0.01] * 2
    assert points(curve, "y")[1:] == [2, 4e-3]
    assert cost["layout"]["yaxis"]["type"] == "log"
    assert cost["layout"]["xaxis"]["title"]["text"] == "step"


def test_a_round_starts_where_the_one_before_ended():
    section = convergence(TWO_ROUNDS)
    assert section is not None
    assert "The 2 curves are rounds" in section.words[1]
    first, second = section.charts[0].figure["data"]
    assert points(first, "x") == [0, 1, 2]
    assert points(second, "x") == [2, 3]
    assert embedded(section.charts[1].figure)


def test_costs_that_are_near_each_other_have_a_linear_axis():
    section = convergence((Step(11.0, 0.3), Step(10.0, 1e-3)))
    assert section is not None
    assert "type" not in section.charts[0].figure["layout"]["yaxis"]
    assert points(section.charts[0].figure["data"][0], "x") == [1, 2]


def test_a_method_without_a_search_has_none():
    assert convergence(()) is None
