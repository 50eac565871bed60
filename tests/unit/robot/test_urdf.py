import logging

import numpy as np
import pytest
from urdf_texts import ARM, joint, link, robot

from orbident.errors import InputError
from orbident.robot.urdf_reader import read_urdf


def test_reads_links_and_joints():
    urdf = read_urdf(ARM)
    assert urdf.name == "test"
    assert [each.name for each in urdf.links] == ["base", "link1", "link2"]
    assert [each.name for each in urdf.joints] == ["joint1", "joint2"]
    assert urdf.links[2].mass == 4.0
    np.testing.assert_array_equal(urdf.links[2].com, [0.3, 0, 0])
    np.testing.assert_array_equal(urdf.joints[1].p, [0, 0, 0.5])


def test_inertia_is_turned_from_the_inertial_frame_into_the_links():
    text = robot(
        '<link name="base"><inertial><origin rpy="0 0 1.5707963267948966"/>'
        '<mass value="1"/><inertia ixx="1" iyy="2" izz="3"/></inertial></link>'
    )
    # A quarter turn about z exchanges the x and y moments; rounding of pi/2.
    I = read_urdf(text).links[0].I_com
    np.testing.assert_allclose(I, np.diag([2, 1, 3]), atol=1e-15)


def test_meshes_are_never_looked_for(caplog):
    visual = '<visual><geometry><mesh filename="package://no/where.dae"/></geometry>'
    text = robot(f'<link name="base">{visual}</visual></link>')
    with caplog.at_level(logging.DEBUG):
        read_urdf(text)
    assert not caplog.records


def test_odd_visuals_do_not_matter():
    assert read_urdf(robot('<link name="b"><visual><geometry/></visual></link>')).links


def test_axis_is_normalised_and_x_by_default():
    text = robot(
        link("a"), link("b"), link("c"),
        joint("j", "a", "b", axis="0 0 5"), joint("k", "b", "c", axis=None),
    )  # fmt: skip
    first, second = read_urdf(text).joints
    np.testing.assert_array_equal(first.axis, [0, 0, 1])
    np.testing.assert_array_equal(second.axis, [1, 0, 0])


@pytest.mark.parametrize(
    ("limit", "position", "velocity"),
    [
        ("", None, None),
        ('<limit effort="1" velocity="2"/>', None, 2.0),
        ('<limit lower="-1" upper="2" velocity="3"/>', (-1.0, 2.0), 3.0),
        ('<limit upper="2"/>', (0.0, 2.0), None),
        ('<limit lower="-inf" upper="inf" velocity="inf"/>', None, None),
    ],
)
def test_limits(limit, position, velocity):
    text = robot(link("a"), link("b"), joint("j", "a", "b", inside=limit))
    (found,) = read_urdf(text).joints
    assert (found.position, found.velocity) == (position, velocity)


def test_a_continuous_joint_has_no_position_limits():
    inside = '<limit lower="-1" upper="1" velocity="2"/>'
    text = robot(
        link("a"), link("b"), joint("j", "a", "b", "continuous", inside=inside)
    )
    assert read_urdf(text).joints[0].position is None
    assert read_urdf(text).joints[0].velocity == 2.0


def test_limits_without_motion_are_dropped_with_a_warning():
    inside = '<limit lower="0" upper="0" velocity="0"/>'
    urdf = read_urdf(robot(link("a"), link("b"), joint("j", "a", "b", inside=inside)))
    assert urdf.joints[0].position is None
    assert urdf.joints[0].velocity is None
    assert [w.startswith("joint 'j': ") for w in urdf.warnings] == [True, True]


def test_what_a_joint_mimics():
    links = link("a"), link("b"), link("c")
    first = joint("j", "a", "b")
    for given, found in (
        ("", (1.0, 0.0)),
        ('multiplier="-2" offset="0.1"', (-2.0, 0.1)),
    ):
        inside = f'<mimic joint="j" {given}/>'
        urdf = read_urdf(robot(*links, first, joint("k", "a", "c", inside=inside)))
        assert urdf.warnings == ()
        assert [each.mimic for each in urdf.joints] == [None, ("j", *found)]


