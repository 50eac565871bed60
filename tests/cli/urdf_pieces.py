"""URDFs put together from links and joints, and robot files around them."""

from collections.abc import Sequence
from pathlib import Path

BASE = (40.0, (0.02, -0.05, 0.1), (4.0, 5.0, 6.0), (0.1, -0.2, 0.15))
"""Mass, CM, diagonal and off-diagonal (xy, xz, yz) inertia of a base, SI."""
LINK = (3.0, (0.1, 0.02, -0.03), (0.12, 0.15, 0.1), (0.01, 0.005, -0.008))


def _listed(numbers: Sequence[float]) -> str:
    return " ".join(map(str, numbers))


def link(
    name: str,
    mass: float = LINK[0],
    com: Sequence[float] = LINK[1],
    diagonal: Sequence[float] = LINK[2],
    products: Sequence[float] = LINK[3],
) -> str:
    xx, yy, zz = diagonal
    xy, xz, yz = products
    return (
        f'<link name="{name}"><inertial><origin xyz="{_listed(com)}"/>'
        f'<mass value="{mass}"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}" '
        f'ixy="{xy}" ixz="{xz}" iyz="{yz}"/></inertial></link>'
    )


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    xyz: Sequence[float] = (0.3, 0.1, 0.0),
    rpy: Sequence[float] = (0.0, 0.0, 0.0),
    axis: Sequence[float] = (0.0, 0.0, 1.0),
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{_listed(xyz)}" rpy="{_listed(rpy)}"/>'
        f'<axis xyz="{_listed(axis)}"/></joint>'
    )


def urdf(*elements: str, name: str = "servicer") -> str:
    return f'<robot name="{name}">{"".join(elements)}</robot>'


ARM = urdf(
    link("base", *BASE),
    link("link1"),
    link("link2"),
    joint("joint1", "base", "link1"),
    joint("joint2", "link1", "link2", axis=(0.0, 1.0, 0.0)),
)

WHEELS = """\
wheels:
  - {name: rw_x, axis: [1, 0, 0], inertia: 0.05}
  - {name: rw_z, axis: [0, 0, 1], inertia: 0.05}
"""


def robot_file(folder: Path, text: str = ARM, lines: str = WHEELS) -> Path:
    """`servicer.yaml` with these lines after schema and urdf, and its URDF."""
    (folder / "servicer.urdf").write_text(text, encoding="utf-8")
    path = folder / "servicer.yaml"
    head = "schema: orbident/robot/1\nurdf: servicer.urdf\n"
    path.write_text(head + lines, encoding="utf-8")
    return path
