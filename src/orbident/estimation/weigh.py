"""The total mass from a thruster burn with locked joints, as rows linear in 1/M.

The CM answers the thrusters (Eqs. 33 to 36), and S turns with the base about it
(Eq. 38). With `J` the integral of `R_0 F`, and `c` from S to the CM in base axes:

    r_S = r_0 + v_0 t + (1/M) integral of J - R_0 c
    v_S = v_0 + (1/M) J - R_0 (w x c)

Joints are locked, so `c` is a constant: an unknown as `r_0` and `v_0` are. Eq. 40
solves them over all samples and axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from pydantic import Field
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.quantities import Quantity
from orbident.estimation.triangular import Layout, LinearFit, fold, solve_factor
from orbident.files.json_parts import JsonPart, NullableNumber, held_as
from orbident.preprocessing.base_motion import base_motion, same_sign
from orbident.preprocessing.delays import delays
from orbident.preprocessing.integrals import (
    bias_response,
    velocity_from_accelerometer,
)
from orbident.preprocessing.rates import at_times, fill
from orbident.preprocessing.smoothing import Settings
from orbident.preprocessing.wrenches import Wrenches, recorded_thrust
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.robot.units import MeasuredQuantity

Vectors = Float[np.ndarray, "n 3"]
Matrices = Float[np.ndarray, "n 3 3"]


class Burn(NamedTuple):
    """What is known of a burn, on the rows where attitude and force are."""

    t: Float[np.ndarray, " n"]
    x_WB: Float[np.ndarray, "n 4"]
    w: Vectors
    """Base axes, rad/s; NaN where it is not known."""
    forces: Float[np.ndarray, "n 3 4"]
    """Columns, base axes, N: the force, and the force turned about x, y and z."""
    impulse: Float[np.ndarray, "n 3 4"]
    """`J` of each of these, inertial axes, N s."""
    carried: Float[np.ndarray, "n 3 4"]
    """The integral of `impulse` over time, inertial axes, N s^2."""
    rows: Int[np.ndarray, " n"]
    """Rows of the recording."""
    gain: float
    """Standard deviation of the impulse's size, over the impulse."""


class Rows(NamedTuple):
    """Equations `unknown u + pushed [1/M, turned] = measured`, inertial axes."""

    unknown: Float[np.ndarray, "n 3 k"]
    pushed: Float[np.ndarray, "n 3 4"]
    measured: Vectors
    """NaN where there is no sample."""


def burn_of(robot: Robot, recording: Recording, late: float) -> Burn:
    """Integrate the thrust along the attitude.

    A force lasts from its row until the next one that has a force.

    Args:
        robot: with its thrusters, and the noise of its sensors, where that is known.
        recording: what the thrusters did, or their net force; and the attitude.
        late: by how much the attitude's times are behind the gyro's, s.

    Raises:
        InputError: a column is missing, nothing was fired, or force and attitude are
            not known together.
    """
    pushes = _pushes(robot, recording)
    recording.vector("attitude")
    base = base_motion(recording, robot.sensors, late, Settings())
    label = f"{recording.source}: attitude"
    x_WB = fill(recording.t, same_sign(np.column_stack(base.x_WB)), label)
    known = np.flatnonzero(np.isfinite(x_WB).all(axis=1))
    each = np.stack([push.force[known] for push in pushes], axis=2)
    F = each.sum(axis=2)
    if known.size < 2 or not F.any():
        raise InputError(
            f"{recording.source}: nothing was fired while the attitude is known; force "
            "and attitude must be recorded together"
        )
    t = recording.t[known]
    R_WB = Rotation.from_quat(x_WB[known]).as_matrix()
    turned = np.cross(np.eye(3), F[:, None, :])
    forces = np.concatenate([F[:, None, :], turned], axis=1).transpose(0, 2, 1)
    impulse, carried = _integrated(t, R_WB, forces)
    gain = _gain(_integrated(t, R_WB, each)[0], [push.gain for push in pushes])
    w = np.column_stack(base.w)[known]
    return Burn(t, x_WB[known], w, forces, impulse, carried, known, gain)


