"""Robots that do not come with the package, from their URDF to a scored model."""

import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from random_motions import Start, random_motion
from running import LINEAR, Orbident, Ran, check_recovered, missing, worst_error
from urdf_pieces import ARM, BASE, WHEELS, joint, link, robot_file, urdf

from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory_file import save_trajectory

EXACT = 1e-9
PREDICTED = 1e-6
"""Limit of errors of predicted signals, as the issue asks: splines between samples."""

SHARED = Path(__file__).parents[2].parent / "shared" / "robots"
needs_shared = pytest.mark.skipif(
    not SHARED.is_dir(), reason="the shared robots are not beside this checkout"
)


class Whole:
    """The whole way through the command, for one robot."""

    def __init__(self, orbident: Orbident, robot: Path | str) -> None:
        self.orbident, self.path = orbident, robot
        self.robot = load_robot(robot)
        self.inspected = orbident("inspect", robot, "--json", "-").done().json

    def simulated(self, to: str, start: Start = "turning", **motion: Any) -> str:
        save_trajectory(random_motion(self.robot, start=start, **motion), "m.yaml")
        self.orbident("simulate", self.path, "m.yaml", "-o", to, "--quiet").done()
        return to

    def identified(
        self,
        recording: str,
        momentum: Literal["unknown", "at-rest"] = "unknown",
    ) -> Ran:
        return self.orbident(
            *("identify", self.path, recording, "--initial-momentum", momentum),
            *LINEAR,
            *("-o", "run", "--force", "--json", "-"),
        )

    def check(
        self, start: Start = "turning", exact: float = EXACT, **motion: Any
    ) -> dict[str, Any]:
        """Simulate, identify, and predict a second motion."""
        momentum = "at-rest" if self.robot.motion == "planar" else "unknown"
        ran = self.identified(self.simulated("r.parquet", start, **motion), momentum)
        result = ran.json
        assert result["warnings"] == self.inspected["warnings"]
        check_recovered(result, self.inspected, exact)
        assert ran.status == 0
        other = self.simulated("other.csv", start, **(motion | {"seed": 9}))
        scores = self.orbident("validate", "run", other, "--json", "-").done().json
        assert scores["nrmse"]["gyro"] < PREDICTED
        assert scores["nrmse"]["velocity"] < PREDICTED
        return result


NAMES = (
    "left/shoulder",
    "[red]slide[/red]",
    "Gelenk-ä-関節",
    "a,b.position",
    "j" * 300,
)

TWO_ARMS = urdf(
    link("body", *BASE),
    link("shoulder"),
    link("boom"),
    link("hand"),
    link("upper arm"),
    link("tool", 1.0, (0.0, 0.1, 0.05), (0.02, 0.03, 0.02), (0.001, 0, -0.002)),
    link("plate", 0.5, (0.01, 0, 0.02), (0.004, 0.005, 0.006), (0, 0, 0)),
    link("rotor", 2.0, (0, 0, 0.03), (0.01, 0.01, 0.02), (0, 0, 0)),
    joint(NAMES[0], "body", "shoulder", rpy=(0.3, -0.2, 0.5)),
    joint(NAMES[1], "shoulder", "boom", kind="prismatic", axis=(1, 0.5, 0)),
    joint(NAMES[2], "boom", "hand", kind="continuous", axis=(0, 1, 1)),
    joint(NAMES[3], "body", "upper arm", xyz=(-0.4, 0.2, 0.1), axis=(1, 0, 0)),
    joint(NAMES[4], "upper arm", "tool", axis=(0, 1, 0)),
    joint("bolts", "tool", "plate", kind="fixed", rpy=(0.1, 0.2, 0.3)),
    joint("spin", "body", "rotor", kind="continuous", rpy=(0.4, 0, 0)),
    name="[bold]two arms",
)

TWO_ARMS_FILE = """\
feature_point: [0.2, -0.1, 0.35]
wheels:
  - {name: "rw/spin", joint: spin}
  - {name: rw_x, axis: [1, 0, 0], inertia: 0.03}
  - {name: rw_y, axis: [0, 1, 0], inertia: 0.03, mode: free}
"""


@pytest.mark.slow
def test_two_arms(orbident: Orbident, tmp_path: Path):
    """Prismatic and tilted joints, odd names, a fixed plate, a wheel taken from the
    URDF, one that spins freely, and a feature point off the base link's origin."""
    whole = Whole(orbident, robot_file(tmp_path, TWO_ARMS, TWO_ARMS_FILE))
    assert whole.inspected["joints"] == list(NAMES)
    assert whole.inspected["wheels"] == ["rw/spin", "rw_x", "rw_y"]
    # The rotor is counted once, in the base.
    assert whole.inspected["mass"] == pytest.approx(40 + 4 * 3 + 1 + 0.5 + 2)
    whole.check()
    # Names are shown as they are, never taken for markup, and never cut short.
    shown = orbident("inspect", whole.path).done().out
    for name in ("[bold]two arms: spatial", *NAMES):
        assert name in shown
    identified = orbident("identify", whole.path, "r.parquet", *LINEAR).done()
    assert identified.out.startswith("[bold]two arms: trusted")


