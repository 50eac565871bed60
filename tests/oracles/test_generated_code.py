"""`H+` and `c+` in C and in MATLAB's language are those of Python and of Pinocchio."""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

import ctypes
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flight_builds import WARNINGS, needs_compilers, ran
from made_results import exact_result
from pinocchio_model import paper_equations, pinocchio_model
from processes import finished
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_wheels,
)
from wheels_as_joints import wheels_as_joints

from orbident.errors import InputError
from orbident.identified.generated_code import equations_as_c, equations_as_matlab
from orbident.model.equations_of_motion import movable, speeds
from orbident.model.reconstruction import Dynamics
from orbident.robot.description import GearedRotor, Passive, Robot

needs_octave = pytest.mark.skipif(
    shutil.which("octave-cli") is None, reason="Octave is not installed"
)

# Sums of some tens of products of float64 on either side, over the size of each entry;
# the worst observed is 4e-13.
TOLERANCE = 1e-12
STATES = 10

WHEELS = random_wheels(1, ("held", "held", "held"))
PARENTS = random_parents(np.random.default_rng(1), 6)
ROBOTS = {
    "spatial": random_robot(1, PARENTS, (), WHEELS),
    "planar": random_planar_robot(2, (0, 1, 0), (1,), ()),
    "slides": random_robot(3, (0, 1, 2, 0), (0, 2), WHEELS[:1]),
    "no joints": random_robot(4, (), (), WHEELS[:2]),
    "no wheels": random_robot(5, (0,)),
}


def exact_dynamics(robot: Robot) -> Dynamics:
    """Of the robot's own bodies, whose parameters Pinocchio has too."""
    return Dynamics(robot, np.zeros((0, 0)))


def states(robot: Robot) -> list[tuple[np.ndarray, np.ndarray]]:
    """Positions and speeds at random, wheels at hundreds of rad/s."""
    random = np.random.default_rng(7)
    joints = len(robot.joints)
    q = random.standard_normal((STATES, joints))
    v = random.standard_normal((STATES, speeds(robot))) * movable(robot)
    v[:, 6 + joints :] *= 200.0
    return [*zip(q, v, strict=True)]


def in_c(model: Dynamics, folder: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """What the compiled file makes of each state."""
    source, library = folder / "model.c", folder / "model.so"
    source.write_text(equations_as_c(model))
    strict = ("-std=c99", "-pedantic", "-Wmissing-prototypes", "-Wshadow", *WARNINGS)
    ran("cc", *strict, "-O2", "-shared", "-fPIC", source, "-lm", "-o", library)
    loaded, n = ctypes.CDLL(str(library)), speeds(model.robot)
    array = np.ctypeslib.ndpointer(flags="C")
    loaded.H_plus.argtypes, loaded.c_plus.argtypes = [array] * 2, [array] * 3
    found = []
    for q, v in states(model.robot):
        H, c = np.empty((n, n)), np.empty(n)
        loaded.H_plus(q, H)
        loaded.c_plus(q, v, c)
        found.append((H, c))
    return found


def in_octave(model: Dynamics, folder: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """What Octave makes of each state; it reads MATLAB's language."""
    (folder / "model.m").write_text(equations_as_matlab(model, "model"))
    lines = [f"addpath('{folder}');"]
    for q, v in states(model.robot):
        lines.append(f"[H, c] = model({q.tolist()}, {v.tolist()});")
        lines.append("printf('%.17g\\n', H, c);")
    (folder / "run_all.m").write_text("\n".join(lines))
    script = folder / "run_all.m"
    # As it ends, one without some of its own packages complains of itself.
    run = finished("octave-cli", "--quiet", "--norc", script, limit=300.0)
    assert run.returncode == 0, run.stderr
    n = speeds(model.robot)
    every = np.array([float(word) for word in run.stdout.split()]).reshape(STATES, -1)
    return [(row[: n * n].reshape(n, n), row[n * n :]) for row in every]


def assert_same(
    found: tuple[np.ndarray, np.ndarray], expected: tuple[np.ndarray, np.ndarray]
):
    """Over what the size of each entry is, by the inertias of its two speeds."""
    root = np.sqrt(np.diag(expected[0]))
    for a, b, size in zip(
        found, expected, (np.outer(root, root), root * np.nanmax(root)), strict=True
    ):
        scale = max(1.0, float(np.nanmax(np.abs(b / size))))
        np.testing.assert_allclose(a / size, b / size, rtol=0, atol=TOLERANCE * scale)


@needs_compilers
@pytest.mark.parametrize("name", ROBOTS)
def test_c(name: str, tmp_path: Path):
    model = exact_dynamics(ROBOTS[name])
    for found, state in zip(in_c(model, tmp_path), states(ROBOTS[name]), strict=True):
        assert_same(found, model.equations(*state))


@needs_compilers
@pytest.mark.parametrize("name", ROBOTS)
def test_c_against_pinocchio(name: str, tmp_path: Path):
    robot = ROBOTS[name]
    apart = wheels_as_joints(robot)
    model, rest = pinocchio_model(apart).model, np.zeros(len(robot.wheels))
    known = movable(robot)
    for (H, c), (q, v) in zip(
        in_c(exact_dynamics(robot), tmp_path), states(robot), strict=True
    ):
        theirs = paper_equations(model, apart.joint_names, np.append(q, rest), v)
        H_pin, c_pin = theirs[0][np.ix_(known, known)], theirs[1][known]
        assert_same((H[np.ix_(known, known)], c[known]), (H_pin, c_pin))


@needs_octave
@pytest.mark.parametrize("name", ROBOTS)
def test_matlab(name: str, tmp_path: Path):
    model = exact_dynamics(ROBOTS[name])
    for found, state in zip(
        in_octave(model, tmp_path), states(ROBOTS[name]), strict=True
    ):
        assert_same(found, model.equations(*state))


@needs_compilers
def test_rotors_and_identified_parameters(tmp_path: Path):
    """A theta that no body need have, and rotors behind gears."""
    rotors = {"joint2": GearedRotor(100.0, 1e-5, 0.1)}
    robot = replace(ROBOTS["spatial"], rotors=rotors)
    model = exact_result(robot).dynamics()
    for found, state in zip(in_c(model, tmp_path), states(robot), strict=True):
        assert_same(found, model.equations(*state))


def test_names_cannot_leave_their_comment():
    robot = replace(ROBOTS["no joints"], name="a\n*/ int x; \\")
    for text in (
        equations_as_c(exact_dynamics(robot)),
        equations_as_matlab(exact_dynamics(robot), "model"),
    ):
        assert "H+ and c+ of a int x;  in H+" in text


def test_what_is_refused():
    model = exact_dynamics(ROBOTS["slides"])
    for name in ("2nd", "my-model", "", "größe", "a" * 64, "for", "cross_matrix"):
        with pytest.raises(InputError, match="cannot be the name of this function"):
            equations_as_matlab(model, name)
    passive = {model.robot.joint_names[1]: Passive(0.5)}
    model = replace(model, robot=replace(model.robot, passive=passive))
    for write in (equations_as_c, lambda each: equations_as_matlab(each, "model")):
        with pytest.raises(InputError, match="is passive, and the exported code"):
            write(model)
