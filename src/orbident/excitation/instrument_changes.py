"""What errors of instruments and of geometry do to what sensors see along a motion.

With `d` the change by an error, of the momentum `h_rs` and of the CM's velocity
relative to S, `v = w x r_cm + J_cm qd`, where base and joints move as they are shown,

    joint's zero, scale, place, direction    dh = -d h_rs,  dv_B = -d v
    wheel's inertia                          dh = -a I qd_rw
    attitude off by m                        dh = m x R_0^T h_cm,  dv_B = v x m,
                                             and R_0 m in the attitude
    joints' clock                            dh = w x R_0^T h_cm,  dw = w',  dv_B = -v'
    gyro's scale, misalignment               diag(w), [w]x  in the gyro alone
    feature point, position's scale, clock   R_0, r_S, v_S  in the position alone

with `dw = E dh`, `dv_S = R_0 (dv_B + r_cm x dw)`, and the attitude off by its clock
times `w`. Joints that are shown late are a base that is shown early.

Which errors there are is what estimators have (`calibrations_of`), and each is here at
its standard deviation. Changes of momenta are central differences, and so are their
gradients.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.unknowns import Unknown
from orbident.excitation.floating import (
    Gradient,
    NodalMotion,
    running_integral,
    running_integral_transposed,
)
from orbident.model.core_robot import core_robot
from orbident.model.kinematics import inertia
from orbident.model.rotations import rotate, rotate_back
from orbident.robot.description import Robot
from orbident.robot.parameters import cross_matrix
from orbident.robot.tolerances import CALIBRATION_KINDS
from orbident.threads import processors

STEP = 1e-5
"""rad, m or relative: differences over it are good to ten digits."""

OF_THE_JOINTS = ("joint_zero", "joint_scale", "joint_place", "joint_direction")
"""Errors of where the joints are."""

OF_THE_WHEELS = ("wheel_inertia", "wheel_axis")
"""Errors of the momentum of wheels."""

TURNED = ("attitude_misalignment", "attitude_clock", "joint_clock")
"""Errors by which the base is elsewhere than the attitude shows, when joints move."""


ByErrors = Float[np.ndarray, "n 3 errors"]
"""Changes along a motion, or gradients by them, a column each error."""


class ErrorPlace(NamedTuple):
    """Which error it is."""

    tolerance: str
    """Its field of `Tolerances`."""
    owner: int
    """The joint or the wheel, where each has its own."""
    axis: int
    column: int
    std: float


class JointsElsewhere(NamedTuple):
    """Motions of one robot with an error each, of `STEP` or of less than none."""

    robot: Robot
    errors: list[tuple[ErrorPlace, float]]
    """Of each motion, with what the change by it is to be multiplied by."""
    q: Float[np.ndarray, "motions*n joints"]
    qd: Float[np.ndarray, "motions*n joints"]
    w: Float[np.ndarray, "motions*n 3"]
    scale: Float[np.ndarray, "motions 1 joints"]
    """Of `q` and `qd` by those that are shown."""


class InstrumentChanges:
    """Changes by a standard deviation of each error."""

    dh: ByErrors
    """What `w` owes to them, base axes, N m s: `dw = E dh`."""
    dv_B: ByErrors
    """Of `v_S`, base axes, m/s, where `w` is as it was."""
    dw: ByErrors
    """Of `w` beside, base axes, rad/s; `v_S` does not follow."""
    elsewhere: list[JointsElsewhere]
    """The motion where joints are elsewhere than they are shown."""

    def __init__(self, errors: tuple[Unknown, ...], motion: NodalMotion) -> None:
        """Of some errors of `calibrations_of`, along a motion at nodes."""
        self._motion, robot, self.errors = motion, motion.craft.robot, errors
        self._places = [*_placed(robot, errors)]
        shape = len(motion.w), 3, len(errors)
        self.dh, self.dv_B, self.dw = np.zeros((3, *shape))
        self._h_B = rotate_back(
            motion.R, np.tile(motion.craft.h_cm, (len(motion.w), 1))
        )
        self.elsewhere = [*self._joints_elsewhere()]
        for at in self.elsewhere:
            for (of, part), h, v in zip(at.errors, *_momenta(at), strict=True):
                self.dh[:, :, of.column] += part * h
                self.dv_B[:, :, of.column] += part * v
        for of in self._places:
            if of.tolerance in OF_THE_WHEELS:
                h_rw = np.outer(motion.qd_rw[:, of.owner], self._wheel(of))
                self.dh[:, :, of.column] = -h_rw
            elif of.tolerance in TURNED:
                m = of.std * self._turned(of)
                self.dh[:, :, of.column] = np.cross(m, self._h_B)
                self.dv_B[:, :, of.column] = np.cross(motion.v_B, m)
                if of.tolerance == "joint_clock":
                    rates = np.gradient([motion.w, motion.v_B], motion.dt, axis=1)
                    self.dw[:, :, of.column] = of.std * rates[0]
                    self.dv_B[:, :, of.column] = of.std * rates[1]

    def shown(self, sensor: str) -> ByErrors:
        """What one sensor shows beside; the gyro in base axes, others in inertial."""
        motion = self._motion
        seen = np.zeros_like(self.dh)
        for of in self._places:
            column = seen[:, :, of.column]
            match sensor, of.tolerance:
                case "gyro", "gyro_scale":
                    column[:, of.axis] = motion.w[:, of.axis]
                case "gyro", "gyro_misalignment":
                    column[:] = cross_matrix(motion.w)[:, :, of.axis]
                case "attitude", "attitude_misalignment" | "attitude_clock":
                    column[:] = rotate(motion.R, self._turned(of))
                case "position", "feature_point":
                    column[:] = motion.R[:, :, of.axis]
                case "position", "position_clock":
                    column[:] = motion.v_S
                case "position", "position_scale":
                    column[:] = running_integral(motion.v_S[:, :, None], motion.dt)[
                        ..., 0
                    ]
                case _:
                    continue
            column *= of.std
        return seen

    def add_shown(self, f: Gradient, sensor: str, by_shown: ByErrors) -> None:
        """Adds the gradient, from that with respect to `shown`."""
        motion = self._motion
        for of in self._places:
            by = of.std * by_shown[:, :, of.column]
            match sensor, of.tolerance:
                case "gyro", "gyro_scale":
                    f.w[:, of.axis] += by[:, of.axis]
                case "gyro", "gyro_misalignment":
                    f.w += np.cross(np.eye(3)[of.axis], by)
                case "attitude", "attitude_misalignment" | "attitude_clock":
                    f.R += by[:, :, None] * self._turned(of)[:, None]
                    self._add_turned(f, of, rotate_back(motion.R, by))
                case "position", "feature_point":
                    f.R[:, :, of.axis] += by
                case "position", "position_clock":
                    f.add_v_S(by)
                case "position", "position_scale":
                    summed = running_integral_transposed(by[:, :, None], motion.dt)
                    f.add_v_S(summed[:, :, 0])
                case _:
                    continue

    def add_dw(self, f: Gradient, by_dw: ByErrors) -> None:
        """Adds the gradient, from that with respect to `dw`."""
        for of in self._places:
            if of.tolerance == "joint_clock":
                by = of.std * by_dw[:, :, of.column]
                f.w += _gradient_transposed(by, f.motion.dt)

    def add_momenta(self, f: Gradient, by_dh: ByErrors, by_dv_B: ByErrors) -> None:
        """Adds the gradient, from those with respect to `dh` and `dv_B`."""
        wheels = f.motion.craft.wheels
        for at in self.elsewhere:
            by_h, by_v = (
                np.concatenate([part * by[:, :, of.column] for of, part in at.errors])
                for by in (by_dh, by_dv_B)
            )
            shape = len(at.errors), len(f.w), -1
            by_q, by_qd, by_w = (
                by.reshape(shape)
                for by in _core.momentum_gradient(
                    core_robot(at.robot), at.q, at.qd, at.w, by_h, by_v, processors()
                )
            )
            f.q += np.sum(by_q * at.scale, axis=0)
            f.qd += np.sum(by_qd * at.scale, axis=0)
            f.w += np.sum(by_w, axis=0)
        for of in self._places:
            by_h, by_v = (by[:, :, of.column] for by in (by_dh, by_dv_B))
            if of.tolerance in OF_THE_WHEELS:
                by_speed = wheels.free[of.owner] * (by_h @ self._wheel(of))
                f.w += np.outer(by_speed, wheels.axes[:, of.owner])
            elif of.tolerance in TURNED:
                m, motion = self._turned(of), f.motion
                by_h, by_v = of.std * by_h, of.std * by_v
                f.R += motion.craft.h_cm[:, None] * np.cross(by_h, m)[:, None]
                self._add_turned(f, of, np.cross(self._h_B, by_h))
                if of.tolerance == "joint_clock":
                    f.add_v_B(_gradient_transposed(by_v, motion.dt))
                else:
                    f.add_v_B(np.cross(m, by_v))
                    self._add_turned(f, of, np.cross(by_v, motion.v_B))

    def _turned(self, of: ErrorPlace) -> Float[np.ndarray, "n 3"]:
        """By how much the attitude, or the base's own, is off by an error of one."""
        w = self._motion.w
        if of.tolerance == "attitude_misalignment":
            return np.tile(np.eye(3)[of.axis], (len(w), 1))
        return w

    def _add_turned(
        self, f: Gradient, of: ErrorPlace, by: Float[np.ndarray, "n 3"]
    ) -> None:
        if of.tolerance != "attitude_misalignment":
            f.w += by

    def _wheel(self, of: ErrorPlace) -> Float[np.ndarray, "3"]:
        """The change of the momentum of a wheel for each of its rates."""
        A_rw = self._motion.craft.wheels.A_rw[:, of.owner]
        tilted = np.cross(np.eye(3)[of.axis], A_rw)
        return of.std * (tilted if of.tolerance == "wheel_axis" else A_rw)

    def _joints_elsewhere(self) -> Iterator[JointsElsewhere]:
        motion, robot = self._motion, self._motion.craft.robot
        found = defaultdict[Robot, list[tuple[ErrorPlace, float]]](list)
        for of in self._places:
            moves = of.tolerance in ("joint_place", "joint_direction")
            for step in (STEP, -STEP) if of.tolerance in OF_THE_JOINTS else ():
                moved = _displaced(robot, of, step) if moves else robot
                found[moved].append((of, step))
        for moved, errors in found.items():
            scale, zero = np.zeros((2, len(errors), 1, len(robot.joints)))
            for k, (of, step) in enumerate(errors):
                scale[k, 0, of.owner] = step * (of.tolerance == "joint_scale")
                zero[k, 0, of.owner] = step * (of.tolerance == "joint_zero")
            joints, scale = len(robot.joints), scale + 1
            yield JointsElsewhere(
                moved,
                [(of, -of.std / (2 * step)) for of, step in errors],
                (motion.q * scale + zero).reshape(-1, joints),
                (motion.qd * scale).reshape(-1, joints),
                np.tile(motion.w, (len(errors), 1)),
                scale,
            )