BASE, TIP = link("base"), link("tip")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot", r"malformed XML: .*line 1"),
        ("", "malformed XML"),
        ("\x00\x01", "malformed XML"),
        ("<sdf/>", "the root element is <sdf>; give <robot>"),
        (robot(), "no <link>"),
        ("<robot><link name='a'/></robot>", "<robot>: the attribute 'name' is missing"),
        (robot("<link/>"), "<link> number 1: the attribute 'name' is missing"),
        (robot(BASE, BASE), "link 'base' is defined twice"),
        (
            robot(BASE, TIP, joint("j", "base", "tip"), joint("j", "base", "tip")),
            "joint 'j' is defined twice",
        ),
        (
            robot(BASE, TIP, joint("j", "base", "tpi")),
            "joint 'j': the child link 'tpi' is not in the file; did you mean 'tip'",
        ),
        (
            robot(BASE, TIP, joint("j", "x", "tip")),
            "joint 'j': the parent link 'x' is not in the file; known links: 'base'",
        ),
        (
            robot(BASE, TIP, '<joint name="j" type="fixed"/>'),
            "joint 'j': <parent link=...> is missing",
        ),
        (
            robot(BASE, TIP, joint("j", "base", "tip", "ball")),
            "joint 'j': found type 'ball'; give one of revolute",
        ),
        (robot(BASE, TIP, '<joint name="j"/>'), "joint 'j': found no type"),
        (
            robot(BASE, TIP, joint("j", "base", "tip", axis="0 0 0")),
            "joint 'j': found axis 0 0 0; give a nonzero vector",
        ),
        (
            robot(BASE, TIP, joint("j", "base", "tip", axis="0 1")),
            "joint 'j': <axis xyz>: found '0 1'; give 3 finite numbers",
        ),
        (
            robot(BASE, TIP, joint("j", "base", "tip", xyz="0 0 nan")),
            "joint 'j': <origin xyz>: found '0 0 nan'",
        ),
        (
            robot(BASE, TIP, joint("j", "base", "tip", rpy="0 0 ${pi/2}")),
            "expand it with xacro first",
        ),
        (
            robot(
                BASE,
                TIP,
                joint("j", "base", "tip", inside='<limit lower="2" upper="1"/>'),
            ),
            "joint 'j': found lower limit 2 above the upper limit 1",
        ),
        (
            robot(
                BASE, TIP, joint("j", "base", "tip", inside='<limit velocity="-1"/>')
            ),
            "joint 'j': found velocity limit -1",
        ),
        (robot(link("a", "nan")), "link 'a': <mass value>: found 'nan'; give one"),
        (robot(link("a", "1e999")), "link 'a': <mass value>: found '1e999'"),
        (robot(link("a", -2.0)), "link 'a': found mass -2 kg; give zero or more"),
        (robot(link("a", "heavy")), "link 'a': <mass value>: found 'heavy'"),
        (
            robot('<link name="a"><inertial><mass value="1"/></inertial></link>'),
            "link 'a': <inertial> has no <inertia>",
        ),
        (
            robot('<link name="a"><inertial><inertia ixx="1"/></inertial></link>'),
            "link 'a': <inertial> has no <mass>",
        ),
        (
            robot(
                '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1"/>'
                "</inertial></link>"
            ),
            "link 'a': <inertia> has no 'izz'",
        ),
        (
            robot('<link name="a"><inertial/><inertial/></link>'),
            "link 'a': found 2 <inertial>",
        ),
    ],
)
def test_errors_are_one_clear_line(text, message):
    with pytest.raises(InputError, match=message.replace("(", r"\(")) as caught:
        read_urdf(text, "sc.urdf")
    assert str(caught.value).startswith("sc.urdf: ")
    assert "\n" not in str(caught.value)
