import math

import pytest

from orbident.errors import InputError
from orbident.robot.units import UNITS, quantity


@pytest.mark.parametrize(
    ("given", "dimension", "si"),
    [
        ("180 deg", "angle", math.pi),
        ("2.5e-5 rad", "angle", 2.5e-5),
        ("1 arcsec", "angle", math.pi / 648000),
        ("1e-4 m", "length", 1e-4),
        ("0.1mm", "length", 1e-4),
        ("20 Hz", "frequency", 20.0),
        ("3600 deg/h", "angular rate", math.pi / 180),
        ("60 deg/sqrt(h)", "angle random walk", math.pi / 180),
        ("1 rad/sqrt(s)", "angle random walk", 1.0),
        ("0.06 m/s/sqrt(h)", "velocity random walk", 0.001),
        ("10 ug", "acceleration", 9.80665e-5),
        ("1 m/s^2", "acceleration", 1.0),
        (3, "angle", 3.0),
        (0.5, "length", 0.5),
        ("1e-4", "length", 1e-4),
    ],
)
def test_quantities_in_si(given, dimension, si):
    assert quantity(given, dimension) == pytest.approx(si, rel=1e-15)


def test_an_unknown_unit_lists_the_accepted_ones():
    with pytest.raises(
        InputError, match=r"unknown unit 'furlong' of a length; .*m, cm"
    ):
        quantity("1 furlong", "length")
    with pytest.raises(InputError, match=r"unknown unit 'deg/s' of an angle; .*arcsec"):
        quantity("1 deg/s", "angle")


@pytest.mark.parametrize("given", ["", "deg", "nan deg", True, None, [1], math.inf])
def test_what_is_no_quantity_is_refused(given):
    with pytest.raises(InputError, match="give a finite number"):
        quantity(given, "angle")


def test_the_first_unit_of_each_dimension_is_si():
    assert {next(iter(units.values())) for units in UNITS.values()} == {1.0}
