"""A long step keeps what a motion shows of thrust: ratios to the mass."""

import numpy as np
import pytest

from orbident.estimation.output_error.recorded_thrust import (
    SCALE,
    SHARED,
    EvenSteps,
)
from orbident.estimation.solution import NOTHING_SELECTED, OUTSIDE, Unknowns
from orbident.preprocessing.wrenches import RecordedWrench

FIRST = 40
"""The place of the clock."""

NOTHING = np.zeros((1, 3))

VALVES = [
    RecordedWrench(f"thruster.t{k}", 0.2, NOTHING, NOTHING, NOTHING, True)
    for k in range(3)
]


TORQUES = FIRST + SHARED + np.array([3.0, 4.0])
"""Places of what gives momentum; behind them is an acceleration."""


def state(random: np.random.Generator, places: np.ndarray) -> Unknowns:
    """Four base parameters, all of one size."""
    common = np.concatenate(
        [
            random.standard_normal(OUTSIDE),
            random.uniform(1, 2, 4),
            0.3 * random.standard_normal(places.size),
        ]
    )
    return Unknowns(np.zeros((0, 4)), np.zeros((0, 9)), common, places)


def ratios(at: Unknowns) -> np.ndarray:
    """Momentum, first moments, inertias, thrusts, torques and one over the mass."""
    own = dict(zip(at.selected - FIRST, at.calibration, strict=True))
    torques = [own[SHARED + k] for k in (3, 4)]
    valves = [k for k in range(3) if SHARED + k in own]
    thrusts = [(1 + own[SCALE]) * (1 + own[SHARED + k]) for k in valves]
    return (
        np.concatenate([at.common[:3], at.beta[1:], thrusts, torques, [1.0]])
        / at.beta[0]
    )


def with_thrust(random: np.random.Generator, scale_known: bool) -> Unknowns:
    """With all that thrust shares; or, where it is known, with its clock alone."""
    at = state(random, FIRST + np.arange(-1.0, SHARED + 6))
    return at.carried(np.array([FIRST, *TORQUES])) if scale_known else at


def stepped(at: Unknowns, g: np.ndarray) -> Unknowns:
    g = EvenSteps(at, FIRST, VALVES, TORQUES).changed(g)
    return at.moved(np.zeros((0, 9)), g)


@pytest.mark.parametrize("scale_known", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_ratios_change_by_their_slope(seed, scale_known):
    random = np.random.default_rng(seed)
    at = with_thrust(random, scale_known)
    g = 0.1 * random.standard_normal(at.common.size)
    tiny, whole = stepped(at, 1e-6 * g), stepped(at, g)
    slope = 1e6 * (ratios(tiny) - ratios(at))
    # A difference of numbers of size one, over a millionth of the step.
    np.testing.assert_allclose(ratios(whole) - ratios(at), slope, atol=1e-8)
    np.testing.assert_allclose(tiny.common, at.common + 1e-6 * g, atol=1e-11)
    if not scale_known:
        assert whole.common[-1] == at.common[-1] + g[-1]


@pytest.mark.parametrize("scale_known", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_what_is_linear_in_the_unknowns_bends(seed, scale_known):
    """Beside second differences along a step."""
    random = np.random.default_rng(seed)
    at = with_thrust(random, scale_known)
    slope, g = random.standard_normal((2, at.common.size))
    h = 1e-4
    ends = [slope @ stepped(at, by * g).common for by in (-h, 0.0, h)]
    bend = g @ EvenSteps(at, FIRST, VALVES, TORQUES).bends(slope) @ g
    assert bend == pytest.approx((ends[0] - 2 * ends[1] + ends[2]) / h**2, rel=1e-4)


def test_where_the_scale_is_no_unknown_a_step_is_as_it_is():
    random = np.random.default_rng(1)
    at = state(random, FIRST + np.array([0.0, SHARED, SHARED + 1, SHARED + 2]))
    g = random.standard_normal(at.common.size)
    np.testing.assert_array_equal(
        EvenSteps(at, FIRST, VALVES, NOTHING_SELECTED).changed(g), g
    )
