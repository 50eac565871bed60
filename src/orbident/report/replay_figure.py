"""A recorded motion as a chart that turns, plays and can be scrubbed."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.replacing import write_text
from orbident.files.text import read_text
from orbident.identified.run_folder import REPLAY
from orbident.recordings.recording import Recording
from orbident.report.charts import Figure, numbers
from orbident.report.page import Chart, Section, report_text
from orbident.robot.description import Robot
from orbident.scene.replay import (
    MotionHistory,
    centroidal_momentum,
    placed,
    recorded_motion,
)
from orbident.scene.scene import Scene, scene_of
from orbident.scene.shapes import Shape, coarse

FRAMES = 40
"""Of the animation."""
MOST_VERTICES = 60
"""Most vertices of a shape; a finer one is shown as the box around it."""


def replay_figure(scene: Scene, motion: MotionHistory) -> Figure:
    """The robot and its angular momentum, about its CM.

    Its nominal inertia gives CM and momentum.
    """
    shown = motion.thinned(FRAMES)
    at = placed(scene, shown, np.zeros_like(shown.qd_rw))
    found = centroidal_momentum(scene.robot, shown)
    shapes = [coarse(shape, MOST_VERTICES) for shape in scene.shapes]
    p = at.p - found.r_cm[:, None]
    points = np.concatenate(
        [s.vertices @ at.R[:, s.frame].mT + p[:, s.frame, None] for s in shapes], axis=1
    )
    h = found.h_rs + found.h_rw
    longest = np.linalg.norm(h, axis=1).max() or 1.0
    reach = float(np.abs(points).max())
    arrows = 0.7 * reach / longest * h
    frames = [
        {"name": str(k), "data": [_at(points[k]), _arrow(arrows[k])], "traces": [0, 1]}
        for k in range(shown.t.size)
    ]
    figure = json.loads(report_text("replay.json"))
    body, arrow = figure["data"]
    body |= {**_faces(shapes), **_at(points[0])}
    arrow |= _arrow(arrows[0])
    layout = figure["layout"]
    for axis in "xyz":
        layout["scene"][f"{axis}axis"]["range"] = [-1.05 * reach, 1.05 * reach]
    layout["sliders"][0]["steps"] = [_step(k, time) for k, time in enumerate(shown.t)]
    return {**figure, "frames": frames}


def _faces(shapes: list[Shape]) -> dict[str, Any]:
    """Which vertices make a face, and of which colour."""
    first = np.cumsum([0, *(len(shape.vertices) for shape in shapes[:-1])])
    faces = np.vstack([s.faces + k for s, k in zip(shapes, first, strict=True)])
    corners = {name: numbers(faces[:, k], "<i4") for k, name in enumerate("ijk")}
    return {**corners, "facecolor": [f"rgb{s.colour}" for s in shapes for _ in s.faces]}


def _at(points: Float[np.ndarray, "v 3"]) -> dict[str, Any]:
    return {name: numbers(points[:, k], "<f4") for k, name in enumerate("xyz")}


def _arrow(end: Float[np.ndarray, "3"]) -> dict[str, Any]:
    return _at(np.vstack([np.zeros(3), end]))


def _step(k: int, time: float) -> dict[str, Any]:
    """A step of the slider, which shows a frame at once."""
    at_once = {
        "mode": "immediate",
        "transition": {"duration": 0},
        "frame": {"duration": 0, "redraw": True},
    }
    return {"label": f"{time:.3g}", "method": "animate", "args": [[str(k)], at_once]}


def write_replay(robot: Robot, recording: Recording, folder: Path) -> None:
    """Keep in a RUN folder what a later report shows of the motion.

    A recording that shows no motion of the whole robot leaves nothing.

    Raises:
        InputError: the folder cannot be written.
    """
    try:
        motion = recorded_motion(robot, recording).measured
    except InputError:
        return
    figure = replay_figure(scene_of(robot), motion)
    write_text(folder / REPLAY, json.dumps(figure, separators=(",", ":")))


def replay_sections(folder: Path) -> list[Section]:
    """The motion that a RUN folder keeps; nothing where it keeps none.

    Raises:
        InputError: its file is damaged.
    """
    path = folder / REPLAY
    if not path.exists():
        return []
    try:
        figure = json.loads(read_text(path))
    except ValueError as error:
        raise InputError(f"{path}: is not JSON ({error}); identify again") from error
    words = (
        "As recorded, about the system CM. Drag to turn, scroll to come closer. With "
        "the predicted motion beside it: orbident view RUN --recording REC."
    )
    chart = Chart("replay", "The motion, inertial axes", figure)
    return [Section("replay", "Replay", words=(words,), charts=(chart,))]
