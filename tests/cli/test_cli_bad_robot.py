"""Robots that cannot be used: one line, status 2, and what to do."""

from pathlib import Path

import pytest
from running import Orbident
from urdf_pieces import ARM, BASE, WHEELS, joint, link, robot_file, urdf

MASSLESS = (0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

MALFORMED_URDFS = {
    "cut off": ('<robot name="r"><link name="base">', "malformed XML"),
    "no XML": ("a recording, by mistake\n", "malformed XML"),
    "empty": ("", "servicer.urdf"),
    "another format": ('<mujoco model="r"/>', "<mujoco>"),
    "no links": ('<robot name="r"/>', "no <link>"),
    "no name of a link": ('<robot name="r"><link/></robot>', "'name' is missing"),
    "the same link twice": (urdf(link("base"), link("base")), "'base'"),
    "words for numbers": (
        urdf(link("base", "heavy")),  # type: ignore[arg-type]
        "found 'heavy'",
    ),
    "negative mass": (urdf(link("base", -1.0)), "found mass -1"),
    "infinite mass": (urdf(link("base", float("inf"))), "found 'inf'"),
    "unknown parent": (
        urdf(link("base"), link("a"), joint("j", "bass", "a")),
        "did you mean 'base'?",
    ),
    "unknown type": (
        urdf(link("base"), link("a"), joint("j", "base", "a", kind="ball")),
        "found type 'ball'",
    ),
    "no axis": (
        urdf(link("base"), link("a"), joint("j", "base", "a", axis=(0, 0, 0))),
        "axis",
    ),
    "two roots": (urdf(link("base"), link("a")), "several roots"),
    "a ring": (
        urdf(
            link("base"),
            link("a"),
            link("b"),
            joint("j1", "base", "a"),
            joint("j2", "a", "b"),
            joint("j3", "base", "b"),
        ),
        "kinematic loop: link 'b' has two parents",
    ),
    "a cycle": (
        urdf(
            link("base"),
            link("a"),
            link("b"),
            joint("j1", "a", "b"),
            joint("j2", "b", "a"),
        ),
        "kinematic loop",
    ),
}


@pytest.mark.parametrize("case", MALFORMED_URDFS)
def test_malformed_urdf(orbident: Orbident, case: str):
    text, words = MALFORMED_URDFS[case]
    Path("servicer.urdf").write_text(text)
    orbident("inspect", "servicer.urdf").refused("servicer.urdf", words)


MALFORMED_FILES = {
    "unknown key": ("feature_piont: [0, 0, 0]", "feature_point"),
    "unknown key of a wheel": (
        "wheels: [{name: w, axis: [0, 0, 1], inertia: 1, spin: 3}]",
        "wheels[0]: unknown key 'spin'",
    ),
    "no YAML": ("wheels: [", ":4:1: no valid YAML"),
    "a key twice": ("name: a\nname: b", ":4:1: the key 'name'"),
    "another motion": ("motion: aerial", "motion"),
    "two numbers of three": ("feature_point: [0, 0]", "feature_point"),
    "NaN": ("feature_point: [0, 0, .nan]", "feature_point"),
    "negative inertia": (
        "wheels: [{name: w, axis: [0, 0, 1], inertia: -1}]",
        "wheels[0].inertia",
    ),
    "axis of no length": (
        "wheels: [{name: w, axis: [0, 0, 0], inertia: 1}]",
        "wheels[0].axis",
    ),
    "unknown wheel joint": ("wheels: [{joint: joint9}]", "known joints: 'joint1'"),
    "wheel on a link": ("wheels: [{joint: joint2}]", "must be on the base"),
    "unknown joint in limits": ("limits: {joint7: {velocity: 1}}", "no joint 'joint7'"),
    "unknown body in structure": (
        "structure: {link7: {com_on_axis: x}}",
        "no body 'link7'",
    ),
    "wrong unit": ("sensors: {joints: {position: 3 kg}}", "sensors.joints.position"),
    "no rate": ("sensors: {rate: 0}", "sensors.rate"),
}


@pytest.mark.parametrize("case", MALFORMED_FILES)
def test_malformed_robot_file(orbident: Orbident, tmp_path: Path, case: str):
    lines, words = MALFORMED_FILES[case]
    robot_file(tmp_path, lines=lines + "\n")
    orbident("inspect", "servicer.yaml").refused("servicer.yaml:", words)


def test_unknown_base_link(orbident: Orbident, tmp_path: Path):
    robot_file(tmp_path, lines="base_link: torso\n")
    orbident("inspect", "servicer.yaml").refused("base_link: no link 'torso'")


def test_robot_file_of_another_version(orbident: Orbident):
    Path("r.yaml").write_text("schema: orbident/robot/2\nurdf: r.urdf\n")
    orbident("inspect", "r.yaml").refused("r.yaml:1: ", "orbident/robot/1")


def test_robot_file_without_its_urdf(orbident: Orbident):
    Path("r.yaml").write_text("schema: orbident/robot/1\nurdf: gone.urdf\n")
    orbident("inspect", "r.yaml").refused("r.yaml: urdf", "gone.urdf")
    Path("r.yaml").write_text("schema: orbident/robot/1\n")
    orbident("inspect", "r.yaml").refused("r.yaml: ", "'model' is missing")


@pytest.mark.parametrize("name", ["gone.urdf", "gone.yaml"])
def test_no_such_file(orbident: Orbident, name: str):
    orbident("inspect", name).refused(f"{name}: no such file")


def test_no_such_robot(orbident: Orbident):
    orbident("inspect", "paper-spacial").refused("did you mean 'paper-spatial'?")


@pytest.mark.parametrize("name", ["folder", "folder.urdf", "folder.yaml"])
def test_folder_for_a_robot(orbident: Orbident, name: str):
    Path(name).mkdir()
    orbident("inspect", name).refused(f"{name}: ", "folder")


@pytest.mark.parametrize("name", ["r.urdf", "r.yaml"])
@pytest.mark.parametrize("content", [b"", b"\x00\x01\xff\xfe\x80ELF" * 50])
def test_empty_and_binary_files(orbident: Orbident, name: str, content: bytes):
    Path(name).write_bytes(content)
    orbident("inspect", name).refused(f"{name}: ")


def test_text_of_another_kind(orbident: Orbident):
    Path("notes.txt").write_text("hello")
    orbident("inspect", "notes.txt").refused("notes.txt: ", "unknown type of file")
    Path("list.yaml").write_text("- 1\n- 2\n")
    orbident("inspect", "list.yaml").refused("list.yaml: ")


SINGULAR = {
    "massless tip": (
        urdf(
            link("base", *BASE),
            link("link1"),
            link("tip", *MASSLESS),
            joint("joint1", "base", "link1"),
            joint("wrist", "link1", "tip"),
        ),
        "joint 'wrist'",
    ),
    "point mass on its own axis": (
        urdf(
            link("base", *BASE),
            link("bob", 2.0, (0, 0, 0.3), (0, 0, 0), (0, 0, 0)),
            joint("twist", "base", "bob"),
        ),
        "joint 'twist'",
    ),
    # The second joint turns about the first one's axis, and nothing is in between.
    "two joints in one": (
        urdf(
            link("base", *BASE),
            link("ring", *MASSLESS),
            link("link2"),
            joint("joint1", "base", "ring"),
            joint("joint2", "ring", "link2", xyz=(0, 0, 0.2)),
        ),
        "joint",
    ),
}


@pytest.mark.parametrize("case", SINGULAR)
def test_singular_mass_matrix(orbident: Orbident, tmp_path: Path, case: str):
    text, words = SINGULAR[case]
    robot_file(tmp_path, text)
    line = orbident("inspect", "servicer.yaml").refused("servicer: ", "singular", words)
    assert "give the links beyond it an inertia" in line


def test_a_singular_robot_is_refused_by_every_verb(orbident: Orbident, tmp_path: Path):
    robot_file(tmp_path, SINGULAR["massless tip"][0], WHEELS)
    Path("motion.yaml").write_text(
        "schema: orbident/trajectory/1\nduration: 1\njoints: {joint1: {}, wrist: {}}\n"
    )
    Path("rec.csv").write_text("t,joint.joint1.position\n0,0\n1,0\n")
    orbident("simulate", "servicer.yaml", "motion.yaml", "-o", "r.csv").refused(
        "joint 'wrist'"
    )
    orbident("identify", "servicer.yaml", "rec.csv").refused("joint 'wrist'")


def test_a_robot_without_mass(orbident: Orbident):
    text = urdf(link("base", *MASSLESS), link("a", *MASSLESS), joint("j", "base", "a"))
    Path("r.urdf").write_text(text)
    orbident("inspect", "r.urdf").refused("r.urdf", "no link has mass")


def test_impossible_inertia_is_reported_and_no_error(orbident: Orbident):
    """CAD values are only a start: identification goes on."""
    text = ARM.replace('ixx="0.12"', 'ixx="1.2"', 1)
    Path("r.urdf").write_text(text)
    document = orbident("inspect", "r.urdf", "--json", "-").done().json
    (warning,) = document["warnings"]
    assert "link 'link1'" in warning
    assert "triangle inequality" in warning
    assert warning in orbident("inspect", "r.urdf").done().out
