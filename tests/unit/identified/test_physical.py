"""Bodies that can exist, and the URDF they are written to."""

import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_results import REFUSED, exact_result
from random_motions import random_motion
from servicer import load_servicer

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.exported_robot import (
    exported_robot,
    exported_urdf,
    links_of,
    parts_of_base,
    wheel_joints,
)
from orbident.identified.physical import PhysicalBodies, physical_bodies
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_matrix
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.control import off_by


def bodies_of(result: Result, apart: np.ndarray) -> PhysicalBodies | None:
    return physical_bodies(result, apart, result.base_covariance)


@pytest.fixture(scope="module")
def found() -> Result:
    """`paper-spatial`, identified without noise; its nominal inertia is 20 % off."""
    robot = load_robot("paper-spatial")
    recording = simulate(robot, random_motion(robot))
    return identify(off_by(robot, 0.2, seed=1), recording, "least-squares")


def with_base(result: Result, values: np.ndarray, std: np.ndarray) -> Result:
    """The same result with other base parameters, independent of one another."""
    C = np.diag(std**2)
    base = replace(result.base, values=values, std=std, covariance=C)
    return replace(result, base=base)


def smallest_eigenvalue(theta_i: np.ndarray) -> float:
    """Smallest eigenvalue of the pseudo-inertia, with first moments over lengths of a
    metre."""
    I = inertia_matrix(theta_i)
    P = np.zeros((4, 4))
    P[:3, :3] = np.trace(I) / 2 * np.eye(3) - I
    P[3, :3] = P[:3, 3] = theta_i[1:4]
    P[3, 3] = theta_i[0]
    return float(np.linalg.eigvalsh(P)[0])


def beta_error(robot: Robot, theta: np.ndarray, beta: np.ndarray) -> float:
    off = minimal_sets(robot).beta(theta) - beta
    return float(np.abs(off).max() / np.abs(beta).max())


def test_exact_parameters_are_met_exactly(found):
    robot, beta = found.robot, found.base.values
    bodies = bodies_of(found, np.zeros_like(robot.theta))
    assert bodies is not None
    assert bodies.deviation == 0.0
    assert beta_error(robot, bodies.theta, beta) < 1e-12
    assert min(map(smallest_eigenvalue, bodies.theta)) > 0
    # What structure makes zero is.
    known = np.delete(bodies.theta.ravel(), robot.free_parameters)
    assert not known.any()


def test_the_nominal_bodies_are_nearest_to_themselves(found):
    """Where they have the identified parameters already."""
    robot = load_robot("paper-spatial")
    true = minimal_sets(robot).beta(robot.theta)
    itself = with_base(replace(found, robot=robot), true, 0 * true)
    bodies = bodies_of(itself, np.zeros_like(robot.theta))
    assert bodies is not None
    # The divergence is flat at its least: 1e-10 of it is 1e-5 of the bodies.
    np.testing.assert_allclose(bodies.theta, robot.theta, rtol=1e-4, atol=1e-4)


def test_units_and_frames_do_not_matter(found):
    """Ten times the mass of everything: ten times the bodies."""
    robot = found.robot
    wheels = tuple(replace(w, inertia=10 * w.inertia) for w in robot.wheels)
    heavier = replace(robot, theta=10 * robot.theta, wheels=wheels)
    scaled = with_base(
        replace(found, robot=heavier), 10 * found.base.values, 10 * found.base.std
    )
    rotors = np.zeros_like(robot.theta)
    light, heavy = (bodies_of(each, rotors) for each in (found, scaled))
    assert light is not None
    assert heavy is not None
    np.testing.assert_allclose(heavy.theta, 10 * light.theta, rtol=1e-4, atol=1e-4)


def test_impossible_parameters_move_within_their_deviations(found):
    """A body has `Iyy - (Izz - Ixx) >= 0`; of link 3, both are identified."""
    names, formulas = found.base.names, found.base.formulas
    assert formulas[names.index("iota_11")] == "Ixx(link3) - Izz(link3)"
    which = names.index("iota_12")
    assert formulas[which] == "Iyy(link3)"
    values = found.base.values.copy()
    values[which] = -values[names.index("iota_11")] - 0.5
    std = 1e-4 * np.abs(values)

    std[which] = 0.4
    bodies = bodies_of(with_base(found, values, std), 0 * found.robot.theta)
    assert bodies is not None
    # 0.5 of 0.4, and a little more: bodies keep a part of their nominal thickness.
    assert bodies.deviation == pytest.approx(1.25, rel=0.1)
    assert min(map(smallest_eigenvalue, bodies.theta)) > 0
    std[which] = 0.01
    assert bodies_of(with_base(found, values, std), 0 * bodies.theta) is None