def _pushes(robot: Robot, recording: Recording) -> Wrenches:
    """All that pushed; a net force is taken as it was recorded."""
    thrust, net = recorded_thrust(robot, recording)
    if thrust or net:
        return (*thrust, *(wrench._replace(gain=0.0) for wrench in net))
    if not any(name.startswith("thruster.") for name in recording.columns):
        # Whose message says what is missing.
        recording.vector("force")
    raise InputError(
        f"{recording.source}: thrust is zero throughout; record a burn, and the net "
        "force of the thrusters in base axes (force.x .y .z, N) or what each did "
        "(thruster.NAME.force, N, or thruster.NAME.duty)"
    )


def _gain(J: Float[np.ndarray, "n 3 pushes"], gains: Sequence[float]) -> float:
    """How uncertain the impulse's size is, by the parts that each push has in it."""
    total = J.sum(axis=2)
    at = np.argmax(np.linalg.norm(total, axis=1))
    parts = total[at] @ J[at] / (total[at] @ total[at])
    return float(np.linalg.norm(parts * gains))


def position_rows(burn: Burn, recording: Recording, late: float) -> Rows:
    """The rows that the position of S gives.

    Args:
        burn: the thrust along the attitude.
        recording: position, inertial axes, m.
        late: by how much its times are behind the gyro's, s.
    """
    one = np.broadcast_to(np.eye(3), (burn.t.size, 3, 3))
    t = (burn.t - burn.t[0])[:, None, None]
    unknown = np.concatenate([one, t * one, -_R_WB(burn)], axis=2)
    return Rows(unknown, burn.carried, _caught_up(burn, recording, "position", late))


def velocity_rows(burn: Burn, recording: Recording, late: float) -> Rows:
    """The rows that the velocity of S gives.

    Args:
        burn: the thrust along the attitude.
        recording: velocity, inertial axes, m/s.
        late: by how much its times are behind the gyro's, s.
    """
    one = np.broadcast_to(np.eye(3), (burn.t.size, 3, 3))
    unknown = np.concatenate([one, -_R_WB(burn) @ _crossing(burn.w)], axis=2)
    return Rows(unknown, burn.impulse, _caught_up(burn, recording, "velocity", late))


def accelerometer_rows(burn: Burn, recording: Recording) -> Rows:
    """The rows that an accelerometer gives, its constant bias unknown.

    They hold changes of the velocity of S from one sample to the next, because the
    noise of an integral adds up. Force and specific force are integrated alike: between
    two rows both are anyone's guess.

    Args:
        burn: the thrust along the attitude.
        recording: specific force at S, base axes, m/s^2.

    Raises:
        InputError: there are fewer than four samples.
    """
    f_S = recording.vector("accelerometer")[burn.rows]
    v_S = velocity_from_accelerometer(burn.t, burn.x_WB, f_S, recording.source)
    v_S[np.isnan(f_S).any(axis=1)] = np.nan
    J = [
        velocity_from_accelerometer(burn.t, burn.x_WB, F)
        for F in np.moveaxis(burn.forces, 2, 0)
    ]
    bias = bias_response(burn.t, burn.x_WB)
    unknown = np.concatenate([bias, -_R_WB(burn) @ _crossing(burn.w)], axis=2)
    return Rows(*(np.diff(x, axis=0) for x in (unknown, np.stack(J, axis=2), v_S)))


def _R_WB(burn: Burn) -> Matrices:
    return Rotation.from_quat(burn.x_WB).as_matrix()


def _crossing(w: Vectors) -> Matrices:
    """`w x`, as matrices."""
    return np.cross(w[:, None, :], np.eye(3)).transpose(0, 2, 1)


def _integrated(
    t: Float[np.ndarray, " n"], R_WB: Matrices, F: Float[np.ndarray, "n 3 k"]
) -> tuple[Float[np.ndarray, "n 3 k"], Float[np.ndarray, "n 3 k"]]:
    """`integral of R_0 F` and its integral, `R_0` linear and `F` constant in a step."""
    h = np.diff(t)[:, None, None]
    before, after = R_WB[:-1] @ F[:-1], R_WB[1:] @ F[:-1]
    pushed = _summed(h / 2 * (before + after))
    carried = h * pushed[:-1] + h**2 * (before / 3 + after / 6)
    return pushed, _summed(carried)


def _summed(steps: Float[np.ndarray, "m 3 k"]) -> Float[np.ndarray, "n 3 k"]:
    return np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])


