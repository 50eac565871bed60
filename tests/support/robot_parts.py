"""Random robots as parts, and as the text of a URDF, an MJCF and an SDF file."""

from typing import NamedTuple

import numpy as np
from random_robots import random_rotation, random_unit_vector
from scipy.spatial.transform import Rotation


class Part(NamedTuple):
    """A link, and the joint that it hangs on."""

    name: str
    parent: int
    """Index of the parent; -1 of the base."""
    kind: str
    R: np.ndarray
    """Rotates from the link's axes at q = 0 into the parent's."""
    p: np.ndarray
    axis: np.ndarray
    mass: float
    com: np.ndarray
    R_I: np.ndarray
    """Rotates from the principal axes into the link's."""
    moments: np.ndarray
    """About the CM, along the principal axes."""


def random_parts(seed: int, count: int = 7) -> list[Part]:
    """A base and its tree; the third part has no mass, and carries the fourth."""
    random = np.random.default_rng(seed)
    parts = []
    for k in range(count):
        parent = int(random.integers(0, k)) if k else -1
        if parent == 2 or k == 3:
            parent = 2 if k == 3 else 0
        kind = str(random.choice(["revolute", "prismatic", "fixed"], p=[0.4, 0.3, 0.3]))
        if k in {2, 3}:
            kind = "revolute" if kind == "fixed" else kind
        mass = 0.0 if k == 2 else float(random.uniform(1, 5))
        a, b, c = random.uniform(0.1, 1.0, 3)
        parts.append(
            Part(
                f"part{k}",
                parent,
                kind,
                random_rotation(random),
                random.standard_normal(3),
                random_unit_vector(random),
                mass,
                0.3 * random.standard_normal(3) if mass else np.zeros(3),
                random_rotation(random),
                # Of three squared lengths, so that a body can have them.
                mass * np.array([b + c, a + c, a + b]),
            )
        )
    return parts


def listed(numbers: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(numbers))


def rpy(R: np.ndarray) -> str:
    return listed(Rotation.from_matrix(R).as_euler("xyz"))


def urdf_of(parts: list[Part]) -> str:
    """Link frames at the joints, inertial frames along the principal axes."""
    lines = []
    for part in parts:
        xx, yy, zz = map(float, part.moments)
        inertial = (
            f'<inertial><origin xyz="{listed(part.com)}" rpy="{rpy(part.R_I)}"/>'
            f'<mass value="{part.mass!r}"/><inertia ixx="{xx!r}" iyy="{yy!r}" '
            f'izz="{zz!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
        )
        lines.append(f'<link name="{part.name}">{inertial if part.mass else ""}</link>')
        if part.parent >= 0:
            limit = '<limit lower="-2" upper="1.5" effort="1" velocity="0.5"/>'
            lines.append(
                f'<joint name="to_{part.name}" type="{part.kind}">'
                f'<parent link="{parts[part.parent].name}"/>'
                f'<child link="{part.name}"/>'
                f'<origin xyz="{listed(part.p)}" rpy="{rpy(part.R)}"/>'
                f'<axis xyz="{listed(part.axis)}"/>{limit}</joint>'
            )
    return f'<robot name="random">{"".join(lines)}</robot>'


