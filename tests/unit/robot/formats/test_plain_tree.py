"""Bodies and DH tables in a robot file, beside a URDF and the product of matrices."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from one_state import only_state
from random_robots import random_rotation
from robot_parts import random_parts, rpy, urdf_of

from orbident.errors import InputError
from orbident.model.kinematics import poses
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com
from orbident.robot.robot_file import load_robot, write_robot

HEAD = "schema: orbident/robot/1\n"


def load(folder: Path, lines: str) -> Robot:
    (folder / "plain.yaml").write_text(HEAD + lines)
    return load_robot(folder / "plain.yaml")


def flow(numbers: npt.ArrayLike) -> str:
    return "[" + ", ".join(repr(float(x)) for x in np.ravel(numbers)) + "]"


def test_bodies_are_the_same_robot_as_a_urdf(tmp_path: Path):
    parts = random_parts(0)
    lines = "bodies:\n"
    for part in parts:
        I = part.R_I @ np.diag(part.moments) @ part.R_I.T
        entries = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2)}
        entries |= {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        inertia = ", ".join(f"{k}: {float(I[at])!r}" for k, at in entries.items())
        said = []
        if part.mass:
            said = [f"mass: {part.mass!r}", f"com: {flow(part.com)}"]
            said.append(f"inertia: {{{inertia}}}")
        if part.parent >= 0:
            said += [
                f"parent: {parts[part.parent].name}",
                f"joint: to_{part.name}",
                f"type: {part.kind}",
                f"axis: {flow(part.axis)}",
                f"xyz: {flow(part.p)}",
                f"rpy: {flow([float(x) for x in rpy(part.R).split()])}",
            ]
        lines += f"  {part.name}: {{{', '.join(said)}}}\n"
    plain = load(tmp_path, lines)
    (tmp_path / "one.urdf").write_text(urdf_of(parts))
    one = load_robot(tmp_path / "one.urdf")
    assert (plain.bodies, plain.joint_names) == (one.bodies, one.joint_names)
    # 17 digits in both files; three rotations of 1e-16 multiply numbers of some tens.
    np.testing.assert_allclose(plain.theta, one.theta, rtol=0, atol=1e-13)
    for mine, given in zip(plain.joints, one.joints, strict=True):
        assert (mine.kind, mine.parent) == (given.kind, given.parent)
        for name in ("axis", "R_PJ", "p_PJ"):
            np.testing.assert_allclose(
                getattr(mine, name), getattr(given, name), rtol=0, atol=1e-13
            )


def test_units(tmp_path: Path):
    robot = load(
        tmp_path,
        "bodies:\n"
        "  base: {mass: 2500 g, com: [10 mm, 0, 1 cm], inertia: [4e8 g mm^2, "
        "0.4 kg m^2, 5000 kg cm^2]}\n"
        "  arm: {parent: base, joint: j, axis: [0, 0, 2], rpy: [0, 0, 90 deg]}\n",
    )
    assert robot.theta[0, :4].tolist() == pytest.approx([2.5, 0.025, 0, 0.025])
    I = inertia_about_com(robot.theta[0])
    # Huygens-Steiner adds and takes away some 1e-4: 1e-19 of rounding.
    np.testing.assert_allclose(I, np.diag([0.4, 0.4, 0.5]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(robot.joints[0].R_PJ @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_array_equal(robot.joints[0].axis, [0, 0, 1])


def matrices(a: float, alpha: float, d: float, theta: float) -> list[np.ndarray]:
    """`Rz(theta) Tz(d)`, and `Tx(a) Rx(alpha)`, as Denavit and Hartenberg have them."""
    (ct, st), (ca, sa) = [(np.cos(x), np.sin(x)) for x in (theta, alpha)]
    Z = np.array([[ct, -st, 0, 0], [st, ct, 0, 0], [0, 0, 1, d], [0, 0, 0, 1.0]])
    X = np.array([[1, 0, 0, a], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1.0]])
    return [Z, X]


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_a_table_puts_frames_where_its_matrices_do(tmp_path: Path, convention: str):
    random = np.random.default_rng(3)
    kinds = ["revolute", "prismatic", "revolute", "revolute"]
    rows = random.uniform(-1, 1, (4, 4))
    coms, masses = random.uniform(-1, 1, (4, 3)), random.uniform(1, 2, 4)
    R_mount, p_mount = random_rotation(random), random.uniform(-1, 1, 3)
    lines = (
        f"dh:\n  convention: {convention}\n  base: {{mass: 1, inertia: [1, 1, 1], "
        f"xyz: {flow(p_mount)}, rpy: {flow([float(x) for x in rpy(R_mount).split()])}}}"
        "\n  rows:\n"
    )
    for k, ((a, alpha, d, theta), kind) in enumerate(zip(rows, kinds, strict=True)):
        lines += (
            f"    - {{joint: j{k}, type: {kind}, a: {float(a)!r}, "
            f"alpha: {float(alpha)!r}, d: {float(d)!r}, theta: {float(theta)!r}, "
            f"mass: {float(masses[k])!r}, com: {flow(coms[k])}, "
            "inertia: [1, 2, 2.5]}\n"
        )
    robot = load(tmp_path, lines)
    assert robot.bodies == ("base", "link1", "link2", "link3", "link4")
    q = random.uniform(-1, 1, 4)
    at = only_state(poses(robot, q[None]))
    T = np.block([[R_mount, p_mount[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
    for k, ((a, alpha, d, theta), kind) in enumerate(zip(rows, kinds, strict=True)):
        before = T
        moved = (d, theta + q[k]) if kind == "revolute" else (d + q[k], theta)
        Z, X = matrices(a, alpha, *moved)
        T = T @ Z @ X if convention == "standard" else T @ X @ Z
        axis = before[:3, 2] if convention == "standard" else T[:3, 2]
        # Products of up to nine matrices of numbers about one: 1e-15.
        close = {"rtol": 0, "atol": 1e-14}
        np.testing.assert_allclose(at.R[k + 1], T[:3, :3], **close)
        np.testing.assert_allclose(at.R[k + 1] @ robot.joints[k].axis, axis, **close)
        theta_k = robot.theta[k + 1]
        com = at.d[k + 1] + at.R[k + 1] @ theta_k[1:4] / masses[k]
        np.testing.assert_allclose(com, T[:3, :3] @ coms[k] + T[:3, 3], **close)
        I = inertia_about_com(theta_k)
        np.testing.assert_allclose(I, np.diag([1, 2, 2.5]), **close)


def test_what_is_written_loads_again(tmp_path: Path):
    robot = load(
        tmp_path,
        "dh: {base: {mass: 3, inertia: [1, 1, 1]}, rows: [{joint: j, a: 0.3, "
        "alpha: 0.2, mass: 1, inertia: [1, 1, 1]}]}\n",
    )
    again = load_robot(write_robot(robot, tmp_path / "run"))
    np.testing.assert_array_equal(again.theta, robot.theta)
    np.testing.assert_array_equal(again.joints[0].R_PJ, robot.joints[0].R_PJ)


BASE = "base: {mass: 1, inertia: [1, 1, 1]}"
ROW = "joint: j, mass: 1, inertia: [1, 1, 1]"
BAD = {
    "nothing": ("name: x\n", "'model' is missing; give a URDF, xacro, MJCF or SDF"),
    "two of them": (f"model: x.urdf\nbodies: {{{BASE}}}\n", "keep one"),
    "no bodies": ("bodies: {}\n", "at least"),
    "no list": ("bodies: [1]\n", "bodies"),
    "an unknown key": ("bodies: {base: {weight: 1}}\n", "bodies.base: unknown key"),
    "text for mass": (
        "bodies: {base: {mass: heavy, inertia: [1, 1, 1]}}\n",
        "bodies.base.mass: found 'heavy'; give a finite number",
    ),
    "a wrong unit": (
        "bodies: {base: {mass: 1 lb, inertia: [1, 1, 1]}}\n",
        "unknown unit 'lb' of a mass; accepted: kg, g",
    ),
    "no inertia": ("bodies: {base: {mass: 1}}\n", "bodies.base: 'inertia' is missing"),
    "no mass": (
        "bodies: {base: {inertia: [1, 1, 1]}}\n",
        "bodies.base: 'mass' is missing or zero",
    ),
    "two moments": (
        "bodies: {base: {mass: 1, inertia: [1, 1]}}\n",
        "bodies.base.inertia: found [1, 1]; give [xx, yy, zz]",
    ),
    "an unknown moment": (
        "bodies: {base: {mass: 1, inertia: {xx: 1, yy: 1, zz: 1, zx: 0}}}\n",
        "give xx, yy, zz, xy, xz, yz only",
    ),
    "no joint": (
        f"bodies: {{{BASE}, arm: {{parent: base, axis: [0, 0, 1]}}}}\n",
        "bodies.arm: 'joint' missing",
    ),
    "no axis": (
        f"bodies: {{{BASE}, arm: {{parent: base, joint: j, axis: [0, 0, 0]}}}}\n",
        "bodies.arm.axis: found [0, 0, 0]; give a nonzero 3-vector",
    ),
    "an unknown type": (
        f"bodies: {{{BASE}, arm: {{parent: base, joint: j, type: ball}}}}\n",
        "bodies.arm.type: found 'ball'; give 'revolute', 'prismatic' or 'fixed'",
    ),
    "no parent": (f"bodies: {{{BASE}, arm: {{joint: j}}}}\n", "but no parent"),
    "two roots": (f"bodies: {{{BASE}, arm: {{}}}}\n", "several roots"),
    "an unknown parent": (
        f"bodies: {{{BASE}, arm: {{parent: bose, joint: j, axis: [0, 0, 1]}}}}\n",
        "did you mean 'base'",
    ),
    "a ring": (
        "bodies:\n  a: {parent: b, joint: j, axis: [0, 0, 1]}\n"
        "  b: {parent: a, joint: k, axis: [0, 0, 1]}\n",
        "loop",
    ),
    "a joint twice": (
        f"bodies: {{{BASE}, a: {{parent: base, joint: j, axis: [0, 0, 1]}}, "
        "b: {parent: base, joint: j, axis: [0, 0, 1]}}\n",
        "joint 'j' is defined twice",
    ),
    "no rows": (f"dh: {{{BASE}, rows: []}}\n", "dh.rows"),
    "no base": (f"dh: {{rows: [{{{ROW}}}]}}\n", "dh.base: this key is missing"),
    "a row without a joint": (
        f"dh: {{{BASE}, rows: [{{a: 1}}]}}\n",
        "dh.rows[0].joint: this key is missing",
    ),
    "degrees of a length": (
        f"dh: {{{BASE}, rows: [{{{ROW}, a: 3 deg}}]}}\n",
        "dh.rows[0].a: found '3 deg'; unknown unit 'deg' of a length",
    ),
    "another convention": (
        f"dh: {{convention: old, {BASE}, rows: [{{{ROW}}}]}}\n",
        "dh.convention: found 'old'; give 'standard' or 'modified'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_refused(tmp_path: Path, case: str):
    lines, words = BAD[case]
    with pytest.raises(InputError) as caught:
        load(tmp_path, lines)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "plain.yaml"))
    assert words in message
    assert "\n" not in message
