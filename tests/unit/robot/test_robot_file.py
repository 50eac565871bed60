import os
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import finished
from urdf_texts import ARM, SHARED_ROBOTS, joint, link, robot

import orbident
from orbident.errors import InputError
from orbident.robot.robot_file import load_robot

FULL = """
name: sc
motion: planar
base_link: base
feature_point: [0.5, 0, 1.0e-1]
wheels:
  - {name: rw, axis: [0, 0, 2], inertia: 0.1, mode: free}
thrusters:
  - {name: t1, position: [0.2, 0, 0], direction: [0, 4, 3]}
limits:
  joint1: {position: [-1, 2], velocity: 0.7}
structure:
  link1: {com_on_axis: z}
sensors:
  rate: 20.0
  gyro: {angle_random_walk: 60 deg/sqrt(h)}
  attitude: {angle: 180 deg}
"""


def test_only_the_urdf_is_required(load_yaml):
    found = load_yaml()
    assert found.name == "test"
    assert found.motion == "spatial"
    assert (found.wheels, found.thrusters, found.sensors.declared) == ((), (), {})
    assert found.urdf == ARM
    assert found.document == {"schema": "orbident/robot/1", "urdf": "arm.urdf"}


def test_a_planar_root_proposes_the_plane(load_yaml):
    urdf = robot(link("world", None), link("b"), joint("p", "world", "b", "planar"))
    (proposal,) = load_yaml(urdf=urdf).warnings
    assert proposal.startswith("joint 'p' above the base is planar")
    assert load_yaml("motion: planar", urdf).warnings == ()
    floating = urdf.replace("planar", "floating")
    assert load_yaml(urdf=floating).warnings == ()


def test_a_full_robot_file(load_yaml):
    found = load_yaml(FULL)
    assert (found.name, found.motion) == ("sc", "planar")
    np.testing.assert_array_equal(found.feature_point, [0.5, 0, 0.1])
    np.testing.assert_allclose(found.thrusters[0].direction, [0, 0.8, 0.6])
    assert found.joints[0].position == (-1.0, 2.0)
    assert found.joints[0].velocity == 0.7
    assert found.joints[1].position is None
    assert found.structure["link1"].com_on_axis == "z"
    assert found.sensors.rate == 20.0
    assert found.sensors.of("attitude").white_std() == pytest.approx(np.pi)
    assert found.sensors.of("gyro").white_std() == pytest.approx(np.pi / 180)
    assert found.sensors.of("gyro").bias_walk == 0.0
    # Base CM at 0.1 m along x of the base link; S at [0.5, 0, 0.1].
    np.testing.assert_allclose(found.theta[0, :4], [100, -40, 0, -10])


def test_a_bare_urdf(load_urdf):
    found = load_urdf(ARM)
    assert found.bodies == ("base", "link1", "link2")
    assert found.joint_names == ("joint1", "joint2")
    assert found.document["urdf"] == "test.urdf"


def test_a_robot_can_be_sent_to_another_process(load_yaml):
    found = load_yaml(FULL)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(found)).theta, found.theta)


