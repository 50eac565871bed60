"""Flights of one random robot: every one moves in its own way."""

from dataclasses import replace

import numpy as np
from random_flights import flight
from random_motions import random_motion
from recordings import Clean, motion_of

from orbident.recordings.recording import Recording
from orbident.robot.parameters import from_mass_com_inertia
from orbident.simulation.free_floating import BaseState
from orbident.simulation.measure import measure_truth

FLIGHTS = 3


def flights_of(name: str) -> list[Clean]:
    """Flights of the robot of this name, the first as `flight` has it."""
    return [flight(name), *(_another(flight(name), k) for k in range(1, FLIGHTS))]


def _another(first: Clean, number: int) -> Clean:
    robot = first.robot
    trajectory = random_motion(
        robot,
        100 * number,
        float(first.t[-1]),
        200.0,
        "spun up" if robot.motion == "planar" else "turning",
    )
    initial = trajectory.initial
    start = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        initial.wheel_speeds(robot.wheel_names),
    )
    true = motion_of(robot, trajectory, start, first.t)
    return replace(first, joints=trajectory, start=start, true=true)


def with_payload(clean: Clean, share: float) -> Clean:
    """The same motion, a body of this share of the mass on the last link."""
    robot, mass = clean.robot, share * clean.robot.mass
    theta = robot.theta.copy()
    theta[-1] += from_mass_com_inertia(
        mass, np.array([0.1, 0.02, 0.0]), 0.01 * mass * np.eye(3)
    )
    heavier = replace(robot, theta=theta)
    return replace(clean, true=motion_of(heavier, clean.joints, clean.start, clean.t))


def recorded(flights: list[Clean], seed: int) -> list[Recording]:
    """Recordings with noise of their own, named `first`, `second` and `third`."""
    names = ("first", "second", "third")
    return [
        replace(
            measure_truth(each.robot, each.t, each.true, FLIGHTS * seed + k),
            source=f"{names[k]}.csv",
        )
        for k, each in enumerate(flights)
    ]
