"""What a URDF shows is drawn; what cannot be drawn costs no more than itself."""

import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from processes import finished
from scipy.spatial.transform import Rotation

from orbident.scene.shapes import BASE, MOST_BYTES, link_shapes, mesh_file, read_mesh

PLACE = '<origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/>'


def urdf(*elements: str) -> str:
    return (
        '<robot name="r"><material name="red"><color rgba="1 0 0 1"/></material>'
        f'<link name="a">{"".join(elements)}</link></robot>'
    )


def visual(geometry: str, rest: str = "", tag: str = "visual") -> str:
    return f"<{tag}>{rest}<geometry>{geometry}</geometry></{tag}>"


def test_a_box_is_placed_by_roll_pitch_yaw():
    text = urdf(visual('<box size="2 4 6"/>', PLACE + '<material name="red"/>'))
    (shape,) = link_shapes(text, None).by_link["a"]
    R = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)])
    assert np.allclose(shape.vertices, corners @ R.T + [1, 2, 3], atol=1e-12)
    assert shape.colour == (255, 0, 0)


@pytest.mark.parametrize(
    ("geometry", "reach"),
    [
        ('<sphere radius="0.5"/>', [0.5, 0.5, 0.5]),
        ('<cylinder radius="0.5" length="3"/>', [0.5, 0.5, 1.5]),
    ],
)
def test_round_ones(geometry: str, reach: list[float]):
    (shape,) = link_shapes(urdf(visual(geometry)), None).by_link["a"]
    assert np.allclose(shape.vertices.max(axis=0), reach, atol=1e-12)
    assert shape.colour == BASE


@pytest.mark.parametrize(
    "bad",
    [
        '<box size="1 2"/>',
        '<box size="one two three"/>',
        '<box size="nan 1 1"/>',
        '<box size="1e300 1 1"/>',
        '<sphere radius=""/>',
        "<box/>",
        "<capsule/>",
        "",
        '<mesh filename="nowhere.stl"/>',
        '<mesh filename="package://no/where.dae"/>',
        '<mesh filename="\\0"/>'.replace("\\0", "%00"),
    ],
)
def test_what_cannot_be_shown_is_left_to_its_collision_shape(bad: str, tmp_path: Path):
    collision = visual('<box size="1 1 1"/>', tag="collision")
    found = link_shapes(urdf(visual(bad), collision), tmp_path)
    (shape,) = found.by_link["a"]
    assert np.allclose(np.abs(shape.vertices), 0.5)
    assert bool(found.missing) == ("mesh" in bad)
    assert link_shapes(urdf(visual(bad)), tmp_path).by_link["a"] == ()


def test_collision_shapes_are_not_drawn_over_visuals():
    text = urdf(
        visual('<sphere radius="1"/>'), visual('<box size="9 9 9"/>', tag="collision")
    )
    assert len(link_shapes(text, None).by_link["a"]) == 1


def test_meshes_are_found_and_scaled(tmp_path: Path):
    urdf_folder = tmp_path / "arm_description" / "urdf"
    meshes = tmp_path / "arm_description" / "meshes"
    for folder in (urdf_folder, meshes):
        folder.mkdir(parents=True)
    trimesh.creation.box((1, 2, 3)).export(meshes / "link.stl")
    names = ["package://arm_description/meshes/link.stl", "../meshes/link.stl"]
    names.append(f"file://{meshes / 'link.stl'}")
    for name in names:
        text = urdf(visual(f'<mesh filename="{name}" scale="0.1 0.1 -0.1"/>'))
        (shape,) = link_shapes(text, urdf_folder).by_link["a"]
        # STL keeps single precision.
        assert np.allclose(shape.vertices.max(axis=0), [0.05, 0.1, 0.15], atol=1e-6)
    # Without a folder nothing is opened.
    named = urdf(visual(f'<mesh filename="{names[0]}"/>'))
    assert link_shapes(named, None).missing == (names[0],)


def test_what_is_no_mesh_is_none(tmp_path: Path):
    for name, content in {
        "text.stl": b"solid nothing",
        "noise.stl": bytes(range(256)) * 4,
        "broken.dae": b"<COLLADA>",
        "empty.obj": b"",
        "model.unknown": b"x",
    }.items():
        (tmp_path / name).write_bytes(content)
        path = mesh_file(name, tmp_path)
        assert path is not None
        assert read_mesh(path) is None, name
    assert mesh_file("", tmp_path) is None
    assert mesh_file("a\0b", tmp_path) is None


