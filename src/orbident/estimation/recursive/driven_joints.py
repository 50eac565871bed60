"""Torques at joints as the filter takes them: their integrals, and how sure these are.

Their equations stand in the core's `driven_joints.hpp`. Only beside wheels are they
taken: the conservation laws have no known term without one, and fit a lighter robot
better, as noise is in their regressors. Torques alone do not outweigh that.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.estimation.output_error.calibration import OF_TORQUES, calibrations_of
from orbident.estimation.output_error.sensors import (
    TORQUES,
    between,
    joints_with_torques,
    torque_column,
)
from orbident.estimation.output_error.torques import STANDING, driven_by
from orbident.gaussian import noisiest_std
from orbident.preprocessing.delays import delays
from orbident.preprocessing.samples import Samples
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.joint_schema import driven_alone

LONGEST = 2.5
"""Steps between samples over which a torque is followed: one may be missing."""

LEAST = 1e-9
"""SI: without noise the weights would be infinite."""


class DrivenJoints(NamedTuple):
    """Joints whose torque is measured, as the core takes them."""

    table: Float[np.ndarray, "driven 13"]
    """A row has a joint's number in the robot, how fast noise of its torque makes its
    momentum walk (N m s/sqrt(s)), and the rate below which it may stand; then armature,
    viscous and Coulomb friction, offset and error of the sensor's scale, as they are
    known beforehand, and the standard deviations of these five; SI."""
    longest: float
    """s from sample to sample over which a torque is followed."""


NO_TORQUES = DrivenJoints(np.zeros((0, 13)), 0.0)
"""No joint has a torque that is measured."""


class Torques(NamedTuple):
    """What a recording shows of torques."""

    driven: DrivenJoints
    impulses: Float[np.ndarray, "samples driven"]
    """Integrals of the torques until each sample, N m s; NaN where they cannot be
    followed from the sample before."""


def torques_of(
    robot: Robot, recording: Recording, samples: Samples, late: Mapping[str, float]
) -> Torques:
    """The torques of joints that are measured, and that nothing else moves or holds.

    There are none where a thruster's force acts, of which joints feel a part, nor
    without a wheel.

    Args:
        robot: with its tolerances of torque sensors, rotors and friction.
        recording: with columns of torques or without.
        samples: of it.
        late: by sensor, by how much its times are behind the gyro's, s.
    """
    free = {*driven_alone(robot)} - {*samples.locked}
    shown = [
        name
        for name in joints_with_torques(robot, recording)
        if name in free and np.nan_to_num(recording.columns[torque_column(name)]).any()
    ]
    if not robot.wheels or any(each.force.any() for each in samples.wrenches):
        shown = []
    behind = delays(robot, recording, late)[TORQUES]
    parts, impulses = list[list[float]](), list[np.ndarray]()
    declared, t = driven_by(robot), samples.t
    longest = LONGEST * float(np.median(np.diff(t)))
    errors = {
        each.name: each.std
        for each in calibrations_of(robot, [torque_column(name) for name in shown])
    }
    for name in shown:
        k, values = (
            robot.joint_names.index(name),
            recording.columns[torque_column(name)],
        )
        seen = np.isfinite(values)
        at, torque = recording.t[seen] - behind, values[seen]
        if at.size < 2:
            continue
        std, dt = _std(robot, at, torque[:, None]), float(np.median(np.diff(at)))
        rate = np.asarray(samples.qd[k])
        still = STANDING * float(np.sqrt(np.nanmean(rate**2)))
        scale, *drives = (
            max(errors.get(f"joint.{name}.{what.removeprefix('joint_')}", 0.0), LEAST)
            for what in OF_TORQUES
        )
        known = [*declared[k], 0.0]
        parts.append([k, std * np.sqrt(dt), still, *known, *drives, scale])
        impulses.append(_impulse(t, at, torque, longest))
    if not parts:
        return Torques(NO_TORQUES, np.zeros((t.size, 0)))
    return Torques(
        DrivenJoints(np.array(parts, dtype=float), longest), np.column_stack(impulses)
    )


def _std(
    robot: Robot, t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n 1"]
) -> float:
    declared = robot.sensors.of(TORQUES).white_std(1.0)
    return max(declared or noisiest_std(x), between(t, x), LEAST)


def _impulse(
    t: Float[np.ndarray, " samples"],
    at: Float[np.ndarray, " n"],
    torque: Float[np.ndarray, " n"],
    longest: float,
) -> Float[np.ndarray, " samples"]:
    """The integral of a torque until each sample, N m s.

    It is NaN where a spline runs through a gap, and for `longest` (s) behind it: so
    long a step may be, and whichever sample comes first is none that a torque leads to.
    """
    impulse = CubicSpline(at, torque).antiderivative()(t)
    impulse[(t < at[0]) | (t > at[-1])] = np.nan
    step = np.diff(at)
    gap = step > LONGEST * np.median(step)
    begun = np.searchsorted(at[:-1][gap], t, "left")
    ended = np.searchsorted(at[1:][gap] + longest, t, "right")
    impulse[begun > ended] = np.nan
    return impulse
