"""Triangles and their colour, of simple bodies, meshes, and what a URDF shows."""

import io
import logging
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.errors import InputError
from orbident.extras import MissingLibraryError, extra
from orbident.files.bounds import LARGEST
from orbident.robot.urdf import rotation_of
from orbident.robot.urdf_reader import numbers_in

Colour = tuple[int, int, int]

BASE: Colour = (176, 180, 190)
LINKS: tuple[Colour, ...] = ((68, 119, 170), (204, 187, 68), (34, 136, 51))
"""Colours of an arm's links in turn, distinct for the colour-blind too (Tol 2021,
bright)."""
WHEEL: Colour = (70, 70, 78)
MARK: Colour = (238, 102, 119)
"""The colour of what shows that a wheel turns."""

IDENTIFIED: Colour = (102, 204, 238)
"""The colour of the ghost that moves as the identified model predicts,"""
CAD: Colour = (207, 34, 46)
"""and of the one that moves as CAD does."""
FAINT = 0.35
"""Opacity of a ghost."""

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


def coarse(shape: Shape, most: int) -> Shape:
    """The shape, or the box around it where it has more vertices than this."""
    if len(shape.vertices) <= most:
        return shape
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    around = box(high - low, shape.colour)
    return around.moved(shape.frame, np.eye(3), (low + high) / 2)


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


class LinkShapes(NamedTuple):
    """The shapes of the links, each in its link's frame."""

    by_link: dict[str, tuple[Shape, ...]]
    """Empty where nothing can be shown."""
    missing: tuple[str, ...]
    """Meshes that are not there or cannot be read."""
    refusal: str
    """Why no mesh can be read: the library for it is not installed; else empty."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence where meshes are not shown."""
        if not self.missing:
            return ()
        if self.refusal:
            return (f"{self.refusal}; collision shapes or boxes stand for all meshes",)
        listed = ", ".join(name.rsplit("/", 1)[-1] for name in self.missing[:3])
        more = ", .." * (len(self.missing) > 3)
        return (
            f"{len(self.missing)} meshes are not there, cannot be read or lie outside "
            f"the robot's folder and packages ({listed}{more}); collision shapes or "
            "boxes stand for them",
        )


def link_shapes(urdf: str, folder: Path | None) -> LinkShapes:
    """The visuals of every link; its collision shapes where a visual cannot be had.

    What is wrong with a shape costs this shape, not the robot. Without a folder no
    meshes are looked for.
    """
    root = ET.fromstring(urdf)
    colours = {
        material.get("name", ""): material.find("color")
        for material in root.findall("material")
    }
    reader = _ShapeReader(folder, colours, [], [])
    by_link = {}
    for link in root.findall("link"):
        visuals = [reader.shape(each) for each in link.findall("visual")]
        if None in visuals:
            visuals += [reader.shape(each) for each in link.findall("collision")]
        shown = [shape for shape in visuals if shape is not None]
        by_link[link.get("name", "")] = tuple(shown)
    missing = tuple(dict.fromkeys(reader.missing))
    return LinkShapes(by_link, missing, "".join(reader.refusals[:1]))


class _ShapeReader(NamedTuple):
    folder: Path | None
    colours: dict[str, ET.Element | None]
    missing: list[str]
    refusals: list[str]

    def shape(self, element: ET.Element) -> Shape | None:
        """What a <visual> or <collision> shows; None where it cannot be had."""
        geometry = next(iter(element.find("geometry") or ()), None)
        if geometry is None:
            return None
        try:
            made = self._geometry(geometry, self._colour(element.find("material")))
            origin = element.find("origin")
            if made is None or origin is None:
                return made
            rpy, xyz = (_numbers(origin.get(name), 3, 0.0) for name in ("rpy", "xyz"))
            return made.moved(0, rotation_of(rpy), xyz)
        except InputError:
            return None

    def _geometry(self, geometry: ET.Element, colour: Colour) -> Shape | None:
        def lengths(name: str, count: int) -> Float[np.ndarray, " n"]:
            return np.abs(_numbers(geometry.get(name), count))

        if geometry.tag == "box":
            return box(lengths("size", 3), colour)
        if geometry.tag == "sphere":
            return sphere(lengths("radius", 1)[0], colour)
        if geometry.tag == "cylinder":
            (radius,), (length,) = lengths("radius", 1), lengths("length", 1)
            return cylinder(radius, length, colour)
        return self._mesh(geometry, colour) if geometry.tag == "mesh" else None

    def _mesh(self, geometry: ET.Element, colour: Colour) -> Shape | None:
        name = geometry.get("filename", "")
        path = mesh_file(name, self.folder) if self.folder else None
        try:
            mesh = read_mesh(path) if path else None
        except MissingLibraryError as refusal:
            self.refusals.append(str(refusal))
            mesh = None
        if mesh is None:
            self.missing.append(name)
            return None
        scale = _numbers(geometry.get("scale"), 3, 1.0)
        return Shape(0, mesh[0] * scale, mesh[1], colour)

    def _colour(self, material: ET.Element | None) -> Colour:
        if material is None:
            return BASE
        own = material.find("color")
        colour = self.colours.get(material.get("name", "")) if own is None else own
        if colour is None:
            return BASE
        r, g, b, _ = np.clip(255 * _numbers(colour.get("rgba"), 4), 0, 255)
        return round(r), round(g), round(b)


def _numbers(
    text: str | None, count: int, default: float | None = None
) -> Float[np.ndarray, " n"]:
    """The numbers of an attribute; `InputError` for another count, or absurd ones."""
    if text is None and default is not None:
        return np.full(count, float(default))
    return np.array(numbers_in(text or "", count, "URDF"))
