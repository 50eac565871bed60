"""What a page shows: the robot of a scene, what is around it, and plots beside it."""

import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.scene.replay import CentroidalMomentum, InertiaEllipsoids
from orbident.scene.scene import Scene
from orbident.scene.shapes import FAINT, Colour

CELLS = 40
"""Cells of the floor, in each direction."""


class Floor:
    """A floor that shows where the page's origin is in the inertial frame."""

    def __init__(
        self,
        server: Any,
        scene: Scene,
        R: Float[np.ndarray, "frames 3 3"],
        p: Float[np.ndarray, "frames 3"],
    ):
        """Set it up for a robot whose frames are at `R` and `p`, page axes, m."""
        planar = scene.robot.motion == "planar"
        points = np.vstack(
            [s.vertices @ R[s.frame].T + p[s.frame] for s in scene.shapes]
        )
        self.size = size = float(np.linalg.norm(points, axis=1).max())
        self._cell = 0.5 * 10 ** np.round(np.log10(size))
        # A table is where the robot stands; in space nothing may cut through it.
        self._height = float(points[:, 2].min()) if planar else -1.5 * size
        self._grid = server.scene.add_grid(
            "/floor",
            width=CELLS * self._cell,
            height=CELLS * self._cell,
            cell_size=self._cell,
            section_size=5 * self._cell,
            cell_color=(225, 225, 225),
            section_color=(200, 200, 200),
            position=(0.0, 0.0, self._height),
        )
        server.scene.set_up_direction("+z")
        camera = server.initial_camera
        camera.position = 2.2 * size * scene.eye
        camera.look_at = np.zeros(3)

    def move_to(self, origin: Float[np.ndarray, "3"]) -> None:
        """Let the floor pass by under an origin that moves so, m."""
        passed = np.mod(origin[:2], 5 * self._cell)
        self._grid.position = (-passed[0], -passed[1], self._height)


def heading(server: Any, title: str, *lines: str) -> None:
    """A title and some lines in the panel, shown as they are."""
    words = "".join(f"<div>{html.escape(line)}</div>" for line in lines)
    server.gui.add_html(
        '<div style="padding:0.5em 1em;font-size:0.85em;overflow-wrap:anywhere;'
        f'max-height:12em;overflow-y:auto"><b>{html.escape(title)}</b>{words}</div>'
    )


class DrawnRobot:
    """The frames of a scene, with their shapes; they move as one."""

    def __init__(
        self, server: Any, name: str, scene: Scene, ghost: Colour | None = None
    ):
        """Draw it at the origin, under a name of its own; a ghost is transparent."""
        self._root = server.scene.add_frame(name, show_axes=False)
        self._frames, self._names = [], []
        for k, words in enumerate((*scene.robot.bodies, *scene.robot.wheel_names)):
            at = f"{name}/{k}"
            self._frames.append(server.scene.add_frame(at, show_axes=False))
            label = server.scene.add_label(f"{at}/name", words, visible=False)
            self._names.append(label)
        for k, shape in enumerate(scene.shapes):
            server.scene.add_mesh_simple(
                f"{name}/{shape.frame}/{k}",
                shape.vertices,
                shape.faces,
                color=ghost or shape.colour,
                opacity=FAINT if ghost else None,
                flat_shading=True,
                side="double",
            )

    def move_to(
        self, R: Float[np.ndarray, "frames 3 3"], p: Float[np.ndarray, "frames 3"]
    ) -> None:
        """Put every frame there, page axes, m."""
        quaternions = Rotation.from_matrix(R).as_quat(scalar_first=True)
        for frame, x, at in zip(self._frames, quaternions, p, strict=True):
            frame.wxyz, frame.position = x, at

    def show(self, visible: bool) -> None:
        """Show the robot, or hide it."""
        self._root.visible = visible

    def show_names(self, visible: bool) -> None:
        """Show the names of bodies and wheels, or hide them."""
        for name in self._names:
            name.visible = visible