def boxed(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((1, 2, 3)).export(path)
    return path


def test_meshes_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    boxed(tmp_path / "link.stl")
    mesh, ball = visual('<mesh filename="link.stl"/>'), visual('<sphere radius="1"/>')
    assert len(link_shapes(urdf(mesh, ball), tmp_path).by_link["a"]) == 2
    monkeypatch.setitem(sys.modules, "trimesh", None)
    found = link_shapes(urdf(mesh, ball), tmp_path)
    assert len(found.by_link["a"]) == 1
    assert found.missing == ("link.stl",)
    assert found.refusal == 'drawing a mesh needs trimesh: pip install "orbident[view]"'


def test_meshes_outside_the_robot_are_not_opened(tmp_path: Path):
    folder = tmp_path / "robot"
    inside = boxed(folder / "meshes" / "link.stl")
    outside = boxed(tmp_path / "secret" / "link.stl")
    (folder / "link.stl").symlink_to(outside)
    for name in ("meshes/link.stl", f"file://{inside}", "meshes/../meshes/link.stl"):
        assert mesh_file(name, folder) is not None, name
    for name in (
        "../secret/link.stl",
        f"file://{outside}",
        str(outside),
        "link.stl",
        "package://secret/link.stl",
        "package://robot/../secret/link.stl",
        "package://../secret/link.stl",
        f"package:///{outside}",
        f"package://{outside.relative_to('/')}",
        "package:///secret/link.stl",
    ):
        assert mesh_file(name, folder) is None, name


def test_a_declared_package_is_open_and_nothing_beside_it(tmp_path: Path):
    folder = tmp_path / "arm" / "robots" / "v2"
    folder.mkdir(parents=True)
    (tmp_path / "arm" / "package.xml").write_text("<package/>")
    own = boxed(tmp_path / "arm" / "meshes" / "link.stl")
    hand = boxed(tmp_path / "hand" / "link.stl")
    assert mesh_file("../../meshes/link.stl", folder) is not None
    assert mesh_file("package://hand/link.stl", folder) is None
    (tmp_path / "hand" / "package.xml").write_text("<package/>")
    assert mesh_file("package://hand/link.stl", folder) == hand
    assert mesh_file("package://arm/meshes/link.stl", folder) == own
    assert mesh_file("../../../hand/link.stl", folder) is None
    assert mesh_file("package://hand/../arm/meshes/link.stl", folder) is None


def test_archives_are_limited_unpacked(tmp_path: Path):
    small = tmp_path / "small.3mf"
    trimesh.creation.box((1, 2, 3)).export(small)
    assert read_mesh(small) is not None
    bomb = tmp_path / "bomb.3mf"
    bomb.write_bytes(small.read_bytes())
    with zipfile.ZipFile(bomb, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/more.model", bytes(MOST_BYTES))
    assert bomb.stat().st_size < 100_000
    assert read_mesh(bomb) is None
    bomb.rename(tmp_path / "bomb.zae")
    assert read_mesh(tmp_path / "bomb.zae") is None


def test_what_a_mesh_refers_to_is_not_opened(tmp_path: Path):
    """A glTF file names the file of its vertices, which may be any."""
    files: Any = trimesh.creation.box((1, 2, 3)).export(file_type="gltf")
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    named = (tmp_path / "model.gltf").read_text()
    assert all(path.name in named for path in tmp_path.glob("*.bin"))
    assert read_mesh(tmp_path / "model.gltf") is None
    boxed(tmp_path / "box.glb")
    assert read_mesh(tmp_path / "box.glb") is not None


def test_a_bad_mesh_is_left_without_a_word_of_its_reader(tmp_path: Path):
    (tmp_path / "link.stl").write_text(
        "solid s\nfacet normal x 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
        "vertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
    )
    code = (
        "from pathlib import Path\n"
        "from orbident.scene.shapes import read_mesh\n"
        "read_mesh(Path('link.stl'))"
    )
    # In a process of its own: pytest has handlers of its own for all logs.
    ran = finished(sys.executable, "-c", code, cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
