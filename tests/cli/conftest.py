"""The command run in this process, and recordings that many tests share."""

import sys
from pathlib import Path

import jaxtyping
import pytest
from random_motions import random_motion
from running import Orbident, Ran

from orbident.cli.app import main
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.spatial import paper_case
from orbident.trajectories.trajectory_file import save_trajectory


@pytest.fixture
def orbident(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Orbident:
    """Runs the command: `orbident("inspect", "dual-arm")`."""

    # As installed: in tests a wrong shape is refused before the command can see it.
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)

    def run(*arguments: object) -> Ran:
        monkeypatch.setattr(sys, "argv", ["orbident", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as exited:
            main()
        captured = capsys.readouterr()
        assert isinstance(exited.value.code, int)
        return Ran(exited.value.code, captured.out, captured.err)

    return run


@pytest.fixture(scope="session")
def flight() -> Recording:
    """`paper-spatial`, all columns, no noise: 40 s at 20 Hz."""
    robot = load_robot("paper-spatial")
    return simulate(robot, random_motion(robot))


@pytest.fixture(scope="session")
def table_run() -> Recording:
    """`cepheus-like`, which was at rest before its wheel spun up: 10 s at 100 Hz."""
    robot = load_robot("cepheus-like")
    return simulate(robot, random_motion(robot, duration=10.0, start="spun up"))


@pytest.fixture(autouse=True)
def _inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Relative paths are inside the test's own folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def table_5(tmp_path: Path) -> Path:
    """The paper's trajectory of its planar robot, as a file."""
    path = tmp_path / "table5.yaml"
    save_trajectory(paper_case(load_robot("cepheus-like")).trajectory, path)
    return path
