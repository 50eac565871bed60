"""Motions that are designed for what may act, beside those that know nothing of it.

The long ones are the numbers that decide:

    pytest -m long -s tests/unit/excitation/test_design_in_a_world.py
"""

from dataclasses import replace

import numpy as np
import pytest

from orbident.excitation.bound import bound_of
from orbident.excitation.conditions import conditions_for
from orbident.excitation.design import HARMONICS, design_excitation, harmonics_tried
from orbident.excitation.floating import was_at_rest
from orbident.excitation.guarantee import floated
from orbident.excitation.scores import scores_of
from orbident.studies.spatial import paper_case


def in_its_world(robot):
    """The same, of whose surroundings its file says nothing."""
    return replace(robot, disturbances=None)


def scored(robot, trajectory):
    """Its scores in that world, and the geometric mean of the bound's deviations."""
    there = in_its_world(robot)
    score = scores_of(there, [(trajectory, floated(there, trajectory))])
    at_rest = was_at_rest(robot, trajectory.initial, trajectory.start)
    bound = bound_of(there, trajectory, "at-rest" if at_rest else "unknown").parameters
    std = np.sqrt(np.diag(bound.base.covariance))
    return score, float(np.exp(np.log(std).mean()))


@pytest.mark.slow
def test_a_motion_that_knows_the_table(emulator):
    given = replace(paper_case(emulator).conditions, basis=None)
    blind = design_excitation(emulator, conditions=given, starts=1)
    aware = design_excitation(
        in_its_world(emulator), conditions=replace(given, harmonics=10), starts=1
    )
    (was, before), (now, after) = (scored(emulator, each) for each in (blind, aware))
    assert (was.price or 0) > 10
    assert (now.price or np.inf) < (was.price or 0) / 3
    assert after < before / 5
    made = aware.design
    assert made is not None
    assert made["harmonics"] == 10
    assert made["scores"]["price"] == pytest.approx(now.price)
    assert made["price_of_random_start"] > 1


@pytest.mark.slow
def test_the_search_chooses_harmonics_where_anything_may_act(emulator, servicer):
    given = conditions_for(emulator, 20.0)
    there = in_its_world(emulator)
    assert harmonics_tried(there, given, "d") == HARMONICS
    assert harmonics_tried(there, given, "cond") == (3,)
    assert harmonics_tried(emulator, given, "d") == (3,)
    assert harmonics_tried(there, replace(given, harmonics=5), "d") == (5,)
    found = design_excitation(there, 20.0, starts=1)
    assert found.a.shape[1] in HARMONICS


@pytest.mark.parametrize("name", ["emulator", "servicer"])
def test_the_bound_agrees(request, name):
    """Of motions nobody designed; encoders are the bound's alone."""
    robot = request.getfixturevalue(name)
    trajectory = paper_case(robot).trajectory
    score, _ = scored(robot, trajectory)
    alone = scores_of(robot, [(trajectory, floated(robot, trajectory))])
    assert (score.d or 0) > (alone.d or np.inf)
    assert alone.price is None
    there = in_its_world(robot)
    at_rest = was_at_rest(robot, trajectory.initial, trajectory.start)
    known = bound_of(there, trajectory, "at-rest" if at_rest else "unknown").parameters
    assert score.deviations is not None
    theirs = np.sqrt(
        np.concatenate(
            [np.diag(known.base.covariance)[:1], np.diag(known.pi.covariance)]
        )
    )
    ratio = score.deviations[: theirs.size] / theirs
    assert float(np.exp(np.log(ratio).mean())) == pytest.approx(1.0, abs=0.1)
    assert ratio == pytest.approx(np.ones(ratio.size), abs=0.25)


@pytest.mark.long
def test_the_numbers_that_decide_on_a_table(emulator, capsys):
    given = replace(paper_case(emulator).conditions, basis=None)
    today = design_excitation(emulator, conditions=given)
    free = replace(given, harmonics=None)
    made = design_excitation(in_its_world(emulator), conditions=free, budget=20.0)
    (was, before), (now, after) = (scored(emulator, each) for each in (today, made))
    with capsys.disabled():
        print(f"\ntable: price {was.price:.3g} -> {now.price:.3g}", end=", ")
        print(f"deviations {before:.3g} -> {after:.3g} (geometric mean)")
    assert (now.price or np.inf) <= 3.0
    assert after <= before / 5


@pytest.mark.long
def test_the_numbers_that_decide_in_space(servicer, capsys):
    given = replace(paper_case(servicer).conditions, basis=None, harmonics=None)
    made = design_excitation(in_its_world(servicer), conditions=given, budget=20.0)
    now, after = scored(servicer, made)
    with capsys.disabled():
        print(f"\nspace: price {now.price:.3g}, deviations {after:.3g}")
    assert (now.price or np.inf) <= 1.5
