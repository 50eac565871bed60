"""Every block of the README and of the site runs, or at least could."""

import sys
from pathlib import Path
from typing import Any

import jaxtyping
import pytest
import typer
from pages import PAGES, Block, blocks, commands, name_of
from random_motions import random_motion

from orbident.cli.app import main
from orbident.cli.verbs import app
from orbident.recordings.tables import write_recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.measure import measure
from orbident.simulation.simulate import float_along, simulate
from orbident.studies.spatial import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory_file import save_trajectory

RUN = {"python", "bash"}
RUNNING = [page for page in PAGES if any(b.language in RUN for b in blocks(page))]
SHOWN = [page for page in PAGES if any(b.language == "sh" for b in blocks(page))]


def spatial_study() -> None:
    """What `orbident study spatial -o spatial` leaves."""
    robot = spatial_robot()
    trajectory = spatial_trajectory(robot)
    Path("spatial").mkdir()
    save_trajectory(trajectory, Path("spatial/trajectory.yaml"))
    write_recording(simulate(robot, trajectory), "spatial/recording.csv")


def three_flights() -> None:
    """Write three recordings of the robot on its table, each with noise of its own."""
    robot = load_robot("cepheus-like")
    trajectory = random_motion(robot, 1, 20.0, 50.0, "spun up")
    motion = float_along(robot, trajectory, robot.sensors["rate"])
    for seed, name in enumerate(("first", "second", "third")):
        write_recording(measure(robot, motion, trajectory, seed), f"{name}.csv")


BEFORE = {
    "README.md": spatial_study,
    "docs/how-to/several-recordings.md": three_flights,
}
"""What makes the files that a page's reader has already, by page."""


@pytest.mark.parametrize("page", RUNNING, ids=name_of)
def test_the_page_runs(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    # As installed: in tests a wrong shape is refused before the command can see it.
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)
    BEFORE.get(name_of(page), lambda: None)()
    names = {"__name__": "__main__"}
    for block in blocks(page):
        if block.title:
            (tmp_path / block.title).write_text(block.text)
        elif block.language == "python":
            code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
            exec(code, names)
        elif block.language == "bash":
            for words in commands(block):
                assert words[0] == "orbident", f"{page}:{block.line}: use sh for others"
                monkeypatch.setattr(sys, "argv", words)
                with pytest.raises(SystemExit) as ended:
                    main()
                said = capsys.readouterr().err
                assert ended.value.code == 0, f"{page}:{block.line}: {words}: {said}"


@pytest.mark.parametrize("page", SHOWN, ids=name_of)
def test_shown_commands_are_right(page: Path):
    group = typer.main.get_command(app)
    for block in blocks(page):
        if block.language == "sh":
            for words in commands(block):
                if words[0] == "orbident":
                    check(group, words[1:], block, page)


def check(group: Any, words: list[str], block: Block, page: Path) -> None:
    try:
        with group.make_context("orbident", list(words)) as context:
            name, verb, rest = group.resolve_command(context, words)
            verb.make_context(name, rest, parent=context)
    except Exception as error:
        raise AssertionError(f"{page}:{block.line}: {words}: {error}") from error
