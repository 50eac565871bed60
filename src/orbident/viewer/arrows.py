"""The system CM and the momentum vectors at it."""

from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.scene.motion_history import CentroidalMomentum
from orbident.scene.shapes import Colour

LONGEST = 1.1
"""Length of the longest arrow, of the size: it must come out of the robot."""
SHORTEST = 0.02
"""Shorter ones are not drawn."""

TOTAL: Colour = (40, 40, 40)
BODIES: Colour = (68, 119, 170)
WHEELS: Colour = (238, 119, 51)
LINEAR: Colour = (34, 136, 51)


class Arrows:
    """Angular momentum about the CM, in all and in parts, and linear momentum."""

    def __init__(self, server: Any, momentum: CentroidalMomentum, size: float):
        """Nothing is drawn yet.

        Args:
            server: viser's.
            momentum: over time, inertial axes.
            size: how far the robot reaches, m.
        """
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

    def place(self, k: int, origin: Float[np.ndarray, "3"]) -> None:
        """As at the time `k`, seen from `origin`."""
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
        lines = [
            f'<div><span style="color:rgb{colour}">&#9650;</span> {text}</div>'
            for colour, text in rows
        ]
        return f'<div style="font-size:0.8em;padding:0 1em">{"".join(lines)}</div>'


def _longest(vectors: Float[np.ndarray, "n 3"]) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())