def test_importing_does_not_import_yourdfpy():
    # A second of trimesh, which "orbident --help" should not wait for.
    code = "import orbident.robot.robot_file, sys; sys.exit('yourdfpy' in sys.modules)"
    env = os.environ | {"PYTHONPATH": str(Path(orbident.__file__).parents[1])}
    assert finished(sys.executable, "-c", code, env=env).returncode == 0


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("wheels: [{name: a, axis: [0, 0, 0], inertia: 1}]",
         r"wheels\[0\]\.axis: found \[0, 0, 0\]; give a nonzero 3-vector"),
        ("wheels: [{name: a, axis: [0, 1], inertia: 1}]",
         r"axis: found \[0, 1\]; give a 3-vector"),
        ("wheels: [{name: a, axis: [0, .nan, 1], inertia: 1}]",
         "give a 3-vector of finite numbers"),
        ("wheels: [{name: a, axis: [0, 0, 1], inertia: -1}]",
         r"wheels\[0\]\.inertia: found -1; give a number above zero"),
        ("wheels: [{name: a, axis: [0, 0, 1], inertia: yes}]", "found 'yes'; give a"),
        ("wheels: [{name: a, inertia: 1}]", r"wheels\[0\]: 'axis' missing"),
        ("wheels: [{axis: [0, 0, 1]}]", "'name' and 'inertia' missing"),
        ("wheels: [{name: a, axis: [0, 0, 1], inertia: 1, mode: fast}]",
         "mode: found 'fast'; give 'held' or 'free'"),
        ("wheels: [{name: a, axes: [0, 0, 1]}]",
         r"wheels\[0\]: unknown key 'axes'; did you mean 'axis'\? known keys: 'name'"),
        ("wheels: [{name: a, axis: [0, 0, 1], inertia: 1},"
         " {name: a, axis: [1, 0, 0], inertia: 1}]", "the name 'a' is given twi"),
        ("wheels: 5", "wheels: found 5; give a list"),
        ("wheels:", "wheels: found nothing; give a list"),
        ("wheels: [3]", r"wheels\[0\]: found 3; give keys and values: name, joint"),
        ("wheels:\n- {name: a, axis: [1, 0, 0], inertia: 1}\n- name: b\n  axis: x",
         r"servicer\.yaml:6: wheels\[1\]\.axis: found 'x'"),
        ("wheels:\n- name: b\n  axes: [1, 0, 0]\n  inertia: 1",
         r"servicer\.yaml:5: wheels\[0\]: unknown key 'axes'; did you mean 'axis'"),
        ("sensors:\n  rate: 1\n  attitude:\n    latency: 1 s",
         r"servicer\.yaml:5: sensors\.attitude\.angle: this key is missing"),
        ("thrusters: [{name: t, position: [0, 0, 0]}]",
         r"thrusters\[0\]\.direction: this key is missing"),
        ("thrusters: [{name: t, position: [0, 0, 0], direction: [0, 0, 0]}]",
         "give a nonzero 3-vector"),
        ("wheel: []", "servicer.yaml:3: unknown key 'wheel'; did you mean 'wheels'"),
        ("1: 2", "servicer.yaml:3: unknown key 1; known keys: 'schema', 'name', "),
        ("motion: plane", "motion: found 'plane'; give 'spatial' or 'planar'"),
        ("name: 5", "name: found 5; give text"),
        ("name: a\nname: b", "servicer.yaml:4:1: the key 'name' is given twice"),
        ("limits: {joint9: {velocity: 1}}",
         "limits: no joint 'joint9'; did you mean 'joint2'.* 'joint1', 'joint2'"),
        ("limits: {joint1: {position: [2, 1]}}",
         r"limits\.joint1\.position: found \[2, 1\]; .*lower below upper"),
        ("limits: {joint1: {position: 2}}", r"found 2; give \[lower, upper\]"),
        ("structure: {link9: {com_on_axis: x}}",
         "structure: no body 'link9'; did you mean 'link2'.* 'base', 'link1', 'link2'"),
        ("structure: {link1: {com_on_axis: w}}", "found 'w'; give 'x', 'y' or 'z'"),
        ("base_link: bas", "base_link: no link 'bas'; did you mean 'base'"),
        ("feature_point: 0", "feature_point: found 0; give a 3-vector"),
        ("sensors: {gyro: {angle_random_walk: 1 deg/h}}",
         r"sensors\.gyro\.angle_random_walk: found '1 deg/h'; unknown unit 'deg/h' of "
         r"an angle random walk; accepted: rad/sqrt\(s\)"),
        ("sensors: {gyros: {}}", "sensors: unknown key 'gyros'; did you mean 'gyro'"),
        ("sensors: {rate: 0}", r"sensors\.rate: found 0; give a rate above zero"),
        ("sensors: {joints: {position: -1 rad}}", "found '-1 rad'; give zero or more"),
        ("sensors: {attitude: {}}", r"sensors\.attitude\.angle: this key is missing"),
        ("name: *x", "servicer.yaml:3:7: no valid YAML"),
    ],
)  # fmt: skip
def test_errors_name_file_place_finding_and_remedy(load_yaml, lines, message):
    with pytest.raises(InputError, match=message) as caught:
        load_yaml(lines)
    assert "servicer.yaml" in str(caught.value) or "arm.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "found an empty file; .* first 'schema: orbident/robot/1'"),
        (b"\xff\xfe\x00", "byte 0 is not UTF-8 text"),
        (b"urdf: x.urdf", "schema: this key is missing"),
        (b"schema: orbident/robot/1", "'model' is missing; give a URDF"),
        (b"schema: orbident/robot/2\nurdf: x.urdf",
         "schema: found 'orbident/robot/2'; give 'orbident/robot/1'"),
        (b"schema: orbident/robot/1\nurdf: x.urdf", "urdf: no file .*x.urdf; give a"),
    ],
)  # fmt: skip
def test_files_that_are_no_robot_files(tmp_path, content, message):
    path = tmp_path / "servicer.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        load_robot(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("dual-am", "did you mean 'dual-arm'.*'cepheus-like', 'dual-arm', 'paper-sp"),
        ("nothing.urdf", "no such file"),
        ("nothing.yaml", "no such file"),
        ("nothing.sdf", "no such file; check the path"),
        ("sc.urdf.xacro", "no such file; check the path"),
        (ARM, "is no path"),
        (f"{'x' * 5000}.urdf", "cannot be read"),
        ("", "is a folder"),
    ],
)
def test_sources_that_are_no_robot(name, message):
    with pytest.raises(InputError, match=message):
        load_robot(name)


