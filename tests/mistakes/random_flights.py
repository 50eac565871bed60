"""Random robots with sensors, that float as they should, and a small free-flyer."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
from disturbed import pushed
from drawn_world import drawn_world
from random_motions import Start, random_motion
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_unit_vector,
    sensors_in_space,
)
from recordings import Clean, motion_of

from orbident.recordings.recording import Recording
from orbident.robot.description import Joint, Robot, Wheel
from orbident.robot.parameters import from_mass_com_inertia, inertia_about_com
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.free_floating import BaseState
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import sample_times

ROBOTS, SEEDS = 20, 20
FLYERS = 4
PRISMATIC = 5
"""One robot of so many has a last joint that slides."""

WHEEL_SPEED = 200.0
"""rad/s."""
SHARE = 1e-3
"""A wheel's inertia over the base's: from rest it turns the base at 0.2 rad/s."""


def flights() -> Iterator[str]:
    """The names of the flights: every second robot is on a table."""
    return (f"{'table' if k % 2 else 'space'} {k}" for k in range(ROBOTS))


def flyers() -> Iterator[str]:
    return (f"free-flyer {k}" for k in range(FLYERS))


@cache
def flight(name: str) -> Clean:
    """A robot of this name, and how it moves."""
    kind, number = name.split()
    robot = free_flyer(int(number)) if kind == "free-flyer" else _random(int(number))
    planar = robot.motion == "planar"
    start: Start = "spun up" if planar else "turning"
    trajectory = random_motion(
        robot, int(number), 20.0 if planar else 60.0, WHEEL_SPEED, start
    )
    initial = trajectory.initial
    state = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        initial.wheel_speeds(robot.wheel_names),
    )
    t = sample_times(trajectory.duration, robot.sensors.rows_per_second)
    true = motion_of(robot, trajectory, state, t)
    return Clean(robot, trajectory, state, t, true, "at-rest" if planar else "unknown")


def recorded(clean: Clean, seed: int, *, acting: bool = False) -> Recording:
    """The recording of a flight, with the noise, and the world, of this seed."""
    true = pushed(clean, drawn_world(clean, seed)) if acting else clean.true
    return measure_truth(clean.robot, clean.t, true, seed)


def _random(number: int) -> Robot:
    """2 to 6 joints, 1 to 3 wheels, and a base 5 to 30 times as heavy as a link."""
    random = np.random.default_rng(1000 + number)
    joints = int(random.integers(2, 7))
    parents = random_parents(random, joints)
    slides = (joints - 1,) if number % PRISMATIC == PRISMATIC - 1 else ()
    planar = number % 2 == 1
    robot = (random_planar_robot if planar else random_robot)(number, parents, slides)
    theta = robot.theta.copy()
    theta[0] *= random.uniform(5.0, 30.0)
    wheels = int(random.integers(1, 4))
    size = SHARE * float(np.trace(inertia_about_com(theta[0]))) / 3
    z = np.array([0.0, 0.0, 1.0])
    return replace(
        robot,
        theta=theta,
        wheels=tuple(
            Wheel(f"rw{k + 1}", z if planar else random_unit_vector(random), size)
            for k in range(wheels)
        ),
        sensors=declared_sensors(
            _on_table(random) if planar else sensors_in_space(random)
        ),
    )


def _on_table(random: np.random.Generator) -> dict:
    """Motion capture and encoders, better or worse; SI."""
    worse = float(random.uniform(0.5, 2.0))
    return {
        "rate": 50.0,
        "joints": {"position": worse * 2e-4},
        "wheels": {"position": 2e-4},
        "attitude": {"angle": worse * math.radians(0.02)},
        "position": {"std": worse * 1e-4},
    }


def free_flyer(number: int) -> Robot:
    """10 kg with a light arm and two impellers on one axis; S is 2 mm from the CM, so
    that it moves by no more than 0.6 mm/s, and positions are 0.5 to 1 mm noisy."""
    x, y, z = np.eye(3)
    upper, lower = (np.diag(I) for I in ([0.03, 0.03, 0.03], [0.01, 0.01, 0.01]))
    return Robot(
        name=f"free-flyer-{number}",
        motion="spatial",
        bodies=("base", "upper", "lower"),
        joints=(
            Joint("proximal", "revolute", 0, -y, np.eye(3), -0.12 * x, (-2.1, 1.57)),
            Joint("distal", "revolute", 1, z, np.eye(3), -0.1 * x, (-1.57, 1.57)),
        ),
        theta=np.array(
            [
                from_mass_com_inertia(9.4, -0.002 * z, np.diag([0.17, 0.16, 0.18])),
                from_mass_com_inertia(0.16, np.zeros(3), upper),
                from_mass_com_inertia(0.22, np.array([-0.03, 0.0, -0.025]), lower),
            ]
        ),
        feature_point=np.zeros(3),
        wheels=(Wheel("port", y, 5e-4), Wheel("starboard", y, 5e-4)),
        sensors=declared_sensors(
            {
                "rate": 20.0,
                "gyro": {
                    "angle_random_walk": math.radians(0.1) / 60,
                    "bias_instability": math.radians(3.0) / 3600,
                },
                "joints": {"position": 5e-4},
                "wheels": {"position": 5e-4},
                "attitude": {"angle": math.radians(0.05)},
                "position": {"std": 5e-4 * (1 + number / (FLYERS - 1))},
            }
        ),
    )
