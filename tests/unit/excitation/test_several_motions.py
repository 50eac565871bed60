"""Motions of several recordings: designed together, and as good as they say."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.excitation.conditions import conditions_for
from orbident.excitation.design import design_recordings
from orbident.excitation.scores import compare_trajectories
from orbident.simulation.simulate import simulate
from orbident.studies.spatial import paper_case


@pytest.fixture(scope="module")
def pair(emulator):
    given = conditions_for(emulator, 10.0, 3)
    return list(design_recordings(emulator, 2, given, starts=4))


def test_the_same_motion_twice_halves_variances(emulator):
    one = paper_case(emulator).trajectory
    found = compare_trajectories(emulator, [[one], [one, one]])
    np.testing.assert_allclose(
        found.deviations[1], found.deviations[0] / np.sqrt(2), rtol=1e-6
    )
    alone, twice = found.scores
    assert twice.cond_Y == pytest.approx(alone.cond_Y, rel=1e-9)
    assert found.sources == ("Table 5", "Table 5 to Table 5")


def test_the_second_is_made_for_what_the_first_does_not_tell(emulator, pair):
    first, second = pair
    assert [each.design["recordings"] for each in pair] == [2, 2]
    found = compare_trajectories(emulator, [[first], [first, first], pair])
    alone, twice, together = (score.d or np.inf for score in found.scores)
    assert first.design["value"] == pytest.approx(alone, rel=1e-9)
    assert second.design["value"] == pytest.approx(together, rel=1e-9)
    assert together < 0.9 * twice < 0.9 * alone
    # What the search valued is what the true motions give.
    searched = second.design["searched_value"]
    assert searched == pytest.approx(together, rel=0.02)


def test_identified_as_well_as_they_promise(emulator, pair):
    (promised,) = compare_trajectories(emulator, [pair]).deviations
    recordings = [
        simulate(emulator, each, noise="sensors", seed=seed)
        for seed, each in enumerate(pair)
    ]
    result = identify(emulator, recordings, initial_momentum="at-rest")
    found = result.pi.std
    ratio = found / promised[1 : 1 + found.size]
    assert ratio == pytest.approx(np.ones(found.size), abs=0.2)


def test_condition_numbers_do_not_add_up(emulator):
    given = conditions_for(emulator, 10.0, 3)
    with pytest.raises(InputError, match="several recordings: condition numbers"):
        next(design_recordings(emulator, 2, given, objective="cond"))
