"""`orbident new` and `orbident check`."""

from pathlib import Path

import pytest
from running import Orbident
from urdf_pieces import ARM, BASE, joint, link, robot_file, urdf


@pytest.mark.parametrize(
    "arguments", [[], ["--dh"], ["--joints", "1"], ["--wheels", "5"]]
)
def test_a_new_robot_is_checked_moved_and_identified_as_it_is(
    orbident: Orbident, arguments: list[str]
):
    orbident("new", "arm.yaml", *arguments).done()
    checked = orbident("check", "arm.yaml").done().out
    assert checked.endswith("no problems found\n")
    assert "── joint1  revolute about" in checked
    document = orbident("inspect", "arm.yaml", "--json", "-").done().json
    joints, wheels = len(document["joints"]), len(document["wheels"])
    asked = dict(zip(arguments[::2], arguments[1::2], strict=False))
    assert joints == int(asked.get("--joints", 3))
    assert wheels == int(asked.get("--wheels", 3))
    assert document["mass"] == 100.0 + 5.0 * joints
    assert document["warnings"] == []


def test_a_narrow_terminal(orbident: Orbident, monkeypatch: pytest.MonkeyPatch):
    """Lines of the tree are broken between words, and none is cut short."""
    wide = orbident("check", "cepheus-like").done().out
    monkeypatch.setenv("COLUMNS", "60")
    narrow = orbident("check", "cepheus-like").done().out
    assert max(map(len, wide.splitlines())) > 90
    assert max(map(len, narrow.splitlines())) <= 60
    words = [text.replace("│", " ").split() for text in (wide, narrow)]
    assert words[0] == words[1]


@pytest.mark.parametrize("name", ["2026", "true", "a: b", "ä", "a'b", '"'])
def test_a_new_robot_is_called_as_its_file(orbident: Orbident, name: str):
    orbident("new", f"{name}.yaml", "--joints", "1").done()
    found = orbident("inspect", f"{name}.yaml", "--json", "-").done().json["name"]
    assert found == name


def test_a_robot_file_beside_a_model(orbident: Orbident):
    """Limits are the model's, and what is called a wheel is one."""
    disc = link("disc", 0.5, (0, 0, 0), (0.005, 0.005, 0.01), (0, 0, 0))
    wheel = joint("rw_1", "base", "disc", kind="continuous")
    text = ARM.replace("</robot>", f"{wheel}{disc}</robot>")
    Path("arm.urdf").write_text(text)
    written = orbident("new", "robot.yaml", "--model", "arm.urdf").done().out
    assert "2 joints and 1 wheel (rw_1, by name)" in written
    document = orbident("inspect", "robot.yaml", "--json", "-").done().json
    assert document["joints"] == ["joint1", "joint2"]
    assert document["wheels"] == ["rw_1"]
    orbident("new", "b.yaml", "--model", "no.urdf").refused("no.urdf")
    orbident("new", "b.yaml", "--model", "robot.yaml").refused("give a URDF, xacro")
    for own in (("--dh",), ("--joints", 3), ("--wheels", 0)):
        orbident("new", "b.yaml", "--model", "arm.urdf", *own).refused(own[0])


def test_what_carries_an_arm_replaces_its_base(orbident: Orbident):
    base = "base: {mass: 200 kg, com: [0, 0, 0], inertia: [20, 22, 18]}\n"
    robot_file(Path(), lines=base)
    shown = orbident("check", "servicer.yaml").done().out
    assert "base  200 kg, CM [0, 0, 0] m, I [20, 22, 18] kg m^2" in shown
    robot_file(Path(), lines="base: {mass: 200 kg}\n")
    orbident("check", "servicer.yaml").refused("'inertia' is missing")


def test_what_somebody_edited_is_not_replaced(orbident: Orbident):
    orbident("new", "arm.yaml").done()
    before = Path("arm.yaml").read_bytes()
    orbident("new", "arm.yaml", "--dh").refused("arm.yaml: exists already")
    assert Path("arm.yaml").read_bytes() == before
    orbident("new", "arm.urdf").refused("arm.urdf: give a name that ends in .yaml")
    orbident("new", "no/arm.yaml").refused("folder 'no' does not exist")
    orbident("new", "b.yaml", "--joints", "0").refused("--joints")


