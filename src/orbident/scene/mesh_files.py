"""Meshes that a URDF names: where their files are, and what is in them."""

import io
import logging
import zipfile
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from orbident.extras import extra
from orbident.files.bounds import LARGEST

MOST_BYTES = 50_000_000
"""A larger file, or unpacked archive, is no picture of a link but a survey of it."""
KINDS = frozenset({"3mf", "dae", "glb", "gltf", "obj", "off", "ply", "stl", "zae"})
"""Suffixes of meshes; trimesh also reads drawings and archives of anything."""

# What is wrong with a mesh costs this mesh, without trimesh's words about it.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

Mesh = tuple[Float[np.ndarray, "v 3"], Int[np.ndarray, "f 3"]]


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file that a URDF in this folder means; None where there is none.

    A mesh lies in the robot's own folder or in a package, links followed, or it is not
    read: a robot from a stranger names no other file of the user. The package of
    `package://PACKAGE/PATH` is looked for among and beside all folders above, as a
    workspace has it.
    """
    own, prefix = _own_folder(folder), "package://"
    if not name.startswith(prefix):
        return _inside(own, folder / name.removeprefix("file://"))
    package, _, path = name.removeprefix(prefix).partition("/")
    if package in {"", ".", ".."}:
        return None
    above = (folder, *folder.absolute().parents)
    packages = [each / package for each in above if _is_package(each / package)]
    packages += [own] * (own.name == package)
    found = (_inside(each, each / path) for each in packages)
    return next((mesh for mesh in found if mesh), None)


def _own_folder(folder: Path) -> Path:
    """The robot's: the package that holds the URDF, else the folder of the URDF.

    A folder named `urdf` has the meshes beside it, as in a package.
    """
    absolute = folder.absolute()
    package = next((p for p in (absolute, *absolute.parents) if _is_package(p)), None)
    return package or (absolute.parent if absolute.name == "urdf" else absolute)


def _is_package(folder: Path) -> bool:
    try:
        return (folder / "package.xml").is_file()
    except (OSError, ValueError):
        return False


def _inside(folder: Path, path: Path) -> Path | None:
    try:
        usable = path.is_file() and path.stat().st_size <= MOST_BYTES
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return None
    return path if usable and inside else None


def read_mesh(path: Path) -> Mesh | None:
    """Vertices and triangles; None where the file cannot be read as a mesh.

    Raises:
        MissingLibraryError: trimesh is not installed.
    """
    # Late: the import takes most of a second.
    with extra("view", "drawing a mesh"):
        import trimesh

    kind = path.suffix.lower().removeprefix(".")
    if kind not in KINDS:
        return None
    try:
        content = path.read_bytes()
        if _unpacked(content) > MOST_BYTES:
            return None
        # From memory, so that what the file refers to in its turn is not opened.
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type=kind)
        if isinstance(mesh, trimesh.Scene):
            mesh = mesh.to_mesh()
        vertices, faces = np.array(mesh.vertices, float), np.array(mesh.faces, int)
    except Exception:
        # Of any kind: each of its many readers has its own, for what it trips over.
        return None
    if not len(faces) or not (np.abs(vertices) <= LARGEST).all():
        return None
    return vertices, faces


def _unpacked(content: bytes) -> int:
    """How many bytes a ZIP archive holds; none where the content is not one.

    No more than what the archive declares for an entry is unpacked from it.
    """
    file = io.BytesIO(content)
    if not zipfile.is_zipfile(file):
        return 0
    with zipfile.ZipFile(file) as archive:
        return sum(entry.file_size for entry in archive.infolist())
