"""Two robots with one minimal set, published to show that it is minimal.

Base and two links of 1 m in a plane, from naveen13m/space_robot_parameter_estimation
(`ntua_params.txt`); its authors' simulator flew both through one motion of the joints
(`tor_2a.dat`, `tor_2b.dat`). Joints are 0.5 m from the CM of the base and 1 m apart;
`r` is from a joint to the CM of its link.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
from acting_in_mujoco import Torque
from mujoco_flights import Flight
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.comparison import compare
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import reconstructed
from orbident.robot.description import GearedRotor, Joint, Robot, Wheel
from orbident.robot.parameters import Structure, from_mass_com_inertia
from orbident.robot.sensor_schema import declared_sensors
from orbident.studies.paper_tables import paper_basis, planar_columns

PUBLISHED = np.array([62.5, 20.83, 0.0, 0.0, 1241.67, 43.75, 156.25, 72.9167])
"""In the order of the paper's A.4, kg m^2."""

DIGITS = np.array([5e-5, 5e-3, 1e-9, 1e-9, 5e-3, 5e-5, 5e-5, 5e-5])
"""What their rounding leaves open; `r0` has no y, which makes two of them zero."""

SAME = 2e-7
"""Relative: both robots were found by a search, which stopped that near the set."""

EXACT = 1e-9
"""Relative to the largest, once both are on the set."""

SIZES = {
    "a": (
        (503.899639, 109.7057987, 90.15216512),
        (0.0, 0.7695643366, 0.6453894074),
        (1205.894768, 44.43355118, 40.17615466),
    ),
    "b": (
        (159.7134012, 266.8389805, 345.1412672),
        (0.0, 0.9699719946, 0.5832108791),
        (1210.005403, 32.75090948, 8.027031368),
    ),
}
"""Masses, kg; CMs from the joint of the body, m; inertias about the CMs, kg m^2."""

TORQUES = {
    0.1: (8.542864e-02, -1.180421e-02),
    5.0: (2.683054, -0.1719984),
    10.0: (-0.3790758, -0.3958662),
    15.0: (-2.294932, 0.6999900),
}
"""Published, N m, by the time in s; of both robots but for one in the last digit."""

FAR = 4.0
"""Deviations."""


def robot(name: str, wheel: bool = False, **sensors: dict) -> Robot:
    """One of the two, with encoders and a star tracker as good as exact."""
    m, r, I = SIZES[name]
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    joints = tuple(
        Joint(f"joint{k + 1}", "revolute", k, z, np.eye(3), length * x)
        for k, length in enumerate((0.5, 1.0))
    )
    if wheel:
        sensors = sensors | {"wheels": {"position": 2e-5}}
    shown = {"rate": 10.0, "joints": {"position": 2e-5}, "attitude": {"angle": 1e-5}}
    return Robot(
        name=f"set-2{name}",
        motion="planar",
        bodies=("base", "link1", "link2"),
        joints=joints,
        theta=np.array(
            [from_mass_com_inertia(m[k], r[k] * x, I[k] * np.eye(3)) for k in range(3)]
        ),
        feature_point=np.zeros(3),
        wheels=(Wheel("rw", z, 0.5, "held"),) if wheel else (),
        structure=dict.fromkeys(("link1", "link2"), Structure(com_on_axis="x")),
        rotors={joint.name: GearedRotor(1.0, 0.0, 0.0) for joint in joints},
        sensors=declared_sensors(shown | sensors),
    )


def pi_of(robot: Robot) -> np.ndarray:
    """In the order of A.4."""
    sets = minimal_sets(robot)
    columns = partial(planar_columns, r_joint1=(0.5, 0.0))
    return paper_basis(sets, columns).pi(sets.pi(robot.theta))


def test_both_have_the_published_minimal_set():
    a, b = pi_of(robot("a")), pi_of(robot("b"))
    assert (np.abs(a - PUBLISHED) < DIGITS).all()
    np.testing.assert_allclose(a, b, rtol=SAME, atol=1e-9)


@pytest.mark.parametrize("name", ["a", "b"])
def test_torques_as_published(name):
    """The joints go along cycloids of 20 s; the base floats, and `pi` says it all."""
    plant = robot(name)
    beta = minimal_sets(plant).beta(plant.theta)
    T, s = 20.0, np.array([*TORQUES]) / 20.0
    start, end = np.pi * np.array([[-0.5, 0.25], [0.0, -0.5]])
    turn = 2 * np.pi * s[:, None]
    q = start + (s[:, None] - np.sin(turn) / (2 * np.pi)) * (end - start)
    qd = (1 - np.cos(turn)) / T * (end - start)
    qdd = 2 * np.pi * np.sin(turn) / T**2 * (end - start)
    model = reconstructed(plant, beta, np.zeros((beta.size, beta.size)))
    published = np.array([*TORQUES.values()])
    # As far as a search, seven digits and their simulator's steps go.
    atol = SAME * np.abs(published).max()
    np.testing.assert_allclose(model.torques(q, qd, qdd), published, rtol=0, atol=atol)