def test_bundled_robots_fit_one_screen_in_width(orbident: Orbident):
    for name in ("paper-spatial", "cepheus-like", "dual-arm"):
        lines = orbident("check", name).done().out.splitlines()
        assert max(map(len, lines)) <= 110
        assert lines[-1] == "no problems found"


def test_the_tree(orbident: Orbident):
    lines = (
        "limits: {joint1: {position: [-1, 2], velocity: 0.5}}\n"
        "wheels: [{name: rw, axis: [0, 0, 2], inertia: 0.05}]\n"
        "thrusters: [{name: t, position: [0, 0, 1], direction: [1, 0, 0]}]\n"
        "feature_point: [0, 0, 0.5]\n"
        "sensors: {rate: 5, joints: {position: 1 mrad}}\n"
    )
    out = orbident("check", robot_file(Path(), ARM, lines)).done().out
    for words in (
        "servicer: spatial, 2 joints, 1 wheel, 46 kg nominal\n",
        "base  40 kg, CM [0.02, -0.05, -0.4] m",
        "body frame at S, [0, 0, 0.5] m from the link frame\n",
        "├── joint1  revolute about [0, 0, 1], at [0.3, 0.1, -0.5] m, in [-1, 2] rad, "
        "0.5 rad/s\n│   link1  3 kg, CM [0.1, 0.02, -0.03] m, I [",
        "│   └── joint2  revolute about [0, 1, 0], at [0.3, 0.1, 0] m\n",
        "├── rw  wheel, 0.05 kg m^2 about [0, 0, 1], held\n",
        "└── t  thruster at [0, 0, 1] m, towards [1, 0, 0]\n",
        "sensors (SI)\n  joints: rate 5, position 0.001\n",
    ):
        assert words in out


ODD = {
    "no mass": (
        urdf(
            link("base", *BASE),
            '<link name="light"/>',
            joint("j", "base", "light"),
        ),
        "",
        "no mass: 'light'",
    ),
    "singular": (
        urdf(
            link("base", *BASE),
            '<link name="light"/>',
            joint("j", "base", "light"),
        ),
        "",
        "the mass matrix is singular: joint 'j' can turn or slide without moving",
    ),
    "out of the plane": (
        ARM,
        "motion: planar\nwheels: [{name: rw, axis: [1, 0, 0], inertia: 0.1}]\n",
        "motion: planar, but 'joint2', 'rw' turn about another axis than base z",
    ),
    "no body can have it": (
        urdf(link("base", diagonal=(1, 1, 3), products=(0, 0, 0))),
        "",
        "violate the triangle inequality (1 + 1 < 3)",
    ),
    "no limits": (ARM, "", "no limit of the range: 'joint1', 'joint2'"),
    "no rates": (ARM, "", "no limit of the rate: 'joint1', 'joint2'"),
    "no wheels": (ARM, "", "show ratios of pi, but for the scale of pi and the mass"),
    "no velocity": (
        ARM,
        "sensors: {gyro: {angle_random_walk: 1e-6}}\n"
        "wheels: [{name: rw, axis: [1, 0, 0], inertia: 0.1}]\n",
        "show pi, but for phi and the mass 'identify' needs position or accelerometer",
    ),
    "neither": (
        ARM,
        "sensors: {gyro: {angle_random_walk: 1e-6}}\n",
        "show ratios of pi, but for the scale of pi, phi and the mass 'identify' needs",
    ),
    "no sensors": (ARM, "", "nothing is said of joints, gyro or attitude, position"),
    "an error without a tolerance": (
        ARM,
        "sensors: {suites: [tactical-imu]}\ntolerances: {gyro: {scale: 0}}\n",
        "add tolerances: {gyro: {scale: 0.0005}}",
    ),
    "all in one plane": (
        urdf(
            link("base", *BASE),
            link("l1"),
            link("l2"),
            joint("j1", "base", "l1", axis=(0, 0, 1)),
            joint("j2", "l1", "l2", axis=(0, 0, -1)),
        ),
        "",
        "all joints turn about base z: if the robot floats on a table, give",
    ),
    "millimetres": (ARM, "feature_point: [0, 0, 400]\n", "S is 399.9 m from"),
}


