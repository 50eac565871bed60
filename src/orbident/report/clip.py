"""A recorded motion as a moving picture; neither a browser nor a screen is needed.

Robots are seen in parallel projection, with the system CM at rest. The faces of each
are drawn from the farthest to the nearest, and the measured robot last: what is seen of
a ghost is by how much its prediction is off.
"""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.report.drawing import Drawing, Image, PolyCollection
from orbident.scene.replay import FramePoses, Replay, with_resting_cm
from orbident.scene.scene import Scene, view_axes
from orbident.scene.shapes import BASE, CAD, IDENTIFIED, Colour, coarse

FRAMES = 100
"""The most frames of a clip: half as many already show a smooth motion."""
FRAME, LAST = 100, 2000
"""How long a frame is shown, and the last one, ms."""
WIDTH, HEIGHT = 640, 480
"""Pixels."""
BELOW = 0.83
"""The part of a picture's height that the robot has; words are above it."""
FINER = 2
"""A picture is drawn so many times larger, and averaged: no gaps between faces."""
MOST_VERTICES = 5000
"""The most vertices of a robot, so that a clip takes half a minute at most: boxes stand
for its finest shapes."""
AMBIENT = 0.55
"""How light a face is that is seen edge-on, where one that faces the eye has one."""
FINEST = 0.2
"""No edge is longer than this part of the largest shape: a face is near or far as a
whole."""


class _Actor(NamedTuple):
    """A robot that moves: its legend, its colour if it is a ghost, and where it is."""

    words: str
    colour: Colour | None
    at: FramePoses


def check_clip(path: Path) -> None:
    """Refuse a name before the work is done.

    Raises:
        InputError: it does not end in .gif.
    """
    if path.suffix.lower() != ".gif":
        raise InputError(f"{path}: the name of a clip ends in .gif")


def write_clip(
    scene: Scene,
    replay: Replay,
    path: Path,
    progress: Callable[[float], object] = lambda done: None,
) -> int:
    """Draw the measured robot, and its ghosts where there are such, as a GIF.

    An existing file is replaced; the part that is done is told meanwhile, and how many
    frames it has at the end.

    Raises:
        InputError: it cannot be written there.
    """
    replay = replay.thinned(FRAMES)
    t, stage = replay.measured.t, _Stage(scene, replay)
    pictures = []
    for k, time in enumerate(t):
        pictures.append(stage.picture(k, f"{time - t[0]:.2f} s"))
        progress((k + 1) / t.size)
    lasts = [FRAME] * (len(pictures) - 1) + [LAST]
    with replacing(path) as target:
        first, *others = pictures
        first.save(
            target,
            format="gif",
            save_all=True,
            append_images=others,
            duration=lasts,
            loop=0,
        )
    return len(pictures)


class _Stage:
    """What is drawn, and the drawing that is used for one frame after another."""

    def __init__(self, scene: Scene, replay: Replay) -> None:
        sizes = np.sort([len(shape.vertices) for shape in scene.shapes])
        most = int(sizes[np.cumsum(sizes) <= MOST_VERTICES].max(initial=0))
        shapes = [coarse(shape, most) for shape in scene.shapes]
        reach = max(float(np.abs(shape.vertices).max()) for shape in shapes) or 1.0
        # The frame of each shape, its colour and its faces.
        self._shapes = [
            (s.frame, s.colour, reach * split(s.vertices[s.faces] / reach, FINEST))
            for s in shapes
        ]
        self._axes = view_axes(scene.eye)
        robot, model = scene.robot, replay.model or scene.robot
        self._actors = [
            _Actor(words, colour, with_resting_cm(scene, motion, by))
            for words, colour, motion, by in (
                ("as CAD predicts", CAD, replay.by_cad, robot),
                ("as identified", IDENTIFIED, replay.predicted, model),
                ("measured", None, replay.measured, model),
            )
            if motion
        ]
        self._drawing = Drawing(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100 * FINER)
        axes = self._drawing.add_axes((0, 0, 1, BELOW), aspect="equal")
        axes.set_axis_off()
        low, high = self._ends()
        room = 0.05 * (high - low).max()
        axes.set_xlim(low[0] - room, high[0] + room)
        axes.set_ylim(low[1] - room, high[1] + room)
        self._drawn = PolyCollection([], antialiaseds=False, linewidths=0)
        axes.add_collection(self._drawn)
        for row, (words, colour, _) in enumerate(reversed(self._actors)):
            r, g, b = colour or BASE
            y, look = 0.96 - 0.05 * row, (r / 255, g / 255, b / 255)
            self._drawing.text(0.02, y, "\N{BLACK SQUARE}", color=look, va="center")
            self._drawing.text(0.05, y, words, va="center")
        self._time = self._drawing.text(0.98, 0.96, "", ha="right", va="center")

    def _ends(self) -> Float[np.ndarray, "2 2"]:
        """How far the robots come at any time: left and below, right and above, m."""
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for actor in self._actors:
            for k in range(len(actor.at.p)):
                seen = self._seen(actor, k)[..., :2].reshape(-1, 2)
                low = np.minimum(low, seen.min(axis=0))
                high = np.maximum(high, seen.max(axis=0))
        return np.array([low, high])

    def picture(self, k: int, words: str) -> Image.Image:
        """The frame `k`, with these words."""
        triangles, colours = [], []
        for actor in self._actors:
            seen = self._seen(actor, k)
            order = np.argsort(seen[..., 2].mean(axis=1))
            painted = [[actor.colour or own] * len(f) for _, own, f in self._shapes]
            light = np.vstack(painted) / 255 * _light(seen)[:, None]
            triangles.append(seen[order, :, :2])
            colours.append(light[order])
        self._drawn.set(verts=np.vstack(triangles), facecolor=np.vstack(colours))
        self._time.set_text(words)
        pixels = BytesIO()
        self._drawing.savefig(pixels, format="rgba")
        size = FINER * WIDTH, FINER * HEIGHT
        drawn = Image.frombytes("RGBA", size, pixels.getvalue())
        return drawn.convert("RGB").reduce(FINER)

    def _seen(self, actor: _Actor, k: int) -> Float[np.ndarray, "faces 3 3"]:
        """The faces of a robot: to the right, up, and towards the eye, m."""
        R, p = actor.at.R[k], actor.at.p[k]
        seen = (
            (faces @ R[frame].T + p[frame]) @ self._axes
            for frame, _, faces in self._shapes
        )
        return np.vstack([*seen])


def split(
    triangles: Float[np.ndarray, "f 3 3"], longest: float
) -> Float[np.ndarray, "g 3 3"]:
    """Halve triangles at their longest edges until none is longer than this."""
    while True:
        lengths = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        long = lengths.max(axis=1) > longest
        if not long.any():
            return triangles
        # From a to b is the longest edge.
        turned = (lengths[long].argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(
            np.take_along_axis(triangles[long], turned[..., None], axis=1), 1, 0
        )
        middle = (a + b) / 2
        halves = [np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)]
        triangles = np.concatenate([triangles[~long], *halves])


def _light(triangles: Float[np.ndarray, "f 3 3"]) -> Float[np.ndarray, " f"]:
    """How light faces are, as they turn to the eye; one without area is dark."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1)
    facing = np.abs(across[:, 2]) / np.where(area > 0, area, 1.0)
    return AMBIENT + (1 - AMBIENT) * facing
