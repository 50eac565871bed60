"""What stands around the robot: floor, light and camera."""

import html
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.scene.scene import Scene

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
        """Set it up for a robot that stands there so.

        Args:
            server: viser's.
            scene: of the robot.
            R: of its frames, page axes.
            p: of its frames, m.
        """
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
        camera.position = 2.2 * size * np.array([0.6, -0.8, 1.0 if planar else 0.5])
        camera.look_at = np.zeros(3)

    def place(self, origin: Float[np.ndarray, "3"]) -> None:
        """Let the floor pass by under an origin that moves so, m."""
        passed = np.mod(origin[:2], 5 * self._cell)
        self._grid.position = (-passed[0], -passed[1], self._height)


def heading(server: Any, title: str, *lines: str) -> None:
    """A title and some lines in the panel, shown as they are.

    Args:
        server: viser's.
        title: the first line; names may be as long as they like.
        lines: below it.
    """
    words = "".join(f"<div>{html.escape(line)}</div>" for line in lines)
    server.gui.add_html(
        '<div style="padding:0.5em 1em;font-size:0.85em;overflow-wrap:anywhere;'
        f'max-height:12em;overflow-y:auto"><b>{html.escape(title)}</b>{words}</div>'
    )
