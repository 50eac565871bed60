"""Kinds of mistakes in what is said of the motion: pushes, changes, starts."""

from dataclasses import replace

import numpy as np
from captured_bodies import CapturedBody, holding, truth_through_change
from drawn import Kind, Random, between, direction, either, middle
from mistake import Mistake
from recordings import Clean
from spoiled import Spoiled, spoiled
from wrong_motions import (
    acceleration,
    burst,
    drag,
    loose,
    spun_down,
    torque,
    turning_already,
)
from wrong_sensors import flexible

from orbident.trajectories.trajectory import Trajectory

CHANGED = "chang*|captur*|releas*"
TURNED = "torque|disturb*|external"


def thruster_burst(clean: Clean, random: Random) -> Mistake:
    start, dt = middle(clean, random), clean.t[1] - clean.t[0]
    size = either(random) * between(random, 0.3, 3.0)
    duration = round(between(random, 0.2, 1.0) / dt) * dt
    return Mistake(
        f"{size:g} N for {duration:g} s at {start:g} s",
        burst(size, start, duration),
        "thrust*|burst|force|push|pull|impuls*",
    )


def steady_torque(clean: Clean, random: Random) -> Mistake:
    size = between(random, *((1e-3, 1e-2) if clean.space else (1e-4, 1e-3)))
    return Mistake(f"steady torque {size:g} N m", torque(size), TURNED)


def slow_torque(clean: Clean, random: Random) -> Mistake:
    size = between(random, *((3e-3, 5e-2) if clean.space else (1e-4, 1e-3)))
    period = between(random, 8.0, 25.0)
    return Mistake(
        f"torque {size:g} N m over {period:g} s", torque(size, period), TURNED
    )


def captured(clean: Clean, random: Random) -> Mistake:
    """A ball on the last body."""
    middle_of = middle(clean, random)
    mass = between(random, 0.05, 0.5) * float(clean.robot.theta[-1, 0])
    target = CapturedBody(mass, 0.2 * direction(clean, random), 1e-3 * mass * np.eye(3))
    return _changed(clean, target, middle_of, f"{mass:.2g} kg captured")


def released(clean: Clean, random: Random) -> Mistake:
    middle_of = middle(clean, random)
    mass = -between(random, 0.05, 0.2) * float(clean.robot.theta[-1, 0])
    com = clean.robot.theta[-1, 1:4] / clean.robot.theta[-1, 0]
    target = CapturedBody(mass, com, 1e-3 * mass * np.eye(3))
    return _changed(clean, target, middle_of, f"{-mass:.2g} kg released")


def _changed(clean: Clean, target: CapturedBody, at: float, name: str) -> Mistake:
    after = holding(clean.robot, target)

    def spoil(clean: Clean) -> Spoiled:
        assert isinstance(clean.joints, Trajectory)
        true = truth_through_change(clean.robot, after, clean.joints, at, clean.t)
        wrong = spoiled(clean, recording=clean.recorded(true))
        return replace(wrong, true=(clean.robot, after))

    return Mistake(f"{name} at {at:g} s", spoil, CHANGED)


def table_tilted(clean: Clean, random: Random) -> Mistake:
    size = between(random, 3e-4, 3e-3)
    return Mistake(
        f"table {100 * size:.1g} mrad off level",
        acceleration(size),
        "force|pull|level",
    )


def slow_drag(clean: Clean, random: Random) -> Mistake:
    seconds = between(random, 200.0, 2e3)
    return Mistake(
        f"drag over {seconds:g} s",
        drag(seconds),
        "drag|friction|torque|disturb*|external",
    )


def loose_mass(clean: Clean, random: Random) -> Mistake:
    part, size = between(random, 0.005, 0.02), between(random, 0.01, 0.03)
    period = between(random, 3.0, 10.0)
    return Mistake(
        f"{100 * part:g} % of the base slides {1000 * size:g} mm over {period:g} s",
        loose(part, size, period),
        "loose|moves|moving|slosh*",
    )


def wheels_slow_down(clean: Clean, random: Random) -> Mistake:
    part = between(random, 0.02, 0.2)
    return Mistake(
        f"wheels lose {100 * part:g} %, recorded as constant",
        spun_down(part),
        "wheel speed",
    )


def not_at_rest(clean: Clean, random: Random) -> Mistake:
    rate = either(random) * between(random, 0.01, 0.05)
    return Mistake(f"turning at {rate:g} rad/s before", turning_already(rate), "rest")


def soft_joints(clean: Clean, random: Random) -> Mistake:
    hertz = between(random, 1.5, 4.0)
    return Mistake(
        f"joints give way at {hertz:g} Hz",
        flexible(hertz),
        "flexib*|elastic|stiff* joint",
    )


KINDS = (
    Kind(thruster_burst),
    Kind(steady_torque),
    Kind(slow_torque),
    Kind(captured),
    Kind(released),
    Kind(table_tilted, space=False),
    Kind(slow_drag),
    Kind(loose_mass),
    Kind(wheels_slow_down),
    Kind(not_at_rest, table=False),
    Kind(soft_joints),
)
