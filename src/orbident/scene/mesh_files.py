"""Meshes that a URDF names: where their files are, and what is in them."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

MOST_BYTES = 50_000_000
"""A larger file is no picture of a link but a survey of it."""

Mesh = tuple[Float[np.ndarray, "v 3"], Int[np.ndarray, "f 3"]]


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file that a URDF in this folder means; None where there is none.

    `package://PACKAGE/PATH` is looked for beside every folder above, as a workspace
    has it, and in a folder above that is the package itself.
    """
    prefix = "package://"
    if not name.startswith(prefix):
        return _existing(folder / name.removeprefix("file://"))
    package, _, path = name.removeprefix(prefix).partition("/")
    for above in (folder, *folder.absolute().parents):
        beside = _existing(above / package / path)
        inside = _existing(above / path) if above.name == package else None
        if beside or inside:
            return beside or inside
    return None


def _existing(path: Path) -> Path | None:
    try:
        usable = path.is_file() and path.stat().st_size <= MOST_BYTES
    except (OSError, ValueError):
        return None
    return path if usable else None


def read_mesh(path: Path) -> Mesh | None:
    """Vertices and triangles; None where the file cannot be read as a mesh."""
    # Late: the import takes most of a second.
    import trimesh

    try:
        mesh = trimesh.load_mesh(path)
        if isinstance(mesh, trimesh.Scene):
            mesh = mesh.to_mesh()
        vertices, faces = np.array(mesh.vertices, float), np.array(mesh.faces, int)
    except Exception:
        # Of any kind: each of its many readers has its own, for what it trips over.
        return None
    if not len(faces) or not np.isfinite(vertices).all():
        return None
    return vertices, faces
