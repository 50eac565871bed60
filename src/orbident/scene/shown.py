"""What a user names to be shown: a robot, or the RUN folder of an identified one."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.run_folder import load_result
from orbident.model.equations_of_motion import check_regular
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import Replay, compared_motions, recorded_motion
from orbident.scene.scene import Scene, scene_of


class Shown(NamedTuple):
    """A scene, and what moves in it."""

    scene: Scene
    model: Callable[[], Robot]
    """The robot with the inertia that decides how it floats."""
    replay: Callable[[Recording], Replay]


def to_be_shown(named: str) -> Shown:
    """The robot of this name or file, or that of a RUN folder.

    Raises:
        InputError: it cannot be read. `model` raises it where a RUN does not determine
            a model or a mass matrix is singular, `replay` where the recording lacks
            what a replay needs.
    """
    if Path(named).is_dir():
        result = load_result(Path(named))
        return Shown(
            scene_of(result.robot, Path(named)),
            partial(_identified, result, named),
            partial(compared_motions, result),
        )
    robot = load_robot(named)
    return Shown(
        scene_of(robot, _folder(named, robot)),
        partial(_nominal, robot),
        partial(recorded_motion, robot),
    )


def _nominal(robot: Robot) -> Robot:
    check_regular(robot)
    return robot


def _identified(result: Result, named: str) -> Robot:
    try:
        return result.dynamics().robot
    except InputError as error:
        raise InputError(
            f"{error}; give --recording to see the measured motion, or "
            f"{named}/robot.yaml for the CAD model"
        ) from error


def _folder(named: str, robot: Robot) -> Path | None:
    """The folder of the robot's model, where it came from a file."""
    path = Path(named)
    if not path.is_file():
        return None
    model = robot.document.get("model") or robot.document.get("urdf") or ""
    return (path.parent / model).parent
