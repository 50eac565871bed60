"""Torques that sensors at joints show, as means over shooting intervals.

Their equations stand in `joint_torques.hpp`: what a mean torque adds up to is what the
joint's momentum gains, beside friction and what the motor's rotor takes. Samples have
independent noise, and a mean over `T` of samples `dt` apart has that of one of them
times `sqrt(dt / T)`: two intervals share the sample between them, half of it each, so
that sums over many intervals are as sure as this says.
"""

from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline

from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.levels import ChiSquare
from orbident.estimation.output_error.sensors import (
    TORQUES,
    Sensors,
    some_of,
    torque_column,
)
from orbident.estimation.output_error.shooting import Intervals
from orbident.estimation.unknowns import DRIVE, CalibrationFit, DriveFit
from orbident.model.core_robot import friction_of, rotors_of
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot
from orbident.robot.joint_schema import driven_alone

STANDING = 1e-2
"""Part of its root mean square rate below which a joint counts as standing: its brake
or sticking friction may hold it then, with a torque that no equation has."""

COMPLETE = 0.9
"""Part of the samples that an interval must have: splines fill in single ones."""

HELD = 0.0, 0.0
"""The error of what is taken as the robot file declares it, and its deviation."""


class MeanTorques(NamedTuple):
    """As the core takes them, at the first row of each interval."""

    values: Float[np.ndarray, "rows joints"]
    """Means over the interval, N m or N; zero elsewhere."""
    weights: Float[np.ndarray, "rows joints"]
    """1 over their deviations; zero where nothing counts."""
    over_intervals: Float[np.ndarray, "intervals joints 2"]
    """The mean of the sign of the joint's rate, and the rate of the torque."""


def mean_torques(
    robot: Robot, samples: Samples, sensors: Sensors, intervals: Intervals
) -> MeanTorques:
    """What was measured of torques, by interval.

    Args:
        robot: its couplings and passive joints have constraints that nobody measures.
        samples: which joints were locked, and what pushed the robot.
        sensors: with torques or without.
        intervals: of the recording.

    Raises:
        InputError: a thruster's force acts, of which joints feel a part.
    """
    edges, K = intervals.edges, len(robot.joints)
    none = np.zeros((intervals.t.size, K))
    found = MeanTorques(none, none, np.zeros((edges.size - 1, K, 2)))
    if TORQUES not in sensors.by_name:
        return found
    if any(each.force.any() for each in samples.wrenches):
        raise InputError(
            f"{samples.source}: joint torques were recorded, and thrust pulls at the "
            "joints, which is not in their equations; use a part of the recording "
            "without thrust (--from, --to), or leave out these columns"
        )
    sensed, history = sensors.by_name[TORQUES], intervals.history
    inside = (history.t[0] <= sensors.t) & (sensors.t <= history.t[-1])
    seen = inside & np.isfinite(sensed.values).all(axis=1)
    t, torque = some_of(sensors.t, seen), some_of(sensed.values, seen)
    if t.size < 2:
        return found
    rate = history.at(history.qd, history.qdd, t)
    shown = CubicSpline(t, torque)
    # The samples have the sign of the rate at their times: it takes the same spline.
    sums = [each.antiderivative() for each in (shown, CubicSpline(t, np.sign(rate)))]
    slow = np.abs(rate) < STANDING * np.sqrt(np.mean(rate**2, axis=0))
    bounds, dt = intervals.boundaries, float(np.median(np.diff(t)))
    first, length = edges[:-1], np.diff(bounds)
    lasts = np.where(length > 0, length, 1.0)[:, None]
    means = [np.diff(each(bounds), axis=0) / lasts for each in sums]
    changed = np.diff(shown(bounds), axis=0) / lasts
    counts = _that_count(robot, samples, torque)
    weights = np.zeros(changed.shape)
    begin, end = samples.pushed or (np.inf, -np.inf)
    for k, (start, stop) in enumerate(pairwise(bounds)):
        rows = slice(*np.searchsorted(t, (start, stop), side="left"))
        whole = t[0] <= start and stop <= t[-1] and length[k] > 0
        if not whole or rows.stop - rows.start < COMPLETE * length[k] / dt:
            continue
        if start < end and begin < stop:
            continue
        stands = (slow[rows][1:] & slow[rows][:-1]).any(axis=0)
        weights[k] = counts & ~stands
    values, at_rows = none.copy(), none.copy()
    values[first], at_rows[first] = means[0], weights * np.sqrt(lasts / dt) / sensed.std
    return MeanTorques(values, at_rows, np.stack([means[1], changed], axis=-1))


def _that_count(
    robot: Robot, samples: Samples, torque: Float[np.ndarray, "n joints"]
) -> Bool[np.ndarray, " joints"]:
    """Joints whose torque is measured, and that nothing else moves or holds."""
    free = {*driven_alone(robot)} - {*samples.locked}
    return np.any(torque, axis=0) & [name in free for name in robot.joint_names]


def joints_driven(
    robot: Robot, weights: Float[np.ndarray, "rows joints"]
) -> tuple[str, ...]:
    """The columns of torques that count."""
    counts = np.asarray(weights.any(axis=0))
    names = zip(robot.joint_names, counts, strict=True)
    return tuple(torque_column(name) for name, some in names if some)


def driven_by(robot: Robot) -> Float[np.ndarray, "joints 4"]:
    """What a robot file says of rotors and friction, as the core takes it; SI."""
    return np.column_stack([rotors_of(robot).armature, friction_of(robot)])


def drives_of(
    robot: Robot, errors: Mapping[str, CalibrationFit], driven: Collection[str]
) -> dict[str, DriveFit]:
    """What joints drive against, from what is off of what is declared.

    Args:
        robot: with its rotors and its friction.
        errors: that were found, by name.
        driven: columns of torques that counted.
    """
    found = {}
    for name, numbers in zip(robot.joint_names, driven_by(robot), strict=True):
        if torque_column(name) not in driven:
            continue
        parts = list[float]()
        for what, declared in zip(DRIVE, numbers, strict=True):
            error, std = errors.get(f"joint.{name}.{what}", (*HELD, 0.0))[:2]
            parts += float(declared + error), std
        found[name] = DriveFit(*parts)
    return found


def possible_motors(drives: Mapping[str, DriveFit]) -> Iterator[Check]:
    """Whether rotors and friction are no less than nothing, as their torques say."""
    for name, fit in drives.items():
        parts = {
            "rotor's inertia": (fit.armature, fit.armature_std),
            "viscous friction": (fit.viscous, fit.viscous_std),
            "Coulomb friction": (fit.coulomb, fit.coulomb_std),
        }
        for what, (value, std) in parts.items():
            square = (value / std) ** 2 if value < 0 and std else 0.0
            if ChiSquare(square, 1).is_no_chance("other parameters"):
                yield Check(
                    "motors",
                    "do not trust",
                    f"the {what} of joint '{name}' would be {value:.3g} +- {std:.1g} "
                    "(SI), by its torques, and none is less than nothing",
                    "check the signs, units and order of the torque columns, and "
                    "whether something else moves or holds the joint, such as a cable",
                )