def test_one_joint(orbident: Orbident, tmp_path: Path):
    """A slide: it never turns what it carries."""
    text = urdf(
        link("base", *BASE), link("a"), joint("j", "base", "a", kind="prismatic")
    )
    Whole(orbident, robot_file(tmp_path, text)).check()


def test_no_joint(orbident: Orbident, tmp_path: Path):
    """A rigid body shows its inertia and the place of its CM, but never its mass."""
    whole = Whole(orbident, robot_file(tmp_path, urdf(link("base", *BASE)), WHEELS))
    assert whole.inspected["joints"] == []
    assert whole.inspected["count"] == {"pi": 6, "phi": 3, "base": 10}
    ran = whole.identified(whole.simulated("r.csv"))
    assert ran.status == 1
    assert ran.json["status"] == "rejected"
    assert ran.json["mass"]["value"] is None
    assert "weigh the robot" in ran.err
    for name in ("pi", "phi"):
        assert missing(ran.json[name]) == ran.json[name]["names"]
        kept = ran.json["diagnostics"][name]
        assert missing(kept) == []
        assert worst_error(kept, whole.inspected[name]) < EXACT
    other = whole.simulated("other.csv", seed=3)
    orbident("validate", "run", other).refused("is refused", "weigh the robot")


def test_planar_with_a_slide(orbident: Orbident, tmp_path: Path):
    text = urdf(
        link("base", *BASE),
        link("a"),
        link("b"),
        joint("turn", "base", "a"),
        joint("slide", "a", "b", kind="prismatic", axis=(0.6, 0.8, 0)),
    )
    lines = "motion: planar\nwheels: [{name: rw, axis: [0, 0, 1], inertia: 0.02}]\n"
    Whole(orbident, robot_file(tmp_path, text, lines)).check("spun up", duration=20.0)


@pytest.mark.slow
@pytest.mark.parametrize("wheels", [1, 3])
@needs_shared
def test_astrobee(orbident: Orbident, tmp_path: Path, wheels: int):
    """NASA's Astrobee with its perching arm. It has no wheels: these are added."""
    lines = f"urdf: {SHARED}/astrobee/astrobee_perching_arm_iss.urdf\nwheels:\n"
    for axis, name in list(zip(np.eye(3).tolist(), "xyz", strict=True))[-wheels:]:
        lines += f"  - {{name: rw_{name}, axis: {axis}, inertia: 0.002}}\n"
    path = tmp_path / "astrobee.yaml"
    path.write_text(f"schema: orbident/robot/1\nname: astrobee\n{lines}")
    whole = Whole(orbident, path)
    # Its fingers move by 0.35 rad only: rounding times a condition number of 4e7.
    result = whole.check(exact=1e-7, wheel_speed=250.0)
    assert result["mass"]["value"] == pytest.approx(whole.robot.mass, rel=1e-6)


@needs_shared
def test_astrobee_without_wheels(orbident: Orbident):
    whole = Whole(orbident, SHARED / "astrobee" / "astrobee_perching_arm_iss.urdf")
    ran = whole.identified(whole.simulated("r.csv"))
    assert ran.status == 1
    assert ran.json["mass"]["value"] is None
    assert missing(ran.json["pi"]) == ran.json["pi"]["names"]
    kept = ran.json["diagnostics"]
    assert missing(kept["phi"]) == []
    assert worst_error(kept["phi"], whole.inspected["phi"]) < EXACT
    assert "pi has no scale: the robot has no reaction wheel" in ran.err
    assert json.loads(Path("run/result.json").read_text())["status"] == "rejected"


@needs_shared
def test_cbk_planar(orbident: Orbident, tmp_path: Path):
    """CBK PAN's air-bearing robot, with a wheel added."""
    path = tmp_path / "cbk.yaml"
    path.write_text(
        "schema: orbident/robot/1\nname: cbk\nmotion: planar\n"
        f"urdf: {SHARED}/cbk_planar/cbk_planar_from_table.urdf\n"
        "wheels: [{name: rw, axis: [0, 0, 1], inertia: 0.02}]\n"
    )
    Whole(orbident, path).check("spun up", duration=20.0)


@pytest.mark.slow
def test_the_run_keeps_the_robot(orbident: Orbident, tmp_path: Path):
    """A RUN is complete: it predicts when the robot's own files have gone."""
    whole = Whole(orbident, robot_file(tmp_path, ARM))
    whole.check()
    Path("servicer.yaml").unlink()
    Path("servicer.urdf").unlink()
    orbident("validate", "run", "other.csv").done()
    orbident("inspect", "run/robot.yaml").done()
    orbident("inspect", "run").refused("run: is a folder; give run/robot.yaml")
