"""The total mass from a thruster burn: Eq. 40 over all samples and axes."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.burn import (
    Rows,
    accelerometer_rows,
    burn_of,
    position_rows,
    velocity_rows,
)
from orbident.estimation.quantities import Quantity, nulled
from orbident.estimation.triangular import Layout, LinearFit, fold, solve_factor
from orbident.model.minimal_sets import conserved_axes
from orbident.preprocessing.delays import delays
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

LOCKED = 0.02
"""rad or m: a locked joint moves less; encoders are far finer."""
SIGNIFICANT = 3.0
"""Standard deviations by which a push must show."""
TURNED = 0.05
"""A force turned by less, rad, makes the mass wrong by 0.1 % only."""
FREED = 0.5
"""Letting the force turn hardly makes the residual smaller where its frame is right."""

SIGNALS = ("position", "velocity", "accelerometer")
NOWHERE = Quantity(float("nan"), float("nan"))


@dataclass(frozen=True, repr=False)
class Weighing:
    """The total mass by a thruster burn, and what it was found from."""

    mass: Quantity
    """kg; NaN where the status is rejected."""
    signal: str
    """The signal of S that it was found from, such as `"position"`."""
    samples: int
    """How many samples were used."""
    impulse: Float[np.ndarray, "3"]
    """Impulse of the thrusters, inertial axes, N s."""
    rms: float
    """Root mean square of the residual: m, or m/s."""
    status: Literal["ok", "rejected"]
    """`"rejected"` if the burn does not determine the mass."""
    warnings: tuple[str, ...]
    """What a person should know of it, in sentences."""

    def __repr__(self) -> str:
        """The mass and what it was found from."""
        found = f"mass {self.mass} kg from {self.signal}, {self.samples} samples"
        return "\n".join([f"{self.status}: {found}", *self.warnings])

    def to_json(self) -> dict[str, Any]:
        """As `weigh --json` gives it."""
        return {
            "mass": {"value": nulled(self.mass.value), "std": nulled(self.mass.std)},
            "status": self.status,
            "warnings": list(self.warnings),
            "signal": self.signal,
            "samples": self.samples,
            "impulse": nulled(self.impulse),
            "residual_rms": nulled(self.rms),
        }


def weigh(robot: Robot, recording: Recording) -> Weighing:
    """Find the total mass from a known force on the locked robot (Eqs. 33 to 40).

    Eq. 40 for all samples and axes, by least squares; the attitude need not be held.
    Of position and velocity the one is used by which the mass has the smaller
    deviation, and the accelerometer where there is neither. A net force is taken as it
    was recorded; the deviation holds how uncertain each thruster's own force is (`gain`
    in the robot file).

    Args:
        robot: its nominal inertia is not used.
        recording: net thruster force (base axes, N) or what each thruster did,
            attitude, joint positions, and position, velocity or accelerometer of S,
            before, during and after a burn.

    Raises:
        InputError: a column is missing, empty or of a thruster that the robot lacks,
            the force is zero throughout, or a joint moved.
    """
    recording = recording.with_joints_of(robot)
    recording.check_thrusters(robot)
    _check_locked(robot, recording)
    found = [s for s in SIGNALS if recording.has(*(f"{s}.{k}" for k in "xyz"))]
    if not found:
        raise InputError(
            f"{recording.source}: has neither position.x .y .z nor velocity.x .y .z of "
            "the feature point, nor accelerometer.x .y .z; record one of them"
        )
    behind = delays(robot, recording, {})
    burn = burn_of(robot, recording, behind["attitude"])
    fits: dict[str, tuple[LinearFit, int]] = {}
    if "position" in found:
        rows = position_rows(burn, recording, behind["position"])
        fits["position"] = _fit(robot, rows)
    if "velocity" in found:
        rows = velocity_rows(burn, recording, behind["position"])
        fits["velocity"] = _fit(robot, rows)
    if not fits:
        fits["accelerometer"] = _fit(robot, accelerometer_rows(burn, recording))
    signal = min(fits, key=lambda name: _uncertainty(fits[name][0]))
    fit, samples = fits[signal]
    warnings = _doubts(fit)
    return Weighing(
        mass=NOWHERE if warnings else _mass(fit, burn.gain),
        signal=signal,
        samples=samples,
        impulse=burn.impulse[-1, :, 0],
        rms=fit.rms,
        status="rejected" if warnings else "ok",
        warnings=warnings,
    )


def _check_locked(robot: Robot, recording: Recording) -> None:
    for name, joint in zip(robot.joint_names, robot.joints, strict=True):
        column = f"joint.{name}.position"
        q = recording.column(column)
        where = f"{recording.source}: column '{column}'"
        if np.isnan(q).all():
            raise InputError(f"{where}: has no sample; record that the joint is locked")
        moved = float(np.nanmax(q) - np.nanmin(q))
        if moved > LOCKED:
            unit = "rad" if joint.kind == "revolute" else "m"
            raise InputError(
                f"{where}: moved by {moved:.3g} {unit}; lock all joints for a burn (to "
                f"{LOCKED:g} {unit})"
            )


def _fit(robot: Robot, rows: Rows) -> tuple[LinearFit, int]:
    """Least squares for 1/M, and in how many samples."""
    _, moving = conserved_axes(robot)
    planar = robot.motion == "planar"
    # In the plane a force turns about z only.
    pushed = rows.pushed[:, moving][:, :, [0, 3] if planar else [0, 1, 2, 3]]
    blocks = np.split(rows.unknown[:, moving], rows.unknown.shape[2] // 3, axis=2)
    unknown = np.concatenate([block[:, :, moving] for block in blocks], axis=2)
    measured = rows.measured[:, moving, None]
    table = np.concatenate([unknown, pushed, measured], axis=2)
    complete = np.isfinite(table).all(axis=(1, 2))
    layout = Layout(unknown.shape[2], 1, pushed.shape[2] - 1)
    used = table[complete].reshape(-1, layout.columns)
    R = fold(np.zeros((layout.columns,) * 2), used)
    return solve_factor(R, layout, len(used)), int(complete.sum())


def _uncertainty(fit: LinearFit) -> float:
    return float(fit.covariance[0, 0]) if fit.determined[0] else np.inf


def _mass(fit: LinearFit, gain: float) -> Quantity:
    M = 1 / float(fit.values[0])
    measured = M**2 * float(np.sqrt(fit.covariance[0, 0]))
    return Quantity(M, float(np.hypot(measured, M * gain)))


def _doubts(fit: LinearFit) -> tuple[str, ...]:
    """Why there is no mass; nothing where all is well."""
    per_M, std = float(fit.values[0]), float(np.sqrt(fit.covariance[0, 0]))
    if not fit.determined[0] or abs(per_M) <= SIGNIFICANT * std:
        return (
            "mass: the burn does not show in the motion of the feature point; push "
            "longer, and record seconds before and after it",
        )
    if per_M < 0:
        return (
            "mass: the robot moved against the force; check the signs and frames of "
            "force (on the robot, base axes), position and velocity (inertial axes)",
        )
    turned = np.sqrt(max(fit.unexplained**2 - fit.unexplained_freed**2, 0.0))
    angle = float(np.arctan2(turned, fit.explained))
    if angle > TURNED and fit.unexplained_freed < FREED * fit.unexplained:
        return (
            f"mass: the robot moved {np.degrees(angle):.0f} deg off the force; check "
            "the frames of force (base axes), position and velocity (inertial axes), "
            "the attitude, and whether anything else pushed",
        )
    return ()
