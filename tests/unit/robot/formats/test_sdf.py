"""SDF files: what is refused and why; frames that files name."""

from pathlib import Path

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

INERTIAL = (
    "<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1.5</iyy><izz>2</izz>"
    "</inertia></inertial>"
)


def link(name: str, inside: str = INERTIAL) -> str:
    return f"<link name='{name}'>{inside}</link>"


def joint(
    parent: str = "base",
    child: str = "arm",
    kind: str = "revolute",
    inside: str = "<axis><xyz>0 0 1</xyz></axis>",
) -> str:
    return (
        f"<joint name='j' type='{kind}'><parent>{parent}</parent>"
        f"<child>{child}</child>{inside}</joint>"
    )


def sdf(*elements: str, version: str = "1.9") -> str:
    inside = "".join(elements)
    return f"<sdf version='{version}'><model name='m'>{inside}</model></sdf>"


ARM = sdf(link("base"), link("arm"), joint())


def load(folder: Path, text: str) -> Robot:
    (folder / "robot.sdf").write_text(text)
    return load_robot(folder / "robot.sdf")


BAD = {
    "cut off": (ARM[:200], "malformed XML"),
    "no version": (ARM.replace(" version='1.9'", ""), "<sdf> has no version"),
    "unknown version": (sdf(link("base"), version="2.0"), "<sdf> has version '2.0'"),
    "text for version": (sdf(link("base"), version="new"), "<sdf> has version 'new'"),
    "no mass": (
        sdf(link("base", INERTIAL.replace("<mass>2</mass>", ""))),
        "link 'base': <mass> is missing, for which SDF takes 1 kg",
    ),
    "no inertia": (
        sdf(link("base", "<inertial><mass>2</mass></inertial>")),
        "link 'base': <ixx> is missing, for which SDF takes 1 kg m^2",
    ),
    "part of an inertia": (
        sdf(link("base", INERTIAL.replace("<izz>2</izz>", ""))),
        "link 'base': <izz> is missing",
    ),
    "no type": (
        ARM.replace(" type='revolute'", ""), "joint 'j': found no type",
    ),
    "no model": ("<sdf version='1.9'/>", "found 0 models"),
    "two models": (
        "<sdf version='1.9'><world name='w'><model name='a'/><model name='b'/></world>"
        "</sdf>",
        "found 2 models",
    ),
    "no links": (sdf(), "no <link>"),
    "all included": (
        "<sdf version='1.9'><include><uri>model://x</uri></include></sdf>",
        "the model is included from another file",
    ),
    "included": (sdf("<include><uri>model://x</uri></include>"), "<include>"),
    "nested": (sdf(link("base"), "<model name='n'/>"), "<model>"),
    "no inertial": (sdf(link("base", "")), "link 'base': <inertial> is missing"),
    "automatic": (
        sdf(link("base", "<inertial auto='true'><density>9</density></inertial>")),
        "link 'base': <inertial auto='true'> is not read",
    ),
    "text for mass": (
        sdf(link("base", "<inertial><mass>heavy</mass></inertial>")),
        "link 'base': <mass>: found 'heavy'; give one finite number",
    ),
    "negative mass": (
        sdf(link("base", "<inertial><mass>-1</mass></inertial>")),
        "found mass -1 kg",
    ),
    "text for pose": (
        sdf(link("base", INERTIAL + "<pose>0 0 x 0 0 0</pose>"), link("arm"), joint()),
        "'base': <pose>: found '0 0 x 0 0 0'",
    ),
    "five numbers": (
        sdf(link("base", INERTIAL.replace("<mass>", "<pose>0 0 0 0 0</pose><mass>"))),
        "give 6 finite numbers",
    ),
    "no quaternion": (
        sdf(
            link("base"),
            link(
                "arm",
                INERTIAL + "<pose rotation_format='quat_xyzw'>0 0 0 0 0 0 0</pose>",
            ),
            joint(),
        ),
        "quaternion is zero",
    ),
    "unknown type": (
        sdf(link("base"), link("arm"), joint(kind="universal")),
        "joint 'j': found type 'universal'; give one of revolute",
    ),
    "no axis": (
        sdf(link("base"), link("arm"), joint(inside="<axis><xyz>0 0 0</xyz></axis>")),
        "axis 0 0 0",
    ),
    "limits": (
        sdf(
            link("base"),
            link("arm"),
            joint(inside="<axis><limit><lower>2</lower><upper>1</upper></limit></axis>"),
        ),
        "lower limit 2 above the upper limit 1",
    ),
    "unknown parent": (
        sdf(link("base"), link("arm"), joint(parent="bass")),
        "did you mean 'base'",
    ),
    "no child": (
        sdf(link("base"), "<joint name='j' type='fixed'><parent>base</parent></joint>"),
        "<child> is missing",
    ),
    "two roots": (sdf(link("base"), link("arm")), "several roots"),
    "two parents": (
        sdf(
            link("base"),
            link("b"),
            link("arm"),
            joint(),
            joint(parent="b").replace("'j'", "'k'"),
            joint(child="b").replace("'j'", "'l'"),
        ),
        "kinematic loop: link 'arm' has two parents",
    ),
    "a ring": (
        sdf(
            link("base"),
            link("arm"),
            joint(),
            joint("arm", "base").replace("'j'", "'k'"),
        ),
        "kinematic loop",
    ),
    "relative to itself": (
        sdf(link("base", INERTIAL + "<pose relative_to='base'>1 0 0 0 0 0</pose>")),
        "relative to itself",
    ),
    "relative to nothing": (
        sdf(link("base", INERTIAL + "<pose relative_to='bose'>1 0 0 0 0 0</pose>")),
        "'base' is relative to 'bose', which is not in the file; did you mean 'base'",
    ),
    "an axis in nothing": (
        sdf(
            link("base"),
            link("arm"),
            joint(inside="<axis><xyz expressed_in='x'>0 0 1</xyz></axis>"),
        ),
        "an axis is relative to 'x'",
    ),
    "attached to itself": (
        sdf(
            link("base"),
            link("arm"),
            joint(parent="f"),
            "<frame name='f' attached_to='g'/><frame name='g' attached_to='f'/>",
        ),
        "attached to itself",
    ),
    "hung on the world": (
        sdf(link("base"), joint("world", "base")),
        "joint 'j' (revolute) hangs the base on the world, but a base floats",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_refused(tmp_path: Path, case: str):
    text, words = BAD[case]
    with pytest.raises(InputError) as caught:
        load(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "robot.sdf"))
    assert words in message
    assert "\n" not in message


def test_a_base_held_by_the_world_and_a_mesh_that_is_not_there(tmp_path: Path):
    mesh = "<visual><geometry><mesh><uri>gone.dae</uri></mesh></geometry></visual>"
    held = sdf(link("base", INERTIAL + mesh), joint("world", "base", "fixed"))
    robot = load(tmp_path, held)
    assert (robot.name, robot.bodies, robot.mass) == ("m", ("base",), 2.0)


def test_a_joint_with_the_name_of_its_link(tmp_path: Path):
    turned = INERTIAL + "<pose>1 2 3 0 0 0</pose>"
    moved = joint(inside="<pose>0.5 0 0 0 0 0</pose><axis/>").replace("'j'", "'arm'")
    robot = load(tmp_path, sdf(link("base"), link("arm", turned), moved))
    np.testing.assert_array_equal(robot.joints[0].p_PJ, [1.5, 2, 3])
    np.testing.assert_array_equal(robot.theta[1, :4], [2, -1, 0, 0])


def test_prefixes_that_nobody_declared(tmp_path: Path):
    sensor = "<sensor type='custom' gz:type='flow'><gz:rate>5</gz:rate></sensor>"
    assert load(tmp_path, sdf(link("base", INERTIAL + sensor))).mass == 2.0


def test_a_model_that_is_static_alone_and_a_world(tmp_path: Path):
    static = sdf("<static>true</static>", link("base"))
    assert load(tmp_path, static).mass == 2.0
    models = static.split(">", 1)[1].removesuffix("</sdf>")
    models += sdf(link("base"), link("arm"), joint()).split(">", 1)[1]
    models = models.removesuffix("</sdf>")
    world = f"<sdf version='1.9'><world name='w'>{models}</world></sdf>"
    assert load(tmp_path, world).bodies == ("base", "arm")


def test_ends_that_are_frames(tmp_path: Path):
    frame = "<frame name='f' attached_to='base'><pose>1 0 0 0 0 0</pose></frame>"
    text = sdf(link("base"), link("arm"), frame, joint(parent="f"))
    assert load(tmp_path, text).joints[0].parent == 0


@pytest.mark.parametrize(
    ("version", "inside", "axis"),
    [
        ("1.9", "", [0, 0, 1]),
        ("1.10", "", [0, 0, 1]),
        # Turned by 90 degrees about x, the model's z is the joint's -(-y) = y.
        ("1.4", "", [0, 1, 0]),
        ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", [0, 1, 0]),
    ],
)
def test_axes_of_old_files(
    tmp_path: Path, version: str, inside: str, axis: list[float]
):
    turned = INERTIAL + f"<pose>0 0 0 {np.pi / 2!r} 0 0</pose>"
    moved = joint(inside=f"<axis><xyz>0 0 1</xyz>{inside}</axis>")
    text = sdf(link("base"), link("arm", turned), moved, version=version)
    # cos(pi / 2) is 6e-17.
    np.testing.assert_allclose(load(tmp_path, text).joints[0].axis, axis, atol=1e-15)


def test_a_joint_that_follows_another(tmp_path: Path):
    mimic = (
        "<axis><xyz>0 0 1</xyz><mimic joint='j'><multiplier>-2</multiplier>"
        "<offset>0.5</offset><reference>0.1</reference></mimic></axis>"
    )
    finger = joint("base", "finger", inside=mimic).replace("'j' type", "'k' type")
    text = sdf(link("base"), link("arm"), link("finger"), joint(), finger)
    # q = -2 (q' - 0.1) + 0.5
    assert load(tmp_path, text).couplings == (("k", "j", -2.0, 0.7),)
    without = text.replace("<multiplier>-2</multiplier>", "")
    with pytest.raises(InputError, match="'k': <mimic>: <multiplier> is missing"):
        load(tmp_path, without)


def test_limits(tmp_path: Path):
    limit = "<axis><limit><lower>{}</lower><upper>{}</upper>{}</limit></axis>"
    for lower, upper, velocity, position, rate in (
        (-1, 2, "<velocity>0.5</velocity>", (-1.0, 2.0), 0.5),
        (-1e16, 1e16, "<velocity>-1</velocity>", None, None),
        ("-inf", "inf", "", None, None),
        (-1, 1e16, "", (-1.0, np.inf), None),
    ):
        text = sdf(
            link("base"),
            link("arm"),
            joint(inside=limit.format(lower, upper, velocity)),
        )
        found = load(tmp_path, text).joints[0]
        assert (found.position, found.velocity) == (position, rate)