def _caught_up(burn: Burn, recording: Recording, sensor: str, late: float) -> Vectors:
    x = recording.vector(sensor)
    if late:
        t, label = recording.t, f"{recording.source}: {sensor}"
        x = np.column_stack([at_times(t, column, t + late, label) for column in x.T])
    return x[burn.rows]


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
class Weighing(JsonPart):
    """The total mass by a thruster burn, and what it was found from."""

    mass: Quantity
    """kg, with what scales said of it (`known` in the robot file); NaN where the status
    is rejected."""
    status: Literal["ok", "rejected"]
    """`"rejected"` if the burn does not determine the mass."""
    warnings: tuple[str, ...]
    """What a person should know of it, in sentences."""
    signal: str
    """The signal of S that it was found from, such as `"position"`."""
    samples: int
    """How many samples were used."""
    impulse: Annotated[Float[np.ndarray, "3"], held_as(list[NullableNumber])]
    """Impulse of the thrusters, inertial axes, N s."""
    rms: Annotated[NullableNumber, Field(alias="residual_rms")]
    """Root mean square of the residual: m, or m/s."""
    thrust: Quantity
    """Thrust over that which was recorded, by the mass of scales; NaN without."""

    def __repr__(self) -> str:
        """The mass and what it was found from."""
        found = f"mass {self.mass} kg from {self.signal}, {self.samples} samples"
        return "\n".join([f"{self.status}: {found}", *self.warnings])


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
            the force is zero throughout, a joint moved, or one is passive.
    """
    require_measured(robot, "the mass by a burn")
    recording = recording.with_joints_of(robot)
    recording.check_thrusters(robot)
    _check_locked(robot, recording)
    found = [s for s in SIGNALS if recording.has_vector(s)]
    if not found:
        raise InputError(
            f"{recording.source}: has neither position.x .y .z nor velocity.x .y .z of "
            "the feature point, nor accelerometer.x .y .z; record one of them"
        )
    behind = delays(robot, recording, {})
    burn = burn_of(robot, recording, behind["attitude"])
    fits: dict[str, tuple[LinearFit, int]] = {}
    for name, rows_of in (("position", position_rows), ("velocity", velocity_rows)):
        if name in found:
            rows = rows_of(burn, recording, behind["position"])
            fits[name] = _fit(robot, rows)
    if not fits:
        fits["accelerometer"] = _fit(robot, accelerometer_rows(burn, recording))
    signal = min(fits, key=lambda name: _uncertainty(fits[name][0]))
    fit, samples = fits[signal]
    warnings = _doubts(fit)
    mass, thrust = NOWHERE, NOWHERE
    if not warnings:
        mass, scales = _mass(fit, burn.gain), robot.known.mass
        if scales:
            warnings = _beside_scales(mass, scales)
            # Gains are in what the burn says of the mass, and are what it finds here.
            alone = _mass(fit, 0.0)
            ratio = scales.value / alone.value
            std = np.hypot(alone.std / alone.value, scales.std / scales.value)
            thrust = Quantity(ratio, float(ratio * std))
            info = np.array([mass.std, scales.std]) ** -2.0
            both = info @ np.array([mass.value, scales.value]) / info.sum()
            mass = Quantity(float(both), float(info.sum() ** -0.5))
    return Weighing(
        mass=NOWHERE if warnings else mass,
        signal=signal,
        samples=samples,
        impulse=burn.impulse[-1, :, 0],
        rms=fit.rms,
        status="rejected" if warnings else "ok",
        warnings=warnings,
        thrust=thrust,
    )


def _beside_scales(mass: Quantity, scales: MeasuredQuantity) -> tuple[str, ...]:
    """Whether both may be right."""
    if abs(mass.value - scales.value) <= SIGNIFICANT * np.hypot(mass.std, scales.std):
        return ()
    return (
        f"mass: by the burn it is {mass.value:.4g} +- {mass.std:.2g} kg, and by "
        f"'known' {scales.value:.4g} +- {scales.std:.2g} kg; check the thrust, and "
        "'gain' of the thrusters, which says how well it is known",
    )


def _check_locked(robot: Robot, recording: Recording) -> None:
    for name, joint in zip(robot.joint_names, robot.joints, strict=True):
        column = f"joint.{name}.position"
        q = recording.columns[column]
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
    _, moving = robot.conserved_axes
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
