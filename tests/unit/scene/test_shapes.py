"""Shapes are closed, face outwards, and are as large as they should be."""

import numpy as np
import pytest
import trimesh

from orbident.scene.shapes import BASE, SIDES, Shape, box, cylinder, rod, sphere

SIZE = np.array([0.3, 0.5, 0.7])
# A regular polygon instead of a circle.
ROUND = SIDES / (2 * np.pi) * np.sin(2 * np.pi / SIDES)


def solid(shape: Shape) -> trimesh.Trimesh:
    return trimesh.Trimesh(shape.vertices, shape.faces)


@pytest.mark.parametrize(
    ("shape", "volume", "off"),
    [
        (box(SIZE, BASE), SIZE.prod(), 1e-12),
        (cylinder(0.2, 0.7, BASE), ROUND * np.pi * 0.2**2 * 0.7, 1e-12),
        # 512 flat faces lie inside of the sphere.
        (sphere(0.4, BASE), 4 / 3 * np.pi * 0.4**3, 0.05),
        (
            rod(np.zeros(3), np.array([0.1, -0.2, 0.2]), 0.05, BASE),
            ROUND * np.pi * 0.05**2 * 0.3,
            1e-12,
        ),
    ],
)
def test_closed_outwards_and_of_that_volume(shape: Shape, volume: float, off: float):
    mesh = solid(shape)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    # Positive, and so facing outwards.
    assert mesh.volume == pytest.approx(volume, rel=off)


@pytest.mark.parametrize(
    "end", [(0, 0, 0.3), (0, 0, -0.3), (0.1, 0.2, 0.2), (-1, 0, 0)]
)
def test_a_rod_ends_where_it_should(end: tuple[float, float, float]):
    shape = rod(np.zeros(3), np.array(end, float), 0.01, BASE)
    # The middle of the last end is the last vertex.
    assert np.allclose(shape.vertices[-1], end, atol=1e-12)
    assert np.allclose(shape.vertices[-2], 0.0, atol=1e-12)
