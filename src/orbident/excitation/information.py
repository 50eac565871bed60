"""Fisher information of the free-flying base parameters under a robot's sensors.

With the joint history and the attitude that turns `h_cm` as measured, momentum
conservation predicts, to first order in `beta = [M, sigma, iota]`,

    d w   = E (R_0^T d h_cm - Y (d pi/d beta) d beta)
    d v_S = d v_cm + R_0 (W (d phi/d beta) d beta + r_cm x d w)

A gyro sees `w`, an accelerometer the changes of `v_S`, a star tracker or motion capture
the integral of `w`, and motion capture that of `v_S`; each with white noise and an
unknown constant. Torques at joints are in `torque_changes`. Momenta and constants are
eliminated, and so are what acts from outside and errors of instruments, whose columns
are known to a deviation beforehand.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.linear_fits import rest_std
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.estimation.output_error.sensors import TORQUES, torque_column
from orbident.estimation.unknowns import Unknown
from orbident.excitation.criterion import random_regressors
from orbident.excitation.floating import (
    Gradient,
    NodalMotion,
    Rows,
    axial,
    block,
    running_integral,
    running_integral_transposed,
)
from orbident.excitation.instrument_changes import InstrumentChanges
from orbident.excitation.outside_changes import OutsideChanges, anything_may_act
from orbident.excitation.torque_changes import TorqueChanges
from orbident.gaussian import rms_of
from orbident.model.dependencies import DEPENDENT
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.joint_schema import driven_alone
from orbident.robot.parameters import cross_matrix
from orbident.robot.sensor_schema import InertialSpec, SensorsSpec

SOME = 64
"""Nodes that show what may act well enough to tell its parts apart."""


@dataclass(frozen=True, eq=False)
class Sensing:
    """What is measured how well, and what of."""

    weights: dict[str, float]
    """One over the variance of a second of each sensor that is there, SI."""
    pi_of: Float[np.ndarray, "pi unknowns"]
    """`d pi` of a change of the unknowns."""
    phi_of: Float[np.ndarray, "phi unknowns"]
    beta_of: Float[np.ndarray, "beta unknowns"]
    """The unknowns are `beta`, in units in which random motion shows all alike."""
    h: tuple[int, ...]
    """Axes in which angular momentum is conserved."""
    v: tuple[int, ...]
    """Axes in which linear momentum is conserved."""
    acting: bool
    """Whether anything may act from outside."""
    errors: tuple[Unknown, ...]
    """Of instruments and geometry, with their deviations beforehand."""
    driven: tuple[int, ...]
    """Joints whose torque is measured and counts."""


def weights_of(sensors: SensorsSpec) -> dict[str, float]:
    """How well each sensor of the base's motion that has a noise measures it."""
    # A rate's weight is that of its density, an angle's of all samples of a second.
    return {
        name: (1.0 if isinstance(sensor, InertialSpec) else sensors.rows_per_second)
        / sensor.white_noise**2
        for name, sensor in sensors.of_base.items()
        if sensor.white_noise
    }


def sensing_of(robot: Robot, sets: MinimalSets) -> Sensing:
    """The sensors of the robot file, around the nominal parameters.

    Raises:
        InputError: the robot file has no sensor of the base's motion.
    """
    weights = weights_of(robot.sensors)
    if not weights:
        raise InputError(
            f"{robot.name}: sensors: found no noise of gyro, accelerometer, attitude "
            "or position; the objectives d, a and e need it: give it in the robot "
            "file, or use the objective cond"
        )
    torques, driven = robot.sensors.torques, list[str]()
    if torques and torques.white_noise and (driven := driven_alone(robot)):
        weights[TORQUES] = robot.sensors.rows_per_second / torques.white_noise**2
    shown = {*weights, *map(torque_column, driven)}
    dpi, dphi = sets.derivatives(sets.beta(robot.theta))
    unit = _unit(robot, sets, dpi, dphi)
    regressors = sets.regressors
    return Sensing(
        weights,
        dpi @ unit,
        dphi @ unit,
        unit,
        regressors.momentum_axes,
        regressors.velocity_axes,
        anything_may_act(robot),
        tuple(each for each in calibrations_of(robot, shown) if each.std),
        tuple(map(robot.joint_names.index, driven)),
    )