@pytest.mark.parametrize("case", ODD)
def test_what_is_odd(orbident: Orbident, case: str):
    text, lines, words = ODD[case]
    path = robot_file(Path(), text, lines)
    assert words in orbident("check", path).done().out.split("\nodd\n")[1]
    odd = orbident("check", path, "--json", "-").done().json["odd"]
    assert any(words in sentence for sentence in odd)


def test_the_document(orbident: Orbident):
    document = orbident("check", "cepheus-like", "--json", "-").done().json
    base, first, _ = document["bodies"]
    assert set(base) == {"name", "theta"}
    assert first["parent"] == base["name"]
    assert (first["joint"], first["type"]) == ("joint1", "revolute")
    assert len(first["theta"]) == 10
    assert document["odd"] == []


def test_a_joint_that_follows_another(orbident: Orbident):
    before, after = ARM.rsplit("</joint>", 1)
    mimic = '<mimic joint="joint1" multiplier="-2" offset="0.5"/></joint>'
    path = robot_file(Path(), before + mimic + after)
    tree = orbident("check", path).done().out
    assert (
        "joint2  revolute about [0, 1, 0], at [0.3, 0.1, 0] m, follows -2 joint1"
        in tree
    )
    assert "follows -2 joint1 +0.5\n" in tree
    (found,) = orbident("check", path, "--json", "-").done().json["couplings"]
    assert found == {
        "follower": "joint2", "leader": "joint1", "factor": -2.0, "offset": 0.5
    }  # fmt: skip


def test_an_end_without_a_limit_is_null(orbident: Orbident):
    limit = '<limit lower="-1" upper="1e30" effort="1" velocity="1e999"/>'
    text = ARM.replace("</joint>", f"{limit}</joint>", 1)
    document = orbident("check", robot_file(Path(), text), "--json", "-").done().json
    first = document["bodies"][1]
    assert (first["position"], first["velocity"]) == ([-1.0, None], None)


def test_a_robot_file_that_runs_a_program(orbident: Orbident):
    Path("r.yaml").write_text("schema: orbident/robot/1\nmodel: sc.xacro\n")
    Path("sc.xacro").write_text(ARM)
    out = orbident("check", "r.yaml").done().out
    assert "sc.xacro is a xacro file, whose expressions are run as a program" in out


def test_the_viewer_is_opened_after_it(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch
):
    shown = []
    monkeypatch.setattr(
        "orbident.cli.view.view", lambda output, robot: shown.append(robot)
    )
    orbident("check", "cepheus-like").done()
    assert shown == []
    orbident("check", "cepheus-like", "--view").done()
    assert shown == ["cepheus-like"]


def test_simulate_says_which_sensors_are_left_out(orbident: Orbident):
    path = robot_file(Path(), ARM)
    motion = (
        "schema: orbident/trajectory/1\nduration: 1\njoints: {joint1: {}, joint2: {}}\n"
    )
    Path("m.yaml").write_text(motion)
    ran = orbident("simulate", path, "m.yaml", "--noise", "sensors", "-o", "r.csv")
    assert ran.status == 0
    assert "nothing is said of joints, wheels, gyro or attitude" in ran.err
    orbident("simulate", path, "m.yaml", "-o", "ideal.csv").done()


def test_what_exporters_leave(orbident: Orbident):
    """Inertias of other bodies, copied ones, and CMs that nobody worked out."""
    heavy, at = (0.3, 0.3, 0.3), (0.0, 0.0, 0.0)
    text = urdf(
        link("base", *BASE),
        *(link(f"l{k}", 0.1 * k, at, heavy, at) for k in (1, 2, 3)),
        joint("j1", "base", "l1"),
        joint("j2", "l1", "l2"),
        joint("j3", "l2", "l3"),
    )
    shown = orbident("check", str(robot_file(Path(), text))).done().out
    assert "l1: 0.1 kg with a radius of gyration of 2.1 m" in " ".join(shown.split())
    assert "have different masses and the same inertia" in " ".join(shown.split())
    assert "have their CMs at their joints" in " ".join(shown.split())
