"""Wheels that spin on a link or in a gimbal, flown by MuJoCo.

Such a wheel is a measured joint of the model, and so is its gimbal.
"""

from dataclasses import replace

import numpy as np
import pytest
from acting_in_mujoco import Torque
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import random_robot, random_wheels, sensors_in_space

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import NO_ROTOR, Robot
from orbident.robot.parameters import Structure, from_mass_com_inertia
from orbident.robot.sensor_schema import declared_sensors
from orbident.trajectories.trajectory import Trajectory

SPEED, DURATION = 200.0, 60.0
"""rad/s of the wheel that spins, and of those on the base; s."""

GIMBAL, LINK = (0, 0, 2), (0, 1, 2)
"""Parents of the joints: an arm, a gimbal and its wheel; an arm and a wheel on it."""

FAR = 4.0
"""Deviations."""


def flying(seed: int, parents: tuple[int, ...]) -> Robot:
    """The last joint spins a wheel of 5 kg and 0.05 kg m^2; others give a scale."""
    wheels = random_wheels(seed, ("held",) * 3)
    robot = random_robot(seed, parents, wheels=wheels, base=20.0)
    theta, z = robot.theta.copy(), np.array([0.0, 0.0, 1.0])
    theta[-1] = from_mass_com_inertia(5.0, np.zeros(3), np.diag([0.03, 0.03, 0.05]))
    return replace(
        robot,
        theta=theta,
        joints=(*robot.joints[:-1], replace(robot.joints[-1], axis=z)),
        rotors=dict.fromkeys(robot.joint_names, NO_ROTOR),
        structure={"link3": Structure(com_on_axis="z", principal_axes=True)},
        sensors=declared_sensors(sensors_in_space(np.random.default_rng(1))),
        disturbances={},
    )


def spinning(robot: Robot, seed: int) -> Trajectory:
    """Joints move at random, and the last one at a constant speed."""
    motion = random_motion(robot, seed, DURATION, SPEED, "turning")
    a, b, start, end = (
        x.copy() for x in (motion.a, motion.b, motion.start, motion.end)
    )
    a[-1] = b[-1] = 0.0
    start[-1], end[-1] = [0.0, SPEED, 0.0], [DURATION * SPEED, SPEED, 0.0]
    return replace(motion, a=a, b=b, start=start, end=end)


def off(seed: int, parents: tuple[int, ...]) -> np.ndarray:
    """Errors of the base parameters in their deviations; CAD is off by 10 %."""
    plant, random = flying(seed, parents), np.random.default_rng(seed)
    cad = 1 + 0.1 * random.uniform(-1, 1, (len(plant.bodies), 1))
    recording = Flight(plant, spinning(plant, seed), Torque(np.zeros(3))).recorded(seed)
    result = identify(replace(plant, theta=cad * plant.theta), recording)
    assert result.level == "trust"
    beta = minimal_sets(plant).beta(plant.theta)
    return (result.base.values - beta) / result.base.std


@pytest.mark.parametrize(
    "parents", [GIMBAL, pytest.param(LINK, marks=pytest.mark.slow)]
)
def test_identified(parents):
    assert np.abs(off(0, parents)).max() < FAR


@pytest.mark.long
@pytest.mark.parametrize("parents", [GIMBAL, LINK])
def test_intervals_hold(parents):
    every = np.concatenate([off(seed, parents) for seed in range(20)])
    held = np.mean(np.abs(every) < 1.96)
    print(f"{100 * held:.1f} % of {every.size}, worst {np.abs(every).max():.1f}")
    # Numbers of one flight are correlated: of 20, hundreds count as about 100.
    assert held == pytest.approx(0.95, abs=0.05)
