"""Short URDFs, put together from pieces."""

from pathlib import Path

SHARED_ROBOTS = Path(__file__).parents[3].parent / "shared" / "robots"


def link(
    name: str,
    mass: float | str | None = 1.0,
    diagonal: tuple[float, float, float] = (0.1, 0.1, 0.1),
    com: str = "0 0 0",
) -> str:
    if mass is None:
        return f'<link name="{name}"/>'
    xx, yy, zz = diagonal
    return (
        f'<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    xyz: str = "0 0 0",
    rpy: str = "0 0 0",
    axis: str | None = "0 0 1",
    inside: str = "",
) -> str:
    axis_element = "" if axis is None else f'<axis xyz="{axis}"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
        f"{axis_element}{inside}</joint>"
    )


def robot(*elements: str, name: str = "test") -> str:
    return f'<robot name="{name}">' + "".join(elements) + "</robot>"


ARM = robot(
    link("base", 100.0, (10.0, 11.0, 12.0), com="0.1 0 0"),
    link("link1", 5.0, com="0 0 0.2"),
    link("link2", 4.0, com="0.3 0 0"),
    joint("joint1", "base", "link1", xyz="1 0 0"),
    joint("joint2", "link1", "link2", xyz="0 0 0.5", axis="0 1 0"),
)
