"""How large what acts from outside may be, as a robot file writes it."""

import math

import pytest

from orbident.choices import DisturbanceGroup
from orbident.errors import InputError
from orbident.robot.may_act import DIMENSIONS, MayAct, may_act
from orbident.robot.units import STANDARD_GRAVITY, UNITS

FREE = MayAct(math.inf)


def test_what_is_not_said_is_none(load_yaml):
    assert load_yaml().disturbances is None
    assert load_yaml("disturbances: []").disturbances == {}
    assert may_act({}) == {}


def test_a_list_is_free(load_yaml):
    found = load_yaml("disturbances: [slow_torque, torque_walk]").disturbances
    assert found == {"slow_torque": FREE, "torque_walk": FREE}


def test_every_size_in_its_unit(load_yaml):
    found = load_yaml(
        """
disturbances:
  torque: 3 mN m
  slow_torque: {size: 2 mN m, shortest: 10 s}
  slow_base_torque: {size: free, shortest: 1 min}
  wheel_loss: 0.001
  pull: 100 urad
  uneven: 50 urad/m
  drag: 10 mN s/m
  air: 2 mN
  sunlight: free
  dipole: 5 A m^2
  force_walk: free
"""
    ).disturbances
    assert found == {
        "torque": MayAct(3e-3),
        "slow_torque": MayAct(2e-3, 10.0),
        "slow_base_torque": MayAct(math.inf, 60.0),
        "wheel_loss": MayAct(1e-3),
        "pull": MayAct(100e-6 * STANDARD_GRAVITY),
        "uneven": MayAct(50e-6 * STANDARD_GRAVITY),
        "drag": MayAct(0.01),
        "air": MayAct(2e-3),
        "sunlight": FREE,
        "dipole": MayAct(5.0),
        "force_walk": FREE,
    }


def test_a_pull_is_an_acceleration_or_a_slope():
    assert may_act({"pull": "1 mm/s^2"}) == {"pull": MayAct(1e-3)}
    assert may_act({"pull": "1 ug"}) == may_act({"pull": "1 urad"})


def test_zero_is_a_size():
    assert may_act({"pull": 0}) == {"pull": MayAct(0.0)}


def test_every_group_has_a_size_or_a_density():
    others = {name for name in DisturbanceGroup if name.endswith("_walk")}
    others |= {DisturbanceGroup.on_springs}
    assert {*DIMENSIONS} == {*DisturbanceGroup} - others
    assert {*DIMENSIONS.values()} <= {*UNITS}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("{torque: -1 mN m}", "found {'torque': '-1 mN m'}; torque: give zero or more"),
        ("{torque: 1 mN}", "torque: unknown unit 'mN' of a torque; accepted: Nm, mNm"),
        ("{pull: 1 mN}", "pull: unknown unit 'mN' of an acceleration or slope; accep"),
        ("{drag: 1 urad}", "drag: unknown unit 'urad' of a drag; accepted: Ns/m"),
        ("{torque: large}", "torque: give a finite number, with or without a unit"),
        ("{torque: .nan}", "torque: give a finite number"),
        ("{torque: }", "torque: give a finite number"),
        ("{slow_torque: {shortest: 3 s}}", "slow_torque: give a size, or size and"),
        ("{slow_torque: {size: 1, longest: 3 s}}", "slow_torque: give a size, or size"),
        ("{slow_torque: {size: 1, shortest: -3 s}}", "slow_torque: give zero or more"),
        ("{slow_torque: {size: 1, shortest: 3 m}}", "unknown unit 'm' of a time"),
        ("{torque_walk: 1 mN m}", "torque_walk: give 'free', or its density under mom"),
        ("{wind: 1 mN m}", "'wind' is unknown; known names: 'torque', 'slow_torque', "),
        ("[slow_torqe]", "'slow_torqe' is unknown; did you mean 'slow_torque'"),
        ("[[pull]]", r"\['pull'\] is unknown; did you mean 'pull'"),
        ("{1: 2}", "1 is unknown; known names: 'torque'"),
        ("5", r"found 5; give a list of what acts, such as \[pull, drag\], or sizes"),
        ("free", "found 'free'; give a list of what acts"),
    ],
)  # fmt: skip
def test_what_is_no_size_is_refused_in_one_line(load_yaml, given, message):
    with pytest.raises(InputError, match=message) as error:
        load_yaml(f"disturbances: {given}")
    assert str(error.value).count("servicer.yaml:3: disturbances") == 1
    assert "\n" not in str(error.value)
