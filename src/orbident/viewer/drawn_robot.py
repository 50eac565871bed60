"""A scene's robot on the page."""

from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.scene.scene import Scene
from orbident.scene.shapes import Colour

GHOST: Colour = (102, 204, 238)
FAINT = 0.35
"""Opacity of a ghost."""


class DrawnRobot:
    """The frames of a scene, with their shapes; they move as one."""

    def __init__(self, server: Any, name: str, scene: Scene, ghost: bool = False):
        """Draw it, with all frames at the origin.

        Args:
            server: viser's.
            name: of the node above all frames, unlike every other one's.
            scene: what to draw.
            ghost: in one colour, and transparent.
        """
        self._server = server
        self._root = server.scene.add_frame(name, show_axes=False)
        count = len(scene.robot.bodies) + len(scene.robot.wheels)
        self._frames = [
            server.scene.add_frame(f"{name}/{k}", show_axes=False) for k in range(count)
        ]
        for k, shape in enumerate(scene.shapes):
            server.scene.add_mesh_simple(
                f"{name}/{shape.frame}/{k}",
                shape.vertices,
                shape.faces,
                color=GHOST if ghost else shape.colour,
                opacity=FAINT if ghost else None,
                flat_shading=True,
                side="double",
            )

    def place(
        self, R: Float[np.ndarray, "frames 3 3"], p: Float[np.ndarray, "frames 3"]
    ) -> None:
        """Put every frame there, page axes, m."""
        quaternions = Rotation.from_matrix(R).as_quat(scalar_first=True)
        for frame, x, at in zip(self._frames, quaternions, p, strict=True):
            frame.wxyz, frame.position = x, at

    def show(self, visible: bool) -> None:
        """Or hide."""
        self._root.visible = visible