class Ellipsoid:
    """The system's inertia, as an ellipsoid of even density; hidden at first."""

    def __init__(
        self,
        server: Any,
        name: str,
        inertia: InertiaEllipsoids,
        colour: Colour,
        wireframe: bool = False,
    ):
        """Draw a ball that the inertia stretches, over time, inertial frame."""
        self._inertia = inertia
        self._x = Rotation.from_matrix(inertia.R).as_quat(scalar_first=True)
        self._ball = server.scene.add_icosphere(
            name, color=colour, opacity=FAINT, wireframe=wireframe, visible=False
        )

    def move_to(self, k: int, origin: Float[np.ndarray, "3"]) -> None:
        """Show it as it is at the time `k`, seen from `origin`."""
        self._ball.wxyz = self._x[k]
        self._ball.position = self._inertia.r_cm[k] - origin
        self._ball.scale = tuple(self._inertia.lengths[k].tolist())

    def show(self, visible: bool) -> None:
        """Or hide."""
        self._ball.visible = visible


LONGEST = 1.1
"""Length of the longest arrow, of the size: it must come out of the robot."""
SHORTEST = 0.02
"""Shorter ones are not drawn."""

TOTAL: Colour = (118, 118, 118)
BODIES: Colour = (68, 119, 170)
WHEELS: Colour = (238, 119, 51)
LINEAR: Colour = (34, 136, 51)


class Arrows:
    """Angular momentum about the CM, in all and in parts, and linear momentum."""

    def __init__(self, server: Any, momentum: CentroidalMomentum, size: float):
        """Take momenta over time, inertial axes, and how far the robot is, m."""
        self._size, self._cm = size, momentum.r_cm
        angular = [momentum.h_rs + momentum.h_rw, momentum.h_rs, momentum.h_rw]
        self._longest = max(_longest(h) for h in angular), _longest(momentum.p)
        unit = [LONGEST * size / (largest or 1.0) for largest in self._longest]
        scaled = [*(h * unit[0] for h in angular), momentum.p * unit[1]]
        self._arrows = np.stack(scaled, axis=1)
        self._colours = np.array([TOTAL, BODIES, WHEELS, LINEAR])
        self._ball = server.scene.add_icosphere("/cm", 0.03 * size, color=TOTAL)
        self._handle = server.scene.add_arrows(
            "/momentum",
            np.zeros((0, 2, 3)),
            np.zeros((0, 3), np.uint8),
            shaft_radius=0.012 * size,
            head_radius=0.03 * size,
            head_length=0.08 * size,
        )

    def move_to(self, k: int, origin: Float[np.ndarray, "3"]) -> None:
        """Show it as it is at the time `k`, seen from `origin`."""
        at = self._cm[k] - origin
        long = np.linalg.norm(self._arrows[k], axis=1) > SHORTEST * self._size
        ends = at + self._arrows[k][long]
        self._ball.position = at
        self._handle.points = np.stack([np.broadcast_to(at, ends.shape), ends], axis=1)
        self._handle.colors = self._colours[long].astype(np.uint8)

    def show(self, visible: bool) -> None:
        """Or hide."""
        self._ball.visible = self._handle.visible = visible

    def legend(self) -> str:
        """What the colours and lengths mean, as HTML."""
        angular, linear = self._longest
        rows = [
            (TOTAL, "angular momentum about the CM"),
            (BODIES, "of which bodies"),
            (WHEELS, f"of which wheels; longest {angular:.3g} N m s"),
            (LINEAR, f"linear momentum; longest {linear:.3g} N s"),
        ]
        return _legend("&#9650;", rows)


def _legend(mark: str, rows: Iterable[tuple[Colour, str]]) -> str:
    lines = [
        f'<div><span style="color:rgb{colour}">{mark}</span> {html.escape(text)}</div>'
        for colour, text in rows
    ]
    return f'<div style="font-size:0.8em;padding:0 1em">{"".join(lines)}</div>'


def _longest(vectors: Float[np.ndarray, "n 3"]) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


MOST_POINTS = 400
"""Most points of a curve: the panel is not wider."""

TRAILS: tuple[Colour, ...] = ((170, 51, 119), TOTAL, (153, 153, 51))
"""Colours of trails in turn."""


