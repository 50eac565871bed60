"""What a URDF shows of its links."""

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.extras import MissingLibraryError
from orbident.robot.urdf import rotation_of
from orbident.scene.mesh_files import mesh_file, read_mesh
from orbident.scene.shapes import BASE, Colour, Shape, box, cylinder, sphere


class LinkShapes(NamedTuple):
    """The shapes of the links, each in its link's frame."""

    by_link: dict[str, tuple[Shape, ...]]
    """Empty where nothing can be shown."""
    missing: tuple[str, ...]
    """Meshes that are not there or cannot be read."""
    refusal: str
    """Why no mesh can be read: the library for it is not installed; else empty."""


def link_shapes(urdf: str, folder: Path | None) -> LinkShapes:
    """The visuals of every link; its collision shapes where a visual cannot be had.

    What is wrong with a shape costs this shape, not the robot.

    Args:
        urdf: the text, well-formed.
        folder: of the URDF, for meshes; none are looked for where absent.
    """
    root = ET.fromstring(urdf)
    colours = {
        material.get("name", ""): material.find("color")
        for material in root.findall("material")
    }
    reader = _Reader(folder, colours, [], [])
    by_link = {}
    for link in root.findall("link"):
        visuals = [reader.shape(each) for each in link.findall("visual")]
        if None in visuals:
            visuals += [reader.shape(each) for each in link.findall("collision")]
        shown = [shape for shape in visuals if shape is not None]
        by_link[link.get("name", "")] = tuple(shown)
    missing = tuple(dict.fromkeys(reader.missing))
    return LinkShapes(by_link, missing, "".join(reader.refusals[:1]))


class _Reader(NamedTuple):
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
            placed = None if made is None else _placed(made, element.find("origin"))
        except (ValueError, OverflowError):
            return None
        return placed

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


def _placed(shape: Shape, origin: ET.Element | None) -> Shape:
    if origin is None:
        return shape
    rpy, xyz = (_numbers(origin.get(name), 3, 0.0) for name in ("rpy", "xyz"))
    return shape.moved(0, rotation_of(rpy), xyz)


def _numbers(
    text: str | None, count: int, default: float | None = None
) -> Float[np.ndarray, " n"]:
    """The numbers of an attribute; ValueError where they are not as many or not so."""
    if text is None and default is not None:
        return np.full(count, float(default))
    numbers = [float(word) for word in (text or "").split()]
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ValueError(text)
    return np.array(numbers)
