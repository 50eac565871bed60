"""Random robots in space and on a table, each with one thing acting from outside."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from acting_in_mujoco import Acts, Burst, Capture, Film, Swell, Tilt, Torque
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_unit_vector,
    sensors_in_space,
)

from orbident.estimation.linear_fits import InitialMomentum
from orbident.robot.description import Robot, Wheel
from orbident.robot.parameters import inertia_about_com
from orbident.robot.sensor_schema import declared_sensors

G = 9.81
"""m/s^2."""

Z = np.array([0.0, 0.0, 1.0])

IN_SPACE, ON_TABLE = 60.0, 20.0
"""Durations, s."""

SPEED = 200.0
"""Of the wheels, rad/s."""

SHARE = 1e-3
"""A wheel's inertia over the base's."""

DESIGN = 0.1
"""A body is up to so much heavier or lighter than the robot file says."""


@dataclass(frozen=True, eq=False)
class Case:
    """A flight that is to be identified, and what is true of it."""

    name: str
    number: int
    """Of the robot and its motion: even ones are in space."""
    acting: Callable[[Robot], Acts]
    """What acts on this robot."""
    longer: float = 1.0
    """The flight's duration over the usual one."""
    breath: float = 0.0
    """The wheels' speeds change by this part: on a table nothing else tells the scale
    where the momentum is unknown, as after a capture."""

    @cached_property
    def flight(self) -> Flight:
        robot = robot_of(self.number)
        planar = robot.motion == "planar"
        duration = self.longer * (ON_TABLE if planar else IN_SPACE)
        start = "spun up" if planar else "turning"
        motion = random_motion(robot, 3000 + self.number, duration, SPEED, start)
        return Flight(robot, motion, self.acting(robot), self.breath)

    @property
    def known(self) -> Robot:
        """What the user knows: all but the bodies, of which there is a CAD model."""
        robot = self.flight.robot
        random = np.random.default_rng(4000 + self.number)
        off = 1 + DESIGN * random.uniform(-1, 1, (len(robot.bodies), 1))
        return replace(robot, theta=off * robot.theta)

    @property
    def initial_momentum(self) -> InitialMomentum:
        """On the table the robot was at rest before its wheels spun up."""
        return "unknown" if self.number % 2 == 0 else "at-rest"


def robot_of(number: int) -> Robot:
    """3 to 5 joints, 1 to 3 wheels, and a base 5 to 20 times as heavy as a link."""
    random = np.random.default_rng(2000 + number)
    planar = number % 2 == 1
    joints = int(random.integers(2, 5)) if planar else int(random.integers(3, 6))
    parents = random_parents(random, joints)
    slides = (joints - 1,) if number % 5 == 4 else ()
    robot = (random_planar_robot if planar else random_robot)(
        5000 + number, parents, slides
    )
    theta = robot.theta.copy()
    theta[0] *= random.uniform(5.0, 20.0)
    size = SHARE * float(np.trace(inertia_about_com(theta[0]))) / 3
    wheels = tuple(
        Wheel(f"rw{k + 1}", Z if planar else random_unit_vector(random), size)
        for k in range(int(random.integers(1, 4)))
    )
    bodies = random.choice(len(robot.bodies), 2, replace=False) if planar else ()
    pads = {
        robot.bodies[k]: np.append(0.05 * random.standard_normal(2), 0.0)
        for k in sorted(bodies)
    }
    given = _motion_capture(random) if planar else sensors_in_space(random)
    sensors = declared_sensors(given)
    return replace(robot, theta=theta, wheels=wheels, pads=pads, sensors=sensors)


def _motion_capture(random: np.random.Generator) -> dict:
    """Cameras whose error of place lasts for half a second, and encoders; SI."""
    worse = float(random.uniform(0.5, 2.0))
    return {
        "rate": 50.0,
        "joints": {"position": worse * 1e-4},
        "wheels": {"position": 1e-4},
        "attitude": {"angle": worse * 2e-4},
        "position": {
            "std": worse * 2e-5,
            "markov_std": worse * 2e-5,
            "correlation_time": 0.5,
        },
    }


def _always(acts: Acts) -> Callable[[Robot], Acts]:
    return lambda robot: acts


def _film(*drag: tuple[float, float]) -> Callable[[Robot], Acts]:
    """Under the robot's pads, N s/m and N m s."""
    return lambda robot: Film(robot.pads, dict(zip(robot.pads, drag, strict=True)))


def _capture(at: float, mass: float) -> Callable[[Robot], Acts]:
    """By the last link."""
    com, inertia = np.array([0.2, 0.1, 0.0]), mass * np.diag([0.02, 0.03, 0.04])
    return lambda robot: Capture(at, robot.bodies[-1], mass, com, inertia)


def _milli(*vector: float) -> np.ndarray:
    return 1e-3 * np.array(vector)


EAST = np.array([0.8, 0.6, 0.0])

KINDS = (
    Case("constant torque, 2 mN m", 2, _always(Torque(_milli(1.2, -1.0, 1.2)))),
    Case("constant torque, 20 mN m", 4, _always(Torque(_milli(-8.0, 16.0, 9.0)))),
    Case("slow torque, 3 mN m", 6, _always(Swell(_milli(2.0, 1.0, -2.0), 47.0, 0.4))),
    Case("slow torque, 10 mN m", 8, _always(Swell(_milli(-6.0, 0.0, 8.0), 95.0, 2.0))),
    Case(
        "body-fixed torque, 3 mN m",
        10,
        _always(Torque(_milli(1.0, 2.0, -2.0), "base")),
    ),
    Case(
        "body-fixed torque, 10 mN m",
        12,
        _always(Torque(_milli(6.0, -8.0, 0.0), "base")),
    ),
    Case(
        "burst, 1 N for 0.2 s",
        14,
        _always(Burst(33.0, 0.2, EAST, np.array([0.3, -0.2, 0.1]))),
    ),
    Case("capture of 6 kg", 16, _capture(53.0, 6.0), 2.0),
    Case("constant torque, 1 mN m", 1, _always(Torque(_milli(0.0, 0.0, 1.0)))),
    Case("slow torque, 3 mN m", 3, _always(Swell(_milli(0.0, 0.0, 3.0), 17.0, 1.0))),
    Case("air film, 8 mN s/m", 5, _film((8e-3, 3e-4), (5e-3, 1e-4))),
    Case("air film, 3 mN s/m", 7, _film((3e-3, 1e-4), (2e-3, 5e-5))),
    Case("tilt of 10 urad", 9, _always(Tilt(G * 10e-6 * EAST))),
    Case("tilt of 100 urad", 11, _always(Tilt(G * 100e-6 * np.cross(Z, EAST)))),
    Case("tilt of 30 urad", 13, _always(Tilt(-G * 30e-6 * EAST))),
    Case(
        "burst, 1 N for 0.2 s",
        15,
        _always(Burst(8.0, 0.2, -EAST, np.array([0.2, 0.2, 0.0]))),
    ),
    Case("capture of 5 kg", 17, _capture(23.0, 5.0), 2.0, breath=0.5),
)
"""What acts, in space and on a table, on the first robots."""

OTHERS = 20
"""Robots of a draw have numbers from so many times its own on."""


@cache
def cases(draw: int) -> tuple[Case, ...]:
    """The flights of a draw: other robots, motions and noise, the same acts."""
    return tuple(replace(kind, number=OTHERS * draw + kind.number) for kind in KINDS)