def _momenta(at: JointsElsewhere) -> Float[np.ndarray, "2 motions n 3"]:
    """`h_rs` and `w x r_cm + J_cm qd` of each motion."""
    found, qd = inertia(at.robot, at.q), at.qd[:, :, None]
    h = rotate(found.D, at.w) + (found.D_q @ qd)[:, :, 0]
    v = np.cross(at.w, found.r_cm) + (found.J_cm @ qd)[:, :, 0]
    return np.stack([h, v]).reshape(2, len(at.errors), -1, 3)


def _placed(robot: Robot, errors: tuple[Unknown, ...]) -> Iterator[ErrorPlace]:
    owners = {"joint": robot.joint_names, "wheel": robot.wheel_names}
    places = {
        name: (tolerance, owner, axis)
        for tolerance, kind in CALIBRATION_KINDS.items()
        for owner, of in enumerate(owners.get(kind.name.partition(".")[0], ("",)))
        for axis, name in enumerate(kind.names(of))
    }
    for column, error in enumerate(errors):
        yield ErrorPlace(*places[error.name], column, error.std)


@lru_cache(maxsize=256)
def _displaced(robot: Robot, of: ErrorPlace, step: float) -> Robot:
    """The robot with a joint elsewhere along, or turned about, its parent's axis."""
    k, along = of.owner, step * np.eye(3)[of.axis]
    joint, turn = robot.joints[k], cross_matrix(along)
    if of.tolerance == "joint_place":
        moved = replace(joint, p_PJ=joint.p_PJ + along)
    else:
        R = np.eye(3) + turn + turn @ turn / 2
        moved = replace(joint, R_PJ=R @ joint.R_PJ)
    joints = (*robot.joints[:k], moved, *robot.joints[k + 1 :])
    return replace(robot, joints=joints)


def _gradient_transposed(
    by: Float[np.ndarray, "n 3"], dt: float
) -> Float[np.ndarray, "n 3"]:
    """The gradient with respect to `x`, from that by `np.gradient(x, dt, axis=0)`."""
    half = by / 2
    half[[0, -1]] *= 2
    by_x = np.zeros_like(by)
    by_x[1:] += half[:-1]
    by_x[:-1] -= half[1:]
    by_x[0] -= half[0]
    by_x[-1] += half[-1]
    return by_x / dt