def test_refusals(found, monkeypatch):
    rotors = np.zeros_like(found.robot.theta)
    rejected = replace(found, checks=(REFUSED,))
    with pytest.raises(InputError, match=r"is refused, .*: mass: no scale; spin"):
        bodies_of(rejected, rotors)
    unknown = found.base.values.copy()
    unknown[-1] = np.nan
    with pytest.raises(InputError, match=r"1 of 18 .*\(iota_12\)"):
        bodies_of(with_base(found, unknown, found.base.std), rotors)
    with pytest.raises(InputError, match="not loaded from a URDF"):
        links_of(replace(found.robot, urdf=""))

    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(InputError, match=r'needs cvxpy: .* "orbident\[export\]"'):
        bodies_of(found, rotors)


@pytest.fixture
def servicer(tmp_path: Path) -> Robot:
    """Fixed links above and below, a rotor, and a feature point off the base link."""
    return load_servicer(tmp_path)


def test_the_urdf_has_the_bodies(servicer, tmp_path):
    """Not only their momentum: read again, `theta` is what was to be written."""
    theta = 1.1 * servicer.theta
    text = exported_urdf(replace(servicer, theta=theta))
    (tmp_path / "servicer.urdf").write_text(text)
    again = load_robot(tmp_path / "servicer.yaml")
    # Moved to the CM and back: rounding of 100 kg m^2.
    np.testing.assert_allclose(again.theta, theta, rtol=1e-13, atol=1e-12)
    assert again.wheels[0].inertia == servicer.wheels[0].inertia
    assert "<!-- kept -->" in text
    links = {link.get("name"): link for link in ET.fromstring(text).iter("link")}
    assert links["world"].find("inertial") is None
    assert links["bus"].find("visual") is not None
    masses = {name: weighed(links[name]) for name in ("deck", "rotor", "tool")}
    assert masses == {"deck": 0.0, "rotor": 3.0, "tool": 0.0}


def weighed(link: ET.Element) -> float:
    mass = link.find("inertial/mass")
    assert mass is not None
    return float(mass.attrib["value"])


def test_the_base_exists_without_its_rotors(servicer):
    """Rotors that are bodies of their own are not for the base to make up for."""
    parts = parts_of_base(servicer, wheel_joints(servicer).values())
    assert parts[0, 0] == 3.0
    assert not parts[1:].any()
    text = exported_urdf(servicer)
    links = {link.get("name"): link for link in ET.fromstring(text).iter("link")}
    assert weighed(links["bus"]) == pytest.approx(102.0)


def test_dynamics_where_no_mechanism_has_the_parameters(found: Result):
    """Those of the nearest bodies: a moment that the recording left open is below zero.

    Where it is below zero for sure there are none, and that is said.
    """
    names = formulas_of(found.robot, minimal_sets(found.robot)).base.names
    beta = found.base.values.copy()
    k = names.index("iota_12")
    Iyy, beta[k] = beta[k], -0.1 * beta[k]
    open_, sure = np.full((2, beta.size), 1e-4)
    open_[k] = Iyy
    near = with_base(found, beta, open_).dynamics()
    assert 0.5 < near.moved < 2.0
    assert "moved by" in repr(near)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (100, 3))
    free = [*range(6 + 3)]
    H = near.H_plus(q)[:, free][:, :, free]
    assert np.linalg.eigvalsh(H).min() > 0
    moved = minimal_sets(found.robot).beta(near.robot.theta) - beta
    assert np.linalg.norm(moved / open_) == pytest.approx(near.moved, rel=0.01)
    with pytest.raises(InputError, match="singular or indefinite"):
        with_base(found, beta, sure).dynamics()


def test_a_joint_that_gives_way(tmp_path):
    """The body between motor and spring is none, and there is no H+ without a rotor."""
    arm = "{parent: base, joint: elbow, axis: [0, 0, 1], mass: 4, inertia: [1, 1, 1]}"
    path = tmp_path / "arm.yaml"
    path.write_text(
        "schema: orbident/robot/1\n"
        f"bodies: {{base: {{mass: 9, inertia: [1, 1, 1]}}, arm: {arm}}}\n"
        "flexible: {elbow: {frequency: 3 Hz}}"
    )
    robot = load_robot(path)
    result = exact_result(robot)
    made = exported_robot(result, without_rotors=True).robot
    assert not made.theta[1].any()
    assert smallest_eigenvalue(made.theta[2]) > 0
    assert beta_error(robot, made.theta, result.base.values) < 1e-9
    with pytest.raises(InputError, match="such as 'elbow's motor'; export a"):
        exported_robot(result)
    with pytest.raises(InputError, match="can turn or slide without moving any"):
        result.dynamics()
