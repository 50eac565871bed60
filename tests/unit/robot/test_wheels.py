import numpy as np
import pytest
from urdf_texts import joint, link, robot

from orbident.errors import InputError


def spacecraft(
    rotor: str, *more: str, kind: str = "continuous", parent: str = "base"
) -> str:
    return robot(
        link("base", 100.0, (10.0, 10.0, 10.0)),
        link("arm", 5.0),
        joint("shoulder", "base", "arm"),
        rotor,
        joint("rw", parent, "rotor", kind, xyz="0.2 0 0", rpy="0 0.5 0"),
        *more,
    )


BALANCED = link("rotor", 2.0, (0.03, 0.03, 0.05), com="0 0 0.1")


def test_a_declared_wheel_adds_nothing_to_the_base(load_yaml):
    without = load_yaml()
    robot = load_yaml("wheels: [{name: rw/x, axis: [2, 0, 0], inertia: 0.18}]")
    (wheel,) = robot.wheels
    assert robot.wheel_names == ("rw/x",)
    assert (wheel.inertia, wheel.mode) == (0.18, "held")
    np.testing.assert_array_equal(wheel.axis, [1, 0, 0])
    np.testing.assert_array_equal(robot.theta, without.theta)


def test_a_urdf_joint_becomes_a_wheel_counted_once(load_yaml):
    as_wheel = load_yaml("wheels: [{joint: rw, mode: free}]", spacecraft(BALANCED))
    as_fixed = load_yaml("", spacecraft(BALANCED, kind="fixed"))
    (wheel,) = as_wheel.wheels
    assert (wheel.name, wheel.mode) == ("rw", "free")
    assert wheel.inertia == pytest.approx(0.05, rel=1e-15)
    # Turned about y by 0.5 rad.
    np.testing.assert_allclose(wheel.axis, [np.sin(0.5), 0, np.cos(0.5)], atol=1e-15)
    assert as_wheel.joint_names == ("shoulder",)
    assert as_wheel.mass == 107.0
    np.testing.assert_array_equal(as_wheel.theta, as_fixed.theta)
    assert as_wheel.warnings == ()


def test_what_is_fixed_to_the_rotor_turns_with_it(load_yaml):
    ring = link("ring", 1.0, (0.01, 0.01, 0.02))
    text = spacecraft(BALANCED, ring, joint("f", "rotor", "ring", "fixed"))
    robot = load_yaml("wheels: [{name: main, joint: rw}]", text)
    assert robot.wheels[0].name == "main"
    assert robot.wheels[0].inertia == pytest.approx(0.07, rel=1e-14)


def test_an_unbalanced_rotor_is_warned_of(load_yaml):
    rotor = link("rotor", 2.0, (0.03, 0.03, 0.05), com="0.003 0 0")
    (warning,) = load_yaml("wheels: [{joint: rw}]", spacecraft(rotor)).warnings
    assert "rw" in warning
    assert "CM is 0.003 m off" in warning


def test_a_rotor_that_is_not_axisymmetric_is_warned_of(load_yaml):
    rotor = link("rotor", 2.0, (0.03, 0.04, 0.05))
    (warning,) = load_yaml("wheels: [{joint: rw}]", spacecraft(rotor)).warnings
    assert "not axisymmetric" in warning
    assert "0.005 of 0.05" in warning


@pytest.mark.parametrize(
    ("wheel", "text", "message"),
    [
        ("{joint: rww}", spacecraft(BALANCED), "joint: no joint 'rww'; did you mean"),
        ("{joint: rw}", spacecraft(BALANCED, kind="prismatic"), "rw' is prismatic"),
        ("{joint: rw}", spacecraft(BALANCED, parent="arm"), "'arm', which moves"),
        (
            "{joint: rw}",
            spacecraft(BALANCED, link("x"), joint("q", "rotor", "x")),
            "joint 'q' moves below the wheel's joint 'rw'",
        ),
        ("{joint: rw}", spacecraft(link("rotor", None)), "has inertia 0 kg m"),
        ("{joint: rw, axis: [1, 0, 0]}", spacecraft(BALANCED), "'joint' and 'axis'"),
        (
            "{joint: rw, inertia: 1}",
            spacecraft(BALANCED),
            "URDF gives the rotor on joint 'rw' 0.05",
        ),
        ("{joint: rw}, {name: b, joint: rw}", spacecraft(BALANCED), "wheel twice"),
    ],
)
def test_what_cannot_be_a_wheel_is_refused(load_yaml, wheel, text, message):
    with pytest.raises(InputError, match=message):
        load_yaml(f"wheels: [{wheel}]", text)


def test_a_rotor_without_inertial_is_given_its_inertia_in_the_file(load_yaml):
    bare = '<link name="rotor"/>'
    robot = load_yaml("wheels: [{joint: rw, inertia: 0.05}]", spacecraft(bare))
    (wheel,) = robot.wheels
    assert wheel.inertia == 0.05
    np.testing.assert_allclose(wheel.axis, [np.sin(0.5), 0, np.cos(0.5)], atol=1e-15)
    without = load_yaml("", spacecraft(bare, kind="fixed"))
    np.testing.assert_array_equal(robot.theta, without.theta)


def test_a_rotor_is_not_given_two_inertias(load_yaml):
    with pytest.raises(InputError, match=r"wheels\[0\].inertia: found 0.07.*0.05"):
        load_yaml("wheels: [{joint: rw, inertia: 0.07}]", spacecraft(BALANCED))