def mjcf_of(parts: list[Part], seed: int = 0, moved: bool = True) -> str:
    """Bodies whose frames are beside their joints, drawn where these are at `ref`.

    The part without mass is a second joint of what it carries.

    Args:
        parts: the robot.
        seed: of the offsets and the values of `ref`.
        moved: false for frames at the joints, and no `ref`, which Pinocchio wants.
    """
    random = np.random.default_rng(seed)
    offsets = [0.2 * random.standard_normal(3) * (moved and k > 0) for k in range(99)]
    refs = random.uniform(-1, 1, 99) * moved

    def joint(part: Part, R: np.ndarray, pos: np.ndarray, ref: float) -> str:
        if part.kind == "fixed":
            return ""
        kind = "hinge" if part.kind == "revolute" else "slide"
        axis = listed(R @ part.axis)
        return (
            f'<joint name="to_{part.name}" type="{kind}" axis="{axis}" '
            f'pos="{listed(pos)}" ref="{ref!r}" range="-2 1.5"/>'
        )

    def body(k: int, R: np.ndarray, p: np.ndarray, joints: str) -> str:
        part, d = parts[k], offsets[k]
        children = [i for i, each in enumerate(parts) if each.parent == k]
        if k and not part.mass:
            (child,) = children
            own = parts[child]
            first = joint(part, own.R.T, offsets[child] - own.R.T @ own.p, 0.0)
            return body(child, R @ own.R, p + R @ own.p, first)
        if k:
            ref = float(refs[k]) * (part.kind != "fixed" and not joints)
            joints += joint(part, np.eye(3), d, ref)
            if part.kind == "revolute":
                R = R @ Rotation.from_rotvec(ref * part.axis).as_matrix()
            elif part.kind == "prismatic":
                p = p + R @ part.axis * ref
        inside = "".join(body(i, parts[i].R, parts[i].p + d, "") for i in children)
        quat = Rotation.from_matrix(R).as_quat(scalar_first=True)
        iquat = Rotation.from_matrix(part.R_I).as_quat(scalar_first=True)
        return (
            f'<body name="{part.name}" pos="{listed(p - R @ d)}" '
            f'quat="{listed(quat)}">{joints}'
            f'<inertial pos="{listed(part.com + d)}" quat="{listed(iquat)}" '
            f'mass="{part.mass!r}" diaginertia="{listed(part.moments)}"/>'
            f"{inside}</body>"
        )

    base = body(0, np.eye(3), np.zeros(3), "<freejoint/>")
    return (
        '<mujoco model="random"><compiler angle="radian"/><worldbody>'
        f"{base}</worldbody></mujoco>"
    )


def sdf_of(parts: list[Part], seed: int = 0) -> str:
    """Links whose origins are beside their joints, relative to the model or parents.

    Every second pose is in degrees, and every second axis in another frame's axes.
    """
    random = np.random.default_rng(seed)
    offsets = [0.2 * random.standard_normal(3) * (k > 0) for k in range(len(parts))]
    # The link's own frame; its origin is d before the joint's, in its axes.
    in_model = []
    for part, d in zip(parts, offsets, strict=True):
        if part.parent < 0:
            in_model.append((np.eye(3), np.zeros(3)))
            continue
        R, p = in_model[part.parent]
        at = p + R @ (part.p + offsets[part.parent])
        in_model.append((R @ part.R, at - R @ part.R @ d))
    lines = []
    for k, (part, d) in enumerate(zip(parts, offsets, strict=True)):
        R, p = in_model[k]
        relative, said = (R, p), ""
        if k and k % 3:
            R_P, p_P = in_model[part.parent]
            relative = (R_P.T @ R, R_P.T @ (p - p_P))
            said = f' relative_to="{parts[part.parent].name}"'
        turned = Rotation.from_matrix(relative[0]).as_euler("xyz", degrees=k % 2 == 1)
        said += ' degrees="true"' if k % 2 else ""
        xx, yy, zz = map(float, part.moments)
        lines.append(
            f'<link name="{part.name}"><pose{said}>{listed(relative[1])} '
            f"{listed(turned)}</pose>"
            f"<inertial><pose>{listed(part.com + d)} {rpy(part.R_I)}</pose>"
            f"<mass>{part.mass!r}</mass><inertia><ixx>{xx!r}</ixx><iyy>{yy!r}</iyy>"
            f"<izz>{zz!r}</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>"
            "</inertial></link>"
        )
        if not k:
            continue
        # The joint's own axes are turned against the link's.
        turn = random_rotation(random)
        frame, axis = "", turn.T @ part.axis
        if k % 2:
            frame, axis = ' expressed_in="__model__"', R @ part.axis
        limit = "<limit><lower>-2</lower><upper>1.5</upper><velocity>0.5</velocity>"
        inside = (
            f"<axis><xyz{frame}>{listed(axis)}</xyz>{limit}</limit></axis>"
            if part.kind != "fixed"
            else ""
        )
        lines.append(
            f'<joint name="to_{part.name}" type="{part.kind}">'
            f"<pose>{listed(d)} {rpy(turn)}</pose>"
            f"<parent>{parts[part.parent].name}</parent><child>{part.name}</child>"
            f"{inside}</joint>"
        )
    return f'<sdf version="1.9"><model name="random">{"".join(lines)}</model></sdf>'