def test_directories_are_refused(tmp_path):
    for name in ("run", "run.urdf", "run.yaml"):
        (tmp_path / name).mkdir()
        with pytest.raises(InputError, match="is a folder; give a"):
            load_robot(tmp_path / name)
    (tmp_path / "run" / "robot.yaml").touch()
    with pytest.raises(InputError, match=r"folder; give .*robot\.yaml"):
        load_robot(tmp_path / "run")


def test_binary_urdf_is_refused(tmp_path):
    path = tmp_path / "sc.urdf"
    path.write_bytes(b"\x89PNG\xff")
    with pytest.raises(InputError, match=r"sc\.urdf: byte 0 is not UTF-8"):
        load_robot(path)


def test_a_file_of_another_kind_is_refused(tmp_path):
    (tmp_path / "sc.txt").write_text(ARM)
    with pytest.raises(InputError, match="unknown type of file"):
        load_robot(tmp_path / "sc.txt")


def test_a_robot_without_mass_is_refused(load_urdf):
    with pytest.raises(InputError, match="no link has mass"):
        load_urdf(robot(link("base", None)))


def test_a_urdf_that_declares_another_encoding(load_urdf):
    text = '<?xml version="1.0" encoding="ISO-8859-1"?>' + ARM
    assert load_urdf(text).mass == 109.0


def test_astrobee():
    path = SHARED_ROBOTS / "astrobee" / "astrobee_perching_arm_iss.urdf"
    if not path.is_file():
        pytest.skip("the Astrobee URDF is not beside this repository")
    found = load_robot(path)
    assert found.bodies[:2] == ("honey/body", "honey/top_aft_arm_proximal_link")
    assert len(found.joints) == 6
    # 9.0877 kg on a fixed child of the root, 0.3078 kg on another one.
    assert found.theta[0, 0] == pytest.approx(9.3955, rel=1e-12)
    assert found.joint_names[0] == "top_aft_arm_proximal_joint"
    assert found.warnings == ()
