"""What is identified without noise gives the true robot's `H+`, `c+` and Jacobians.

The truth is the robot itself, whose equations of motion are held against Pinocchio in
`test_equations_of_motion`; the exported URDF is held against it by Pinocchio here. The
nominal inertia is off by a third and more, so that nothing can come from there.
"""

# Pinocchio and MuJoCo are compiled, and have no stubs for what they export.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from pinocchio_model import paper_equations
from random_motions import random_motion

from orbident.diagnosis import linear_test
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.exported_robot import exported_robot, exported_urdf
from orbident.model.equations_of_motion import equations_of_motion, jacobian, movable
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.control import off_by

STATES = 1000

# As asked for; of the robots here the worst observed is 8e-11, with Astrobee, whose
# fingers move by 0.35 rad only: rounding times a condition number of 4e7.
EXACT = 1e-8
BY_PINOCCHIO = 1e-6

ASTROBEE = Path(__file__).parents[2].parent / "shared" / "robots" / "astrobee"
ROBOTS = ("paper-spatial", "cepheus-like", "dual-arm", "astrobee")


class Case(NamedTuple):
    true: Robot
    result: Result
    q: np.ndarray
    v: np.ndarray


@pytest.fixture(scope="module", params=ROBOTS)
def case(request, tmp_path_factory) -> Case:
    if request.param == "astrobee":
        robot = astrobee(tmp_path_factory.mktemp("astrobee"))
        recording = simulate(robot, random_motion(robot, wheel_speed=250.0))
    elif request.param == "dual-arm":
        robot = without_stops(load_robot("dual-arm"))
        recording = simulate(robot, random_motion(robot, duration=60.0), rate=50.0)
    else:
        robot = load_robot(request.param)
        start = "spun up" if robot.motion == "planar" else "turning"
        recording = simulate(robot, random_motion(robot, start=start))
    momentum = "at-rest" if robot.motion == "planar" else "unknown"
    cad = off_by(robot, 0.35, seed=1)
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "dual-arm":
            # No convention is another one: to try all 320 of 496 `pi` takes a minute.
            patch.setattr(linear_test, "plain_mistake", lambda _: [])
        result = identify(cad, recording, "least-squares", momentum)
    assert result.status == "ok"
    random = np.random.default_rng(0)
    q = random.standard_normal((STATES, len(robot.joints)))
    v = random.standard_normal((STATES, 6 + len(robot.joints) + len(robot.wheels)))
    return Case(robot, result, q, v * movable(robot))


def without_stops(robot: Robot) -> Robot:
    """No motion within the stops of `dual-arm` shows its 496 `pi` beyond rounding."""
    joints = tuple(replace(joint, position=None) for joint in robot.joints)
    return replace(robot, joints=joints)


def astrobee(folder: Path) -> Robot:
    """NASA's Astrobee with its perching arm, and wheels, which it has none of."""
    if not ASTROBEE.is_dir():
        pytest.skip("the Astrobee URDF is not beside this repository")
    path = folder / "astrobee.yaml"
    wheels = "".join(
        f"  - {{name: rw_{name}, axis: {axis}, inertia: 0.002}}\n"
        for name, axis in zip("xyz", np.eye(3).tolist(), strict=True)
    )
    path.write_text(
        "schema: orbident/robot/1\nname: astrobee\n"
        f"urdf: {ASTROBEE}/astrobee_perching_arm_iss.urdf\nwheels:\n{wheels}"
    )
    return load_robot(path)


def worst(found: np.ndarray, true: np.ndarray) -> float:
    """Largest error over the largest entry, of what is known."""
    known = np.isfinite(found)
    return float(np.abs(found - true)[known].max() / np.abs(true).max())


def test_reconstruction(case):
    identified = case.result.dynamics()
    H, c, _ = equations_of_motion(case.true, case.q, case.v)
    assert worst(identified.H_plus(case.q), H) < EXACT
    assert worst(identified.c_plus(case.q, case.v), c) < EXACT
    # In the plane, all but the base's rates about x and y.
    known = np.isfinite(identified.H_plus(case.q[0]))
    hidden = 2 if case.true.motion == "planar" else 0
    assert known.sum() == (case.v.shape[1] - hidden) ** 2


def test_jacobians(case):
    identified = case.result.dynamics()
    point = np.array([0.3, -0.2, 0.5])
    bodies = case.true.bodies
    for body in (bodies[0], bodies[-1]):
        for q in case.q[::10]:
            J = jacobian(case.true, q, body, point)
            assert worst(identified.jacobian(q, body, point), J) < EXACT


def test_exported_urdf(case):
    """Pinocchio makes the true `H+`, `c+` of it; MuJoCo weighs the same."""
    robot = case.result.robot
    text = exported_urdf(exported_robot(case.result).robot)
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    model.gravity.linear = np.zeros(3)
    known = np.array([0, 1, 2, 5]) if robot.motion == "planar" else np.arange(6)
    known = np.append(known, np.arange(6, 6 + len(robot.joints)))
    # Without the wheels, which no URDF of these has.
    true = replace(case.true, wheels=())
    v = case.v[:20, : 6 + len(robot.joints)]
    H, c, _ = equations_of_motion(true, case.q[:20], v)
    for state in zip(case.q, v, H, c, strict=False):
        q, rates, H_k, c_k = map(np.asarray, state)
        H_pin, c_pin = paper_equations(model, robot.joint_names, q, rates)
        assert worst(H_pin[np.ix_(known, known)], H_k[np.ix_(known, known)]) < (
            BY_PINOCCHIO
        )
        assert worst(c_pin[known], c_k[known]) < BY_PINOCCHIO
    spec = mujoco.MjSpec.from_string(text)
    spec.body(robot.bodies[0]).add_freejoint()
    compiled = spec.compile()
    assert compiled.nv == 6 + len(robot.joints)
    assert compiled.body_mass.sum() == pytest.approx(case.true.mass, rel=1e-7)