def on_the_set_of(other: Robot, moved: Robot) -> Robot:
    """The robot nearest to one of them that has the minimal set of the other."""
    sets, theta = minimal_sets(other), moved.theta.ravel()

    def off(theta: np.ndarray) -> np.ndarray:
        return sets.pi(theta.reshape(-1, 10)) - sets.pi(other.theta)

    for _ in range(3):  # Newton's, of which the first step leaves rounding
        steps = 1e-3 * np.eye(theta.size)
        slopes = [(off(theta + h) - off(theta - h)) / 2e-3 for h in steps]
        theta = theta - np.linalg.lstsq(np.transpose(slopes), off(theta), 1e-8)[0]
    assert np.abs(theta - moved.theta.ravel()).max() < 1e-7 * np.abs(theta).max()
    return replace(moved, theta=theta.reshape(-1, 10))


class Flown(NamedTuple):
    """Both robots, told to do the same, in MuJoCo."""

    truths: tuple
    results: tuple[Result, Result]


def flown(a: Robot, b: Robot) -> Flown:
    truths, results = [], []
    for plant in (a, b):
        motion = random_motion(plant, 1, 40.0, 100.0, "at rest")
        flight = Flight(plant, motion, Torque(np.zeros(3)), breath=0.5)
        truths.append(flight.flown[1])
        results.append(identify(plant, flight.recorded(1)))
    return Flown(tuple(truths), (results[0], results[1]))


@pytest.mark.slow
def test_position_alone_tells_them_apart():
    """Attitude and torques are the same, and so is `pi`; `phi` and the mass are not."""
    one, other = (
        robot(name, position={"std": 1e-4}, torques={"std": 0.01}) for name in SIZES
    )
    (a, b), (of_a, of_b) = flown(one, other)
    np.testing.assert_allclose(a.attitude, b.attitude, rtol=0, atol=SAME)
    np.testing.assert_allclose(a.tau, b.tau, rtol=0, atol=SAME * np.abs(a.tau).max())
    assert np.abs(a.position - b.position).max() > 0.1
    assert of_a.level == of_b.level == "trust"
    std = np.hypot(of_a.pi.std, of_b.pi.std)
    assert (np.abs(of_a.pi.values - of_b.pi.values) < FAR * std).all()
    for found, (m, _, _) in zip((of_a, of_b), SIZES.values(), strict=True):
        assert abs(found.mass.value - sum(m)) < FAR * found.mass.std
    assert compare(of_a, of_b).status != "no change"


def alike(of_a: Result, of_b: Result) -> None:
    """Both have `pi`, which is the same, and no mass that would tell them apart."""
    for result in (of_a, of_b):
        assert result.level == "with care"
        assert "phi and the mass are not determined" in result.warnings[0]
        assert np.isnan([result.mass.value, *result.phi.values]).all()
        assert not any("torques of" in words for words in result.warnings)
    found = compare(of_a, of_b)
    assert (found.status, found.of) == ("no change", "pi")
    assert found.change is not None
    # Eight of `pi` depend on seven numbers.
    assert found.change.dof == 7


@pytest.mark.slow
def test_torques_without_positions():
    """They give `pi` its scale, not the mass."""
    torques = {"std": 0.01}
    results = flown(robot("a", torques=torques), robot("b", torques=torques)).results
    alike(*results)
    for result in results:
        pi = minimal_sets(result.robot).pi(result.robot.theta)
        assert (np.abs(result.pi.values - pi) < FAR * result.pi.std).all()


@pytest.mark.slow
def test_without_positions_nothing_tells_them_apart():
    """Both are identified from one CAD model, that of the first."""
    one = robot("a", wheel=True)
    motion = random_motion(one, 1, 40.0, 100.0, "at rest")
    of_a, of_b = (
        identify(
            one, Flight(plant, motion, Torque(np.zeros(3)), breath=0.5).recorded(1)
        )
        for plant in (one, on_the_set_of(one, robot("b", wheel=True)))
    )
    alike(of_a, of_b)
    # The noise is the same, so that only the robots could make a difference.
    apart = np.abs(of_a.pi.values - of_b.pi.values)
    assert (apart < EXACT * 1241.67).all()
    assert (apart < 1e-6 * of_a.pi.std).all()
