"""A thruster burn with locked joints, as rows that are linear in 1/M.

The CM answers the thrusters (Eqs. 33 to 36), and S turns with the base about it
(Eq. 38). With `J` the integral of `R_0 F`, and `c` from S to the CM in base axes:

    r_S = r_0 + v_0 t + (1/M) integral of J - R_0 c
    v_S = v_0 + (1/M) J - R_0 (w x c)

Joints are locked, so `c` is a constant: an unknown as `r_0` and `v_0` are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.attitude_rates import same_sign
from orbident.preprocessing.base_motion import base_motion
from orbident.preprocessing.rates import at_times, fill
from orbident.preprocessing.settings import Settings
from orbident.preprocessing.velocity import bias_response, velocity_from_accelerometer
from orbident.preprocessing.wrenches import Wrenches, recorded_thrust
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

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
    """Its integral."""
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
    recording.vector("attitude", "xyzw")
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