def _unit(
    robot: Robot,
    sets: MinimalSets,
    dpi: Float[np.ndarray, "pi beta"],
    dphi: Float[np.ndarray, "phi beta"],
) -> Float[np.ndarray, "beta unknowns"]:
    """Units of `beta` that depend on no basis: random motion shows them all alike.

    What coupled joints do not show is no unknown.
    """
    Y, W = random_regressors(robot, sets)
    shown = np.concatenate(
        [(X @ d).reshape(-1, d.shape[1]) for X, d in ((Y, dpi), (W, dphi))]
    )
    R = np.linalg.qr(shown / np.sqrt(len(Y)), mode="r")
    _, s, Vt = np.linalg.svd(R)
    rank = int(np.sum(s > DEPENDENT * s[0]))
    return Vt[:rank].T / s[:rank]


class SensedChanges:
    """What sensors see of changes of the unknowns and of `h_cm`, side by side.

    The first columns of `dw` (base axes) and `dv` (inertial axes) are the unknowns',
    then come those of errors of instruments, and from `first` on they are those of what
    may act, both at their deviations.
    """

    def __init__(self, sensing: Sensing, motion: NodalMotion, at_rest: bool) -> None:
        """`at_rest`: `h_cm = 0` is known, as well as the robot file says."""
        h, v = sensing.h, sensing.v
        self.sensing, self.motion = sensing, motion
        self.outside = OutsideChanges(motion) if sensing.acting else None
        self.instruments = InstrumentChanges(sensing.errors, motion)
        if sensing.driven:
            self.torques = TorqueChanges(
                sensing.driven, sensing.beta_of, motion, self.instruments
            )
        u = sensing.pi_of.shape[1]
        self.errors = slice(u, u + len(sensing.errors))
        self.R_h, self.R_v = block(motion.R, h, h), block(motion.R, v, v)
        self.E = block(motion.E, h, h)
        self.lever = block(cross_matrix(motion.r_cm), v, h)
        # R_0^T dh_cm - Y dpi.
        change, R_T = [-(motion.Y @ sensing.pi_of)], np.swapaxes(self.R_h, 1, 2)
        change.append(self.instruments.dh[:, h])
        self.h_std = np.full(len(h), np.inf)
        if at_rest:
            h_rw = motion.qd_rw @ motion.craft.wheels.A_rw.T
            self.h_std = rest_std(motion.craft.robot, rms_of(h_rw))[list(h)]
        # What is known exactly is no unknown.
        if self.h_std.any():
            change.append(R_T)
        self.first = sum(columns.shape[2] for columns in change)
        if self.outside:
            change.append(R_T @ self.outside.h[:, h])
        self.dh = np.concatenate(change, axis=2)
        # What momentum conservation makes of them; a clock's `w` is beside it.
        self.by_h = self.E @ self.dh
        self.dv_B = self.lever @ self.by_h
        self.dv_B[:, :, :u] += motion.W @ sensing.phi_of
        self.dv_B[:, :, self.errors] += self.instruments.dv_B[:, v]
        self.dw, self.dv = self.by_h.copy(), self.R_v @ self.dv_B
        self.dw[:, :, self.errors] += self.instruments.dw[:, h]
        self.felt = self.dv
        if self.outside:
            self.felt = self.dv.copy()
            self.dv[:, :, self.first :] += self.outside.v[:, v]
            self.felt[:, :, self.first :] += self.outside.felt[:, v]

    def rows(self, sensor: str) -> Rows:
        """What one sensor sees, then of its own constants."""
        if sensor == TORQUES:
            return self.torques.rows(self.by_h)
        n, dt, axes = len(self.dw), self.motion.dt, self._axes(sensor)
        own, dw, dv = np.eye(self.R_v.shape[1]), self.dw, self.dv
        if sensor in ("gyro", "attitude"):
            own = np.eye(self.R_h.shape[1])
            seen = running_integral(self.R_h @ dw, dt)
            seen = dw.copy() if sensor == "gyro" else seen
        elif sensor == "accelerometer":
            seen, own = np.diff(self.felt, axis=0) / dt, self.R_v[1:]
        else:
            # The velocity of the CM, and where it is at the start.
            t = dt * np.arange(n)[:, None, None]
            seen = running_integral(dv, dt)
            own = np.concatenate([t * own, own + 0 * t], 2)
        if sensor != "accelerometer":
            seen[:, :, self.errors] += self.instruments.shown(sensor)[:, axes]
        own = np.broadcast_to(own, (len(seen), *own.shape[-2:]))
        return np.concatenate([seen, own], axis=2)

    def add(self, f: Gradient, by_rows: Mapping[str, Rows]) -> None:
        """Adds the gradient, from that with respect to `rows` of each sensor."""
        shape = 2, len(self.dw), 3, len(self.sensing.errors)
        self._by_dh, self._by_dv_B = np.zeros(shape)
        for sensor, by in by_rows.items():
            self._add(f, sensor, by)
        self.instruments.add_momenta(f, self._by_dh, self._by_dv_B)

    def _axes(self, sensor: str) -> tuple[int, ...]:
        turns = sensor in ("gyro", "attitude")
        return self.sensing.h if turns else self.sensing.v

    def _of_errors(
        self, by: Rows, axes: tuple[int, ...]
    ) -> Float[np.ndarray, "n 3 errors"]:
        """The columns of the errors, with all three axes."""
        whole = np.zeros((len(by), 3, len(self.sensing.errors)))
        whole[:, axes] = by[:, :, self.errors]
        return whole

    def _add(self, f: Gradient, sensor: str, by_rows: Rows) -> None:
        if sensor == TORQUES:
            self._add_by_h(f, self.torques.add(f, by_rows, self.by_h))
            return
        columns, dt, sensing = self.dw.shape[2], self.motion.dt, self.sensing
        by, by_own = by_rows[:, :, :columns], by_rows[:, :, columns:]
        if sensor != "accelerometer":
            shown = self._of_errors(by, self._axes(sensor))
            self.instruments.add_shown(f, sensor, shown)
        if sensor == "gyro":
            self._add_dw(f, by)
        elif sensor == "attitude":
            by_turned = running_integral_transposed(by, dt)
            _add(f.R, sensing.h, sensing.h, by_turned @ np.swapaxes(self.dw, 1, 2))
            self._add_dw(f, np.swapaxes(self.R_h, 1, 2) @ by_turned)
        elif sensor == "accelerometer":
            by_R = np.concatenate([np.zeros_like(self.R_v[:1]), by_own])
            _add(f.R, sensing.v, sensing.v, by_R)
            self._add_dv(f, -np.diff(by, axis=0, prepend=0, append=0) / dt)
        else:
            self._add_dv(f, running_integral_transposed(by, dt))

    def _add_dv(self, f: Gradient, by_dv: Rows) -> None:
        """`dv = R_v (W dphi + dv_B + lever by_h) + dv_cm`."""
        sensing = self.sensing
        if self.outside:
            self.outside.add_v(f, by_dv[:, :, self.first :])
        _add(f.R, sensing.v, sensing.v, by_dv @ np.swapaxes(self.dv_B, 1, 2))
        by = np.swapaxes(self.R_v, 1, 2) @ by_dv
        f.W += by[:, :, : sensing.phi_of.shape[1]] @ sensing.phi_of.T
        self._by_dv_B += self._of_errors(by, sensing.v)
        by_lever = np.zeros_like(f.R)
        _add(by_lever, sensing.v, sensing.h, by @ np.swapaxes(self.by_h, 1, 2))
        f.r_cm += axial(by_lever)
        self._add_by_h(f, np.swapaxes(self.lever, 1, 2) @ by)

    def _add_dw(self, f: Gradient, by_dw: Rows) -> None:
        self.instruments.add_dw(f, self._of_errors(by_dw, self.sensing.h))
        self._add_by_h(f, by_dw)

    def _add_by_h(self, f: Gradient, by_dw: Rows) -> None:
        """`dw = E [-Y dpi, dh, R_h^T dh_cm]`."""
        sensing, u = self.sensing, self.sensing.pi_of.shape[1]
        _add(f.E, sensing.h, sensing.h, by_dw @ np.swapaxes(self.dh, 1, 2))
        by = np.swapaxes(self.E, 1, 2) @ by_dw
        f.Y -= by[:, :, :u] @ sensing.pi_of.T
        self._by_dh += self._of_errors(by, sensing.h)
        if self.first > self.errors.stop:
            by_R = np.swapaxes(by[:, :, self.errors.stop : self.first], 1, 2)
            _add(f.R, sensing.h, sensing.h, by_R)
        if self.outside:
            own = by[:, :, self.first :]
            dh_cm = self.outside.h[:, sensing.h]
            _add(f.R, sensing.h, sensing.h, dh_cm @ np.swapaxes(own, 1, 2))
            self.outside.add_h(f, self.R_h @ own)


