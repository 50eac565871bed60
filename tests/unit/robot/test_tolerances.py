import math
from dataclasses import make_dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from urdf_texts import ARM

from orbident.errors import InputError
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.tolerances import (
    CALIBRATION_KINDS,
    CalibrationKind,
    Tolerances,
)

SLIDING = ARM.replace('type="continuous"', 'type="prismatic"').replace(
    'type="revolute"', 'type="prismatic"'
)


def of_drives(robot: Robot) -> dict[str, Any]:
    """Friction and rotors of which nothing is said: they may be anything."""
    anything = dict.fromkeys(robot.joint_names, math.inf)
    kinds = ("armature", "viscous", "coulomb", "torque_offset")
    return {f"joint_{kind}": anything for kind in kinds}


def test_every_instrument_is_exact_if_the_file_says_so(load_yaml):
    robot = load_yaml("tolerances: exact")
    exact = dict.fromkeys(robot.joint_names, 0.0)
    assert robot.tolerances == Tolerances(
        exact,
        exact,
        joint_place=exact,
        joint_direction=exact,
        joint_torque_scale=exact,
        **of_drives(robot),
    )


def test_friction_that_was_measured_has_its_tolerance(load_yaml):
    robot = load_yaml(
        """
friction:
  joint1: {viscous: 0.5 N m s, coulomb: 20 mN m, offset: -10 mN m, tolerance: 10 %}
rotors: none
"""
    )
    (name, *others), known = robot.joint_names, robot.tolerances
    assert robot.friction[name][:3] == (0.5, 0.02, -0.01)
    stds = known.joint_viscous, known.joint_coulomb, known.joint_torque_offset
    assert [each[name] for each in stds] == pytest.approx([0.05, 0.002, 0.001])
    assert {each[x] for each in stds for x in others} == {math.inf}
    assert {*known.joint_armature.values()} == {0.0}


def test_torque_constants_are_known_less_well_than_sensors(load_yaml):
    constants = "torque_constants: {joint1: 2.1 N m/A, joint2: 300 mN m/A}"
    robot = load_yaml(constants)
    first, second, *others = robot.joint_names
    assert robot.torque_constants == {first: 2.1, second: pytest.approx(0.3)}
    stds = robot.tolerances.joint_torque_scale
    assert (stds[first], stds[second]) == (0.05, 0.05)
    assert {stds[name] for name in others} <= {0.01}
    measured = "tolerances: {joints: {joint1: {torque_scale: 2 %}}}"
    stds = load_yaml(f"{constants}\n{measured}").tolerances.joint_torque_scale
    assert (stds[first], stds[second]) == (0.02, 0.05)
    exact = load_yaml(f"{constants}\ntolerances: exact").tolerances
    assert {*exact.joint_torque_scale.values()} == {0.0}


def test_a_motor_that_slides_has_newtons_for_an_ampere(load_yaml):
    robot = load_yaml("torque_constants: {joint1: 50 N/A}", SLIDING)
    assert robot.torque_constants == {"joint1": 50.0}


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("friction: {knee: {viscous: 1}}", "friction: no joint 'knee'"),
        ("friction: {joint1: {dry: 1}}", "unknown key 'dry'"),
        ("friction: {joint1: {viscous: -1}}", "give zero or more"),
        ("friction: {joint1: {coulomb: 1 kg}}", "unknown unit 'kg'"),
        (
            "friction: {joint1: {viscous: 1}}\npassive: {joint1: {frequency: 1}}",
            "friction.joint1: the joint is passive",
        ),
        ("sensors: {torques: {}}", "std"),
        ("torque_constants: {knee: 1}", "torque_constants: no joint 'knee'"),
        ("torque_constants: {joint1: 0}", "give a torque constant above zero"),
        ("torque_constants: {joint1: -2 N m/A}", "negate currents of the other"),
        ("torque_constants: {joint1: 2 N m}", "unknown unit 'Nm' of a torque con"),
        ("torque_constants: {joint1: 1e13 N m/A}", "give at most"),
        ("torque_constants: {joint1: .nan}", "give a finite number"),
        ("torque_constants: 2", "torque_constants: found 2"),
        (
            "torque_constants: {joint1: 1}\npassive: {joint1: {frequency: 1}}",
            "torque_constants.joint1: the joint is passive",
        ),
        (
            "rotors: {joint1: {gear: 9, inertia: 1e-4}}\n"
            "passive: {joint1: {frequency: 1}}",
            "rotors.joint1: the joint is passive",
        ),
    ],
)
def test_what_is_no_motor_or_friction_is_refused(load_yaml, section, message):
    with pytest.raises(InputError, match=message) as error:
        load_yaml(section)
    assert "\n" not in str(error.value)


def test_without_tolerances_instruments_are_as_usual(load_yaml):
    robot = load_yaml()
    joints = robot.joint_names
    exact = dict.fromkeys(joints, 0.0)
    assert robot.tolerances == Tolerances(
        joint_zero=dict.fromkeys(joints, 1e-3),
        joint_scale=dict.fromkeys(joints, 1e-4),
        wheel_inertia=2e-3,
        wheel_axis=math.radians(0.1),
        gyro_misalignment=1e-3,
        gyro_scale=5e-4,
        joint_clock=1e-3,
        attitude_clock=1e-3,
        position_clock=1e-3,
        joint_place=exact,
        joint_direction=exact,
        joint_torque_scale=dict.fromkeys(joints, 0.01),
        **of_drives(robot),
        thruster_clock=0.1,
        thruster_pulse=0.02,
        thruster_coupling=0.05,
    )


