"""What passive joints were found to be: made up."""

import pytest

from orbident.estimation.levels import ChiSquare
from orbident.estimation.output_error.joint_laws import what_swings
from orbident.estimation.unknowns import SpringFit
from orbident.robot.description import Passive

AS_KNOWN = ChiSquare(2.0, 2)


def panels(left: float, right: float, like: str = "") -> dict[str, Passive]:
    return {"left": Passive(left), "right": Passive(right, like=like)}


def springs(left: float, right: float, std: float = 1e-3) -> dict[str, SpringFit]:
    fits = (SpringFit(f, std, 0.01, 1e-3) for f in (left, right))
    return dict(zip(("left", "right"), fits, strict=True))


def test_two_that_differ():
    assert not [*what_swings(panels(0.3, 1.0), springs(0.31, 0.97), AS_KNOWN, {})]


@pytest.mark.parametrize(("found", "std"), [((1.0, 1.05), 1e-3), ((0.9, 1.058), 1e-2)])
def test_two_that_may_swing_alike(found, std):
    """The second are equal panels as they were found, sixteen per cent apart."""
    (check,) = what_swings(panels(1.1, 0.9), springs(*found, std=std), AS_KNOWN, {})
    assert check.level == "do not trust"
    assert "joints 'left' and 'right' swing alike, or may" in check.reason
    assert "right: {like: left}" in check.remedy


def test_two_of_one_make():
    assert not [
        *what_swings(panels(1.0, 1.0, "left"), springs(1.0, 1.01), AS_KNOWN, {})
    ]


def test_two_that_two_motors_turn():
    alike = panels(3.0, 3.0), springs(3.0, 3.01), AS_KNOWN
    assert not [*what_swings(*alike, {"left": "shoulder", "right": "elbow"})]
    for turned in ({"left": "elbow"}, {"left": "elbow", "right": "elbow"}):
        assert [*what_swings(*alike, turned)]


def test_what_they_carry_is_something_else():
    far = ChiSquare(7.0**2, 2)
    (check,) = what_swings(panels(0.3, 1.0), springs(0.3, 1.0), far, {})
    assert "not what their nominal inertias say: by 7 of the deviations" in check.reason
    assert "passive: JOINT: inertia" in check.remedy


def test_what_is_stiff_swings_nowhere_near():
    """Five deviations of 20 % are a factor of 2.7."""
    stiff = springs(0.3, 2.9)
    (check,) = what_swings(panels(0.3, 1.0), stiff, AS_KNOWN, {})
    assert check.level == "do not trust"
    assert "joint 'right' swings at 2.9 Hz or does not bend at all" in check.reason
    assert "neither 'passive' nor 'flexible'" in check.remedy
    assert not [*what_swings(panels(0.3, 1.0), springs(0.3, 2.5), AS_KNOWN, {})]
    sure = {"left": Passive(0.3), "right": Passive(1.0, tolerance=0.0)}
    assert not [*what_swings(sure, springs(0.3, 1.0), AS_KNOWN, {})]
