"""A free-flyer that grasps a payload of 8 kg, flown by MuJoCo before and after.

Robot and payload are from albee/free-flyer-adaptive-control, with a paper at SciTech
2021. Its adaptive controller follows its path, while its estimate of the payload ends
at 19.8 kg (`plot/resultsAdaptiveStep.mat`, fifth run). The wheel is ours: it gives the
scale that thrusters give there.
"""

from dataclasses import replace

import numpy as np
import pytest
from acting_in_mujoco import Torque
from made_results import joined
from mujoco_flights import Flight
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.identified.comparison import compare
from orbident.robot.description import GearedRotor, Joint, Robot, Wheel
from orbident.robot.parameters import Structure, from_mass_com_inertia
from orbident.robot.sensor_schema import declared_sensors

PAYLOAD = from_mass_com_inertia(8.0, np.array([0.3, 0.0, 0.0]), np.zeros((3, 3)))
"""A point at the end of link 2."""

SEEN = [0, 1, 2, 9]
"""Of the ten parameters of a body, those that show in the plane: m, mx, my, Izz."""

FAR = 4.0
"""Deviations."""


def free_flyer() -> Robot:
    """Base 10 kg and 0.1 kg m^2; two links of 1 kg, 0.05 kg m^2 and 0.3 m."""
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    link = from_mass_com_inertia(1.0, 0.15 * x, 0.05 * np.eye(3))
    joints = tuple(
        Joint(f"joint{k + 1}", "revolute", k, z, np.eye(3), length * x)
        for k, length in enumerate((0.145, 0.3))
    )
    sensors = {
        "rate": 20.0,
        "joints": {"position": 1e-4},
        "wheels": {"position": 1e-4},
        "attitude": {"angle": 2e-4},
        "position": {"std": 1e-3},
    }
    return Robot(
        name="free-flyer",
        motion="planar",
        bodies=("base", "link1", "link2"),
        joints=joints,
        theta=np.array(
            [from_mass_com_inertia(10.0, 0 * x, 0.1 * np.eye(3)), link, link]
        ),
        feature_point=np.zeros(3),
        wheels=(Wheel("rw", z, 2e-3, "held"),),
        # Of link 2 nothing is known: it may hold something.
        structure={"link1": Structure(com_on_axis="x")},
        rotors={joint.name: GearedRotor(1.0, 0.0, 0.0) for joint in joints},
        sensors=declared_sensors(sensors),
        disturbances={},
    )


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(0, marks=pytest.mark.slow),
        *(pytest.param(k, marks=pytest.mark.long) for k in range(1, 5)),
    ],
)
def test_the_payload_is_what_was_grasped(seed):
    robot, random = free_flyer(), np.random.default_rng(seed)
    cad = 1 + 0.1 * random.uniform(-1, 1, (len(robot.bodies), 1))
    known, results = replace(robot, theta=cad * robot.theta), []
    for flight, plant in enumerate((robot, joined(robot, "link2", PAYLOAD))):
        motion = random_motion(plant, seed, 60.0, 200.0, "at rest")
        flown = Flight(plant, motion, Torque(np.zeros(3)), breath=0.5)
        results.append(identify(known, flown.recorded(2 * seed + flight)))
        assert results[-1].level == "trust"
    found = compare(*results)
    assert (found.status, found.body, found.warnings) == ("changed", "link2", ())
    assert found.added is not None
    m = found.added.mass
    print(f"{m.value:.4f} +- {m.std:.4f} kg")
    assert m.std < 0.01
    off = (found.added.theta - PAYLOAD)[SEEN]
    std = np.sqrt(np.diag(found.added.covariance)[SEEN])
    assert (np.abs(off) < FAR * std).all()