def test_what_is_absent_is_as_usual(load_yaml):
    found = load_yaml("tolerances: {wheels: {inertia: 0}}").tolerances
    assert (found.wheel_inertia, found.gyro_scale) == (0.0, 5e-4)


def test_every_tolerance_in_its_unit(load_yaml):
    found = load_yaml(
        """
tolerances:
  joints: {zero: 5 mrad, scale: 0.5 %, place: 1 mm, direction: 1 mrad}
  feature_point: 2 mm
  wheels: {inertia: 1 %}
  attitude: {misalignment: 0.5 deg}
  gyro: {misalignment: 0.25 deg, scale: 300 ppm}
  position: {scale: 0.01}
  clocks: {joints: 5 ms, attitude: 0.002, position: 1000 us}
"""
    ).tolerances
    assert set(found.joint_zero.values()) == {5e-3}
    assert set(found.joint_scale.values()) == {5e-3}
    assert set(found.joint_place.values()) == {1e-3}
    assert set(found.joint_direction.values()) == {1e-3}
    assert found.feature_point == 2e-3
    assert found.wheel_inertia == 1e-2
    assert found.attitude_misalignment == pytest.approx(math.radians(0.5))
    assert found.gyro_misalignment == pytest.approx(math.radians(0.25))
    assert found.gyro_scale == pytest.approx(3e-4)
    assert found.position_scale == 0.01
    assert found.joint_clock == 5e-3
    assert found.attitude_clock == 2e-3
    assert found.position_clock == pytest.approx(1e-3)


def test_joints_by_name(load_yaml):
    robot = load_yaml()
    first, *others = robot.joint_names
    found = load_yaml(f"tolerances: {{joints: {{{first}: {{zero: 3 mrad}}}}}}")
    zeros = found.tolerances.joint_zero
    assert zeros[first] == 3e-3
    assert {zeros[name] for name in others} == {1e-3}


def test_the_zero_of_a_joint_that_slides_is_a_length(load_yaml):
    lines = "tolerances: {joints: {zero: 2 mm}}"
    assert set(load_yaml(lines, SLIDING).tolerances.joint_zero.values()) == {2e-3}
    with pytest.raises(InputError, match=r"found '2 mm'; unknown unit 'mm' of an ang"):
        load_yaml(lines)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("joints: {elbw: {zero: 1 mrad}}", r"tolerances\.joints: no joint 'elbw'"),
        ("joints: {zero: 5 kg}", "unknown unit 'kg' of an angle or length"),
        ("joints: {offset: 1 mrad}", "unknown key 'offset'"),
        ("joints: 5 mrad", "found '5 mrad'"),
        ("feature_point: [1, 2, 3]", r"tolerances\.feature_point: found"),
        ("feature_point: 2 mrad", "unknown unit 'mrad' of a length"),
        ("wheels: {inertia: -1 %}", "found '-1 %'; give zero or more"),
        (
            "wheels: {inertia: 1 mm}",
            "unknown unit 'mm' of a share; accepted: 1, %, ppm",
        ),
        ("position: {misalignment: 1 deg}", "unknown key 'misalignment'"),
        ("camera: {scale: 1 %}", "unknown key 'camera'"),
        ("clocks: {joints: 5 mm}", "unknown unit 'mm' of a time"),
        ("clocks: {attitude: -2 ms}", "found '-2 ms'; give zero or more"),
        ("clocks: {gyro: 2 ms}", "unknown key 'gyro'"),
        ("clocks: 2 ms", r"tolerances\.clocks: found '2 ms'"),
    ],
)
def test_what_is_no_tolerance_is_refused_in_one_line(load_yaml, section, message):
    with pytest.raises(InputError, match=message) as error:
        load_yaml(f"tolerances: {{{section}}}")
    assert "\n" not in str(error.value)


def test_the_kinds_are_those_of_the_unknowns_in_their_order():
    robot = load_robot("paper-spatial")
    owners = {"joint": robot.joint_names, "wheel": robot.wheel_names}
    names = [
        name
        for kind in CALIBRATION_KINDS.values()
        for of in owners.get(kind.name.partition(".{}")[0], ("",))
        for name in kind.names(of)
    ]
    unknowns = calibrations_of(robot, {"gyro", "attitude", "position"})
    assert unknowns
    for each in unknowns:
        assert names[int(each.place)] == each.name


def test_a_new_kind_of_error_is_one_row(monkeypatch):
    """Its equations are the core's; its unknowns follow from the row."""
    robot = load_robot("paper-spatial")
    kind = CalibrationKind("wheel.{}.place", "wheels.place", "angle", by_axis=True)
    monkeypatch.setitem(CALIBRATION_KINDS, "wheel_place", kind)
    more = make_dataclass(
        "More", [("wheel_place", float, 2e-3)], bases=(Tolerances,), frozen=True
    )
    robot = replace(robot, tolerances=more(**vars(robot.tolerances)))
    every = calibrations_of(robot, {"gyro"}, {"wheel.rw_x.place": 1e-2})
    new = {
        x.name: x for x in every if x.name.startswith("wheel.") and ".place" in x.name
    }
    assert list(new)[:3] == [f"wheel.rw_x.place.{axis}" for axis in "xyz"]
    assert {each.unit for each in new.values()} == {"rad"}
    assert new["wheel.rw_x.place.y"].std == 1e-2
    assert new["wheel.rw_z.place.y"].std == 2e-3


def test_every_kind_has_a_row_in_the_documentation():
    page = (Path(__file__).parents[3] / "docs/robot-file.md").read_text("utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    for kind in CALIBRATION_KINDS.values():
        section, _, key = kind.entry.partition(".")
        assert any(row.startswith(f"| `{section}") and key in row for row in rows)
