"""What a result says of itself in a notebook."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import REFUSED, exact_result, made_result, without

from orbident.errors import InputError
from orbident.estimation.quantities import (
    MOST,
    EstimatedSet,
    most_different,
    short_table,
)
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.robot_file import load_robot


def far_from_cad(name: str):
    """A result whose k-th parameter is k sigmas off, below and above in turns."""
    robot = load_robot(name)
    beta = minimal_sets(robot).beta(robot.theta)
    off = np.arange(beta.size) * (-1.0) ** np.arange(beta.size)
    return made_result(robot, beta + 0.1 * off, 0.01 * np.eye(beta.size))


def test_those_that_differ_most_come_first():
    base = far_from_cad("paper-spatial").base
    last = len(base.names) - 1
    assert list(most_different(base, 4)) == [0, last, last - 1, last - 2]
    # The mass is shown wherever it is.
    assert list(most_different(base, 100)) == list(range(last + 1))


def test_the_rest_is_counted():
    """Nine of 18 parameters have a line, the mass among them; the rest is counted."""
    found = far_from_cad("paper-spatial")
    *_, words = short_table(without(found, "iota_12", "sigma_1").base)
    assert MOST == 9
    assert words == "  7 more are within 8 sigmas of CAD, 2 more are not determined"


def test_repr_is_one_screen_for_any_robot():
    for name in ("paper-spatial", "cepheus-like", "dual-arm"):
        lines = repr(far_from_cad(name)).splitlines()
        assert len(lines) < 24
        assert max(map(len, lines)) <= 80
        assert lines[0].startswith(f"{name}: trusted, 1601 samples")
        assert lines[-1].startswith("more: result.base")


def test_repr_of_a_refused_result_is_its_reason():
    result = replace(exact_result(load_robot("cepheus-like")), checks=(REFUSED,))
    head, reason, more = repr(result).splitlines()
    assert head.startswith("cepheus-like: refused")
    assert reason == REFUSED.words
    assert "diagnostics" in more


def test_one_parameter_by_its_name():
    result = exact_result(load_robot("paper-spatial"), size=1e-4)
    k = result.base.names.index("sigma_1")
    assert result.base["sigma_1"].value == result.base.values[k]
    assert result.base["sigma_1"].std == result.base.std[k]
    assert result["sigma_1"] == result.base["sigma_1"]
    with pytest.raises(InputError, match=r"no parameter 'sigma1'.*sigma_1"):
        result.base["sigma1"]
    assert repr(result.mass) == f"{result['M']} kg"
    assert repr(result.nothing().mass) == "not determined"


def test_one_parameter_by_its_number():
    """As of an array: from 0, and from behind."""
    base = exact_result(load_robot("paper-spatial"), size=1e-4).base
    assert base[3] == base[base.names[3]]
    assert base[-1] == base[base.names[-1]]
    for wrong in (18, -19):
        with pytest.raises(InputError, match=r"no parameter .*; known names: 'M'"):
            base[wrong]


def test_differences_from_zero_and_without_deviation():
    found = EstimatedSet(
        names=("M", "sigma_1", "iota_1"),
        formulas=("m", "mx", "Ixx"),
        values=np.array([11.0, 0.5, 2.0]),
        std=np.array([0.5, 0.25, 0.0]),
        nominal=np.array([10.0, 0.0, 2.0]),
    )
    assert found.units == ("kg", "kg m", "kg m^2")
    assert found.sigmas == pytest.approx([2.0, 2.0, np.nan], nan_ok=True)
    assert found.percent == pytest.approx([10.0, np.nan, 0.0], nan_ok=True)
