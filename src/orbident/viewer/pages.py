"""Which page belongs to what the user names."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.run_folder import load_result
from orbident.model.regularity import check_regular
from orbident.recordings.tables import read_recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import predicted_motion, recorded_motion
from orbident.scene.scene import Scene, scene_of
from orbident.viewer.replay_page import ReplayPage
from orbident.viewer.server import Page
from orbident.viewer.sliders_page import SlidersPage


class Prepared(NamedTuple):
    """A page that only needs a server."""

    page: Callable[[Any], Page]
    warnings: tuple[str, ...]


def prepared(shown: str, recording: Path | None) -> Prepared:
    """The page for a robot or a RUN.

    Args:
        shown: a bundled name, a URDF, a robot file, or a RUN folder.
        recording: to be replayed; without one the joints have sliders.

    Raises:
        InputError: what is named cannot be read; the recording lacks what a replay
            needs; without a recording, a RUN does not determine a model, or a
            mass matrix is singular.
    """
    if Path(shown).is_dir():
        result = load_result(Path(shown))
        robot, scene = result.robot, scene_of(result.robot, Path(shown))
        model = partial(_identified, result, shown)
        replayed = partial(predicted_motion, result)
    else:
        robot = load_robot(shown)
        scene = scene_of(robot, _folder(shown, robot))
        model, replayed = partial(_nominal, robot), partial(recorded_motion, robot)
    if recording is None:
        title = robot.name if shown == robot.name else f"{robot.name}: {shown}"
        page = partial(SlidersPage, scene=scene, model=model(), title=title)
        return Prepared(page, _missing(scene))
    replay = replayed(read_recording(recording))
    title = f"{robot.name}: {recording}"
    page = partial(ReplayPage, scene=scene, replay=replay, title=title)
    return Prepared(page, (*_missing(scene), *replay.warnings))


def _nominal(robot: Robot) -> Robot:
    check_regular(robot)
    return robot


def _identified(result: Result, shown: str) -> Robot:
    try:
        return result.dynamics().robot
    except InputError as error:
        raise InputError(
            f"{error}; give --recording to see the measured motion, or "
            f"{shown}/robot.yaml for the CAD model"
        ) from error


def _folder(shown: str, robot: Robot) -> Path | None:
    """The folder of the robot's model, where it came from a file."""
    path = Path(shown)
    if not path.is_file():
        return None
    model = robot.document.get("model") or robot.document.get("urdf") or ""
    return (path.parent / model).parent


def _missing(scene: Scene) -> tuple[str, ...]:
    if not scene.missing:
        return ()
    if scene.refusal:
        return (f"{scene.refusal}; collision shapes or boxes stand for all meshes",)
    listed = ", ".join(name.rsplit("/", 1)[-1] for name in scene.missing[:3])
    more = ", .." * (len(scene.missing) > 3)
    return (
        f"{len(scene.missing)} meshes are not there, cannot be read or lie outside "
        f"the robot's folder and packages ({listed}{more}); collision shapes or boxes "
        "stand for them",
    )