class Information:
    """What a motion tells of unknowns and errors of instruments; others are eliminated.

    What is known of the errors beforehand is not in it: recordings have them in common.
    At rest, `h_cm = 0` is known: all was at rest before the wheels spun up.
    """

    def __init__(self, sensing: Sensing, motion: NodalMotion, at_rest: bool) -> None:
        self._seen = SensedChanges(sensing, motion, at_rest)
        self._rows = {sensor: self._seen.rows(sensor) for sensor in sensing.weights}
        common = self._seen.dw.shape[2]
        # The constants of each sensor are nuisances of their own, after the common.
        self._columns, size = {}, common
        for sensor, rows in self._rows.items():
            own = np.arange(size, size + rows.shape[2] - common)
            self._columns[sensor] = np.concatenate([np.arange(common), own])
            size += own.size
        u, F = self._seen.errors.stop, np.zeros((size, size))
        acting = slice(self._seen.first, common)
        apart = self._apart(acting) if self._seen.outside else np.eye(0)
        for sensor, rows in self._rows.items():
            flat = rows.reshape(-1, rows.shape[2])
            if self._seen.outside:
                flat = flat.copy()
                flat[:, acting] = flat[:, acting] @ apart
            F[np.ix_(self._columns[sensor], self._columns[sensor])] += (
                self._weight(sensor) * flat.T @ flat
            )
        if acting.start > u:
            h_cm = np.arange(u, acting.start)
            F[h_cm, h_cm] += self._seen.h_std**-2.0
        # A number of what may act has the deviation one beforehand.
        F[acting, acting] += apart.T @ apart
        # The Schur complement; nuisances scaled, since their units differ.
        scale = 1 / np.sqrt(np.diag(F)[u:])
        F_nu = F[u:, :u] * scale[:, None]
        by_nuisance = np.linalg.solve(F[u:, u:] * scale[:, None] * scale, F_nu)
        left = F[:u, :u] - F_nu.T @ by_nuisance
        self.F: Float[np.ndarray, "common common"] = (left + left.T) / 2
        self._left = np.vstack([np.eye(u), -scale[:, None] * by_nuisance])
        self._left[acting] = apart @ self._left[acting]

    def _apart(self, acting: slice) -> Float[np.ndarray, "acting acting"]:
        """Combinations of what may act that some rows tell apart.

        What changes slowly looks alike to an attitude, which is its integral twice.
        """
        some = [
            np.sqrt(self._weight(sensor)) * rows[:: ceil(len(rows) / SOME), :, acting]
            for sensor, rows in self._rows.items()
        ]
        count = acting.stop - acting.start
        stacked = [each.reshape(-1, count) for each in some]
        R = np.linalg.qr(np.concatenate([*stacked, np.eye(count)]), mode="r")
        return np.linalg.inv(R)

    def _weight(self, sensor: str) -> float:
        at = self._seen.torques if sensor == TORQUES else self._seen.motion
        return self._seen.sensing.weights[sensor] * at.dt

    def add(self, f: Gradient, by_F: Float[np.ndarray, "common common"]) -> None:
        """Adds the gradient, from that with respect to `F`."""
        by_rows = {}
        for sensor, rows in self._rows.items():
            left = self._left[self._columns[sensor]]
            by_rows[sensor] = 2 * self._weight(sensor) * (rows @ left) @ by_F @ left.T
        self._seen.add(f, by_rows)
        if self._seen.outside:
            # A size that grows by a part takes twice that from its prior's weight.
            left = self._left[self._seen.first : self._seen.dw.shape[2]]
            self._seen.outside.add_sizes(f, -2 * np.sum(left @ by_F * left, axis=1))


class OfParameters(NamedTuple):
    """The information of the unknowns alone."""

    F: Float[np.ndarray, "unknowns unknowns"]
    left: Float[np.ndarray, "common unknowns"]
    """The gradient by that of unknowns and errors is `left by_F left^T`."""


def of_parameters(
    sensing: Sensing, F: Float[np.ndarray, "common common"]
) -> OfParameters:
    """Eliminate the errors of instruments, which have a deviation of one beforehand.

    `F` is the sum of `Information.F` of all recordings.
    """
    u = sensing.pi_of.shape[1]
    by_error = np.linalg.solve(F[u:, u:] + np.eye(len(F) - u), F[u:, :u])
    left = F[:u, :u] - F[:u, u:] @ by_error
    return OfParameters((left + left.T) / 2, np.vstack([np.eye(u), -by_error]))


def _add(
    whole: Float[np.ndarray, "n 3 3"],
    rows: tuple[int, ...],
    columns: tuple[int, ...],
    part: Float[np.ndarray, "n rows columns"],
) -> None:
    own = block(whole, rows, columns)
    own += part