class Trails:
    """Where points have been up to now, as lines; hidden at first."""

    def __init__(self, server: Any, paths: Mapping[str, Float[np.ndarray, "n 3"]]):
        """Take paths of points by their names, inertial frame, m."""
        self._paths = tuple(paths.values())
        n = len(self._paths[0])
        self._chosen = np.arange(0, n, -(-n // MOST_POINTS))
        colours = [TRAILS[k % len(TRAILS)] for k in range(len(paths))]
        self._rows = list(zip(colours, paths, strict=True))
        self._lines = [
            server.scene.add_line_segments(
                f"/trails/{k}",
                np.zeros((0, 2, 3)),
                colour,
                thickness=3.0,
                thickness_units="screen",
                visible=False,
            )
            for k, colour in enumerate(colours)
        ]

    def move_to(self, k: int, origin: Float[np.ndarray, "3"]) -> None:
        """Show them up to the time `k`, seen from `origin`."""
        passed = np.append(self._chosen[self._chosen < k], k)
        for line, path in zip(self._lines, self._paths, strict=True):
            points = path[passed] - origin
            line.points = np.stack([points[:-1], points[1:]], axis=1)

    def show(self, visible: bool) -> None:
        """Or hide."""
        for line in self._lines:
            line.visible = visible

    def legend(self) -> str:
        """Which colour is which point's, as HTML."""
        return _legend("&#9644;", self._rows)


COLOURS = ("#ee6677", "#228833", "#4477aa", "#aa3377", "#ccbb44", "#66ccee")
NOW = "#767676"
"""Grey that is seen on a light page and on a dark one."""


class Plot:
    """Some curves, predicted ones dashed, and the present time."""

    def __init__(
        self,
        server: Any,
        title: str,
        t: Float[np.ndarray, " n"],
        curves: Float[np.ndarray, "n k"],
        names: Sequence[str],
        dashed: Float[np.ndarray, "n k"] | None = None,
    ):
        """Draw a curve a column over `t`, s; predicted ones are dashed."""
        self.title = title
        columns = curves if dashed is None else np.hstack([curves, dashed])
        chosen = np.arange(0, t.size, -(-t.size // MOST_POINTS))
        self._t = t[chosen]
        self._columns = [np.array(column) for column in columns[chosen].T]
        looks = [{"stroke": _colour(k), "width": 1.5} for k in range(len(names))]
        faint = [{**look, "dash": (6, 4)} for look in looks]
        series = [{}, *looks, *(faint if dashed is not None else ()), {"stroke": NOW}]
        low, high = float(np.nanmin(columns)), float(np.nanmax(columns))
        room = 0.05 * (high - low) or 1.0
        self._ends = low - room, high + room
        words = "dashed: predicted" if dashed is not None else ""
        server.gui.add_html(_caption(title, names, words))
        self._handle = server.gui.add_uplot(
            self._data(0),
            tuple(series),
            scales={"x": {"time": False}, "y": {"range": self._ends}},
            legend={"show": False},
            height=150,
            padding=(10, 16, 0, 14),
        )

    def move_to(self, t: float) -> None:
        """Move the line there, s."""
        self._handle.data = self._data(int(np.searchsorted(self._t, t)))

    def _data(self, k: int) -> tuple[Float[np.ndarray, " n"], ...]:
        # From the lower end at one sample to the upper one at the next: upright, but
        # for the width of a pixel.
        now = np.full(self._t.size, np.nan)
        k = min(k, self._t.size - 2)
        now[k : k + 2] = self._ends
        return (self._t, *self._columns, now)


def _colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]


def _caption(title: str, names: Sequence[str], words: str) -> str:
    listed = " ".join(
        f'<span style="color:{_colour(k)}">&#9632;</span>&nbsp;{html.escape(name)}'
        for k, name in enumerate(names)
    )
    return (
        '<div style="font-size:0.8em;padding:0 1em;overflow-wrap:anywhere">'
        f"<b>{html.escape(title)}</b> {listed} {words}</div>"
    )
