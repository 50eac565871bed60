"""MJCF files: what is refused and why; what has no part in inertias does not matter."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.robot.description import Robot
from orbident.robot.formats import mjcf as mjcf_file
from orbident.robot.formats.mjcf import compiled_mjcf
from orbident.robot.robot_file import load_robot

BASE = "<freejoint/><inertial pos='0 0 0' mass='10' diaginertia='1 1 1'/>"
ARM = (
    "<body name='arm' pos='1 0 0'><joint name='j' axis='0 0 1' range='-90 45'/>"
    "<inertial pos='0.2 0 0' mass='2' diaginertia='0.1 0.2 0.2'/>{}</body>"
)
SECOND = (
    "<body name='tip'><joint name='k' axis='0 0 1' ref='10'/>"
    "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>"
)
EQUALITY = "<equality>{}</equality>"
FOLLOWS = "<joint joint1='k' joint2='j' polycoef='{}'/>"


def mjcf(*bodies: str, before: str = "", after: str = "") -> str:
    world = "".join(bodies)
    return f"<mujoco model='m'>{before}<worldbody>{world}</worldbody>{after}</mujoco>"


def servicer(inside: str = "", **around: str) -> str:
    return mjcf(f"<body name='base'>{BASE}{ARM.format(inside)}</body>", **around)


def load(folder: Path, text: str) -> Robot:
    (folder / "robot.xml").write_text(text)
    return load_robot(folder / "robot.xml")


BAD = {
    "cut off": (servicer()[:150], "MuJoCo cannot read it"),
    "no body": ("<mujoco/>", "<mujoco> has no <body>"),
    "unknown element": (servicer("<bdy/>"), "bdy"),
    "unknown type": (servicer("<joint type='screw'/>"), "'screw'"),
    "text for mass": (servicer().replace("'10'", "'heavy'"), "mass"),
    "text for pose": (servicer().replace("'1 0 0'", "'1 0 x'"), "pos"),
    "no inertia": (
        mjcf("<body name='base'><freejoint/></body>"),
        "mass and inertia of moving bodies",
    ),
    "not a number": (servicer().replace("'1 0 0'", "'1 NaN 0'"), "found 'NaN'"),
    "infinite, not a number": (
        servicer().replace("'1 0 0'", "'inf 0 nan'"),
        "found 'NaN'",
    ),
    # MuJoCo only warns.
    "too far": (servicer().replace("'0.2 0 0'", "'1e154 0 0'"), "give at most 1e+12"),
    "no file": (servicer(before="<include file='gone.xml'/>"), "gone.xml"),
    "two bases": (
        mjcf(f"<body name='a'>{BASE}</body><body name='b'>{BASE}</body>"),
        "the bodies 'a', 'b' are all at the top of the world",
    ),
    "no base": (
        mjcf(ARM.format("")),
        "body 'arm' hangs on the world by a joint, but a base floats",
    ),
    "a ball": (
        servicer().replace("axis='0 0 1' range='-90 45'", "type='ball'"),
        "joint 'j' is a ball joint",
    ),
    "a mesh that weighs": (
        mjcf(
            "<body name='base'><freejoint/><geom type='mesh' mesh='hull'/></body>",
            before="<asset><mesh name='hull' file='gone.stl'/></asset>",
        ),
        "gone.stl'; put it there, or give the bodies that it weighs an <inertial>",
    ),
    # What follows made MuJoCo crash or never end.
    "a file in itself": (
        servicer(
            "<attach model='again' body='arm' prefix='p'/>",
            before="<asset><model name='again' file='robot.xml'/></asset>",
        ),
        "MuJoCo crashes with this file",
    ),
    "a field of heights": (
        servicer(
            before="<asset><hfield name='h' nrow='90000' ncol='90000' size='1 1 1 1'/>"
            "</asset>"
        ),
        "needs more than 800 MB of memory",
    ),
    "a loop": (
        servicer(after=EQUALITY.format("<connect body1='arm' anchor='0 0 0'/>")),
        "<equality> <connect> of 'arm' closes a loop or holds the robot",
    ),
    "a loop of a body that is not there": (
        servicer(after=EQUALITY.format("<weld body1='gone' body2='gone'/>")),
        "<equality> <weld> names 'gone', which the model does not have",
    ),
    "two joints by a parabola": (
        servicer(SECOND, after=EQUALITY.format(FOLLOWS.format("0 1 2"))),
        "<equality> <joint> of 'k', 'j' closes a loop",
    ),
    "a joint that is held": (
        servicer(after=EQUALITY.format("<joint joint1='j'/>")),
        "<equality> <joint> of 'j' closes a loop",
    ),
}


ENDED = {"a file in itself", "a field of heights"}
"""What would end this process, too."""


@pytest.mark.parametrize("case", BAD)
def test_what_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str):
    if case not in ENDED:
        # A child says the same, and takes half a second.
        monkeypatch.setattr(mjcf_file, "confined", lambda read, path, **_: read(path))
    text, words = BAD[case]
    with pytest.raises(InputError) as caught:
        load(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "robot.xml"))
    assert words in message
    assert "\n" not in message


def test_what_has_no_part_in_inertias_is_not_looked_for(tmp_path: Path):
    text = servicer(
        "<geom type='mesh' mesh='hull' material='paint'/><site name='s'/>",
        before="<asset><mesh name='hull' file='gone.stl'/><texture name='t' type='2d' "
        "file='gone.png'/><material name='paint' texture='t'/></asset>",
        after="<sensor><gyro site='s'/></sensor>"
        "<actuator><motor joint='j'/></actuator>",
    )
    robot = load(tmp_path, text)
    assert robot.bodies == ("base", "arm")
    assert robot.mass == 12.0
    assert robot.joints[0].position == pytest.approx((-np.pi / 2, np.pi / 4))
    assert not list(tmp_path.glob("MUJOCO*"))


def test_sizes_of_a_simulation_have_no_part(tmp_path: Path):
    text = servicer(before="<size nkey='2000000000' nuserdata='2000000000'/>")
    assert load(tmp_path, text).mass == 12.0


@pytest.mark.long
def test_what_would_not_end_is_stopped(tmp_path: Path):
    lamps = "<replicate count='1000000000'><body><geom size='1'/></body></replicate>"
    with pytest.raises(InputError, match="needs more than 3 s of the processor"):
        load(tmp_path, servicer(lamps))


def test_a_joint_that_follows_another(tmp_path: Path):
    text = servicer(SECOND, after=EQUALITY.format(FOLLOWS.format("0.5 3")))
    # q - 10 deg = 0.5 + 3 q', since the leader's `ref` is zero.
    offset = pytest.approx(np.radians(10) + 0.5, rel=1e-15)
    assert load(tmp_path, text).couplings == (("k", "j", 3.0, offset),)


def test_equalities_of_scenery_and_inactive_ones_do_not_count(tmp_path: Path):
    ties = (
        "<weld body1='lamp'/><weld body1='base' active='false'/>"
        "<connect site1='s' site2='t'/>"
    )
    lamp = (
        "<body name='lamp' pos='0 0 3'><site name='s'/><site name='t'/>"
        "<joint/><geom size='1'/></body>"
    )
    text = servicer(after=EQUALITY.format(ties))
    assert load(tmp_path, text.replace("<worldbody>", f"<worldbody>{lamp}")).joints


def test_a_base_on_a_table_and_scenery(tmp_path: Path):
    table = (
        "<joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint/>"
    )
    planar = servicer().replace("<freejoint/>", table)
    on_table = load(tmp_path, planar)
    assert on_table.bodies == ("base", "arm")
    assert "give motion: planar in a robot file" in on_table.warnings[0]
    floor = "<geom type='plane' size='1 1 1'/><body name='lamp' pos='0 0 3'/>"
    scene = servicer().replace("<worldbody>", f"<worldbody>{floor}")
    assert load(tmp_path, scene).bodies == ("base", "arm")


def test_bodies_and_joints_without_names(tmp_path: Path):
    text = servicer()
    for name in (" model='m'", "name='base'", "name='j'"):
        text = text.replace(name, "")
    robot = load(tmp_path, text)
    assert robot.name == "robot"
    assert (robot.bodies, robot.joint_names) == (("body1", "arm"), ("joint1",))


def test_inertia_from_shapes(tmp_path: Path):
    box = "<geom type='box' size='0.1 0.2 0.3' mass='6'/>"
    robot = load(tmp_path, mjcf(f"<body name='base'><freejoint/>{box}</body>"))
    # A box: m (b^2 + c^2) / 12 with its whole lengths.
    moments = 6 / 12 * np.array([0.4**2 + 0.6**2, 0.2**2 + 0.6**2, 0.2**2 + 0.4**2])
    np.testing.assert_allclose(robot.theta[0, [4, 6, 9]], moments, rtol=1e-14)


def test_what_mujoco_warns_of_leaves_no_file(tmp_path: Path, monkeypatch):
    """It writes warnings into a file of the working directory."""
    (tmp_path / "robot.xml").write_text(servicer().replace("'1 0 0'", "'1 0 nan'"))
    monkeypatch.chdir(tmp_path)
    with suppress(InputError):
        compiled_mjcf("robot.xml")
    assert [each.name for each in tmp_path.iterdir()] == ["robot.xml"]
