"""Triangles and their colour: all that a picture of a robot is made of."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

Colour = tuple[int, int, int]

BASE: Colour = (176, 180, 190)
LINKS: tuple[Colour, ...] = ((68, 119, 170), (204, 187, 68), (34, 136, 51))
"""Colours of an arm's links in turn, distinct for the colour-blind too (Tol 2021,
bright)."""
WHEEL: Colour = (70, 70, 78)
MARK: Colour = (238, 102, 119)
"""The colour of what shows that a wheel turns."""

SIDES = 20
"""How many sides a cylinder has that stands for a round one."""


class Shape(NamedTuple):
    """A closed surface, fixed in one frame."""

    frame: int
    """The number of the frame that the shape is fixed in: 0 is the base's, then those
    of the other bodies follow in their order, then those of the wheels."""
    vertices: Float[np.ndarray, "v 3"]
    """Corners of the faces in that frame, m."""
    faces: Int[np.ndarray, "f 3"]
    colour: Colour

    def moved(
        self, frame: int, R: Float[np.ndarray, "3 3"], p: Float[np.ndarray, "3"]
    ) -> "Shape":
        """The same in another frame, in which this one is at `R`, `p`."""
        return self._replace(frame=frame, vertices=self.vertices @ R.T + p)


def box(size: Float[np.ndarray, "3"], colour: Colour) -> Shape:
    """A box about the origin, with these lengths along x, y and z, m."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6)]
    sides += [(0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [[a, b, c] for a, b, c, _ in sides] + [[a, c, d] for a, _, c, d in sides]
    return Shape(0, corners * size / 2, np.array(faces), colour)


def cylinder(radius: float, length: float, colour: Colour) -> Shape:
    """A cylinder about the origin, along z."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = [np.column_stack([circle, np.full(SIDES, z)]) for z in (-1, 1)]
    centres = [[[0.0, 0.0, z]] for z in (-1, 1)]
    vertices = np.vstack([*ends, *centres]) * [1, 1, length / 2]
    k = np.arange(SIDES)
    below, above = k, k + SIDES
    next_below, next_above = (k + 1) % SIDES, (k + 1) % SIDES + SIDES
    bottom, top = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
    faces = [
        np.column_stack([below, next_below, next_above]),
        np.column_stack([below, next_above, above]),
        np.column_stack([bottom, next_below, below]),
        np.column_stack([top, above, next_above]),
    ]
    return Shape(0, vertices, np.vstack(faces), colour)


def sphere(radius: float, colour: Colour) -> Shape:
    """A sphere about the origin: an octahedron, its faces split in four three times."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array(
        [[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)], dtype=int
    )
    # An odd number of negative axes turns a face round.
    flipped = (faces > 2).sum(axis=1) % 2 == 1
    faces[flipped] = faces[flipped][:, ::-1]
    for _ in range(3):
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        corners = np.stack([a, b, c, a + b, b + c, c + a], axis=1).reshape(-1, 3)
        vertices = corners / np.linalg.norm(corners, axis=1, keepdims=True)
        quarter = np.array([[0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5]])
        first = 6 * np.arange(len(a))[:, None, None]
        faces = (first + quarter).reshape(-1, 3)
    return Shape(0, radius * vertices, faces, colour)


def rod(
    start: Float[np.ndarray, "3"],
    end: Float[np.ndarray, "3"],
    radius: float,
    colour: Colour,
) -> Shape:
    """A cylinder from one point to another."""
    along = end - start
    length = float(np.linalg.norm(along))
    straight = cylinder(radius, length, colour)
    return straight.moved(0, z_towards(along / length), (start + end) / 2)


def z_towards(direction: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """A rotation that takes z into this unit vector."""
    side = np.eye(3)[np.argmin(np.abs(direction))]
    x = np.cross(side, direction)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(direction, x), direction])
