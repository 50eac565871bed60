"""A recorded motion, and beside it the motion that an identified model predicts."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.prediction import predict
from orbident.model.inertia import inertia
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.samples import Batch, samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.settings import Settings
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.scene.motion_history import MotionHistory


class Replay(NamedTuple):
    """Motions at the same times; what was not measured is derived."""

    measured: MotionHistory
    predicted: MotionHistory | None
    """None without a model, or where it cannot predict."""
    model: Robot | None
    """The robot with the inertia that momentum is computed with; None as above."""
    velocity_known: bool
    """Whether the velocity of S was measured; else the system CM is taken to rest."""
    warnings: tuple[str, ...]


def recorded_motion(robot: Robot, recording: Recording) -> Replay:
    """What a recording shows of a robot; momentum is that of its nominal inertia.

    Raises:
        InputError: the recording lacks joints, wheels, or gyro and attitude, or has
            fewer than two complete samples.
    """
    recording = cleaned(robot, recording, Settings()).recording
    t, measured = samples_of(robot, recording).complete()
    if t.size < 2:
        raise InputError(
            f"{recording.source}: {t.size} complete samples; a replay needs joints, "
            "wheels, gyro and attitude all measured, twice at least"
        )
    motion = _measured(robot, recording, t, measured)
    return Replay(motion, None, robot, bool(measured.moving.any()), ())


def predicted_motion(result: Result, recording: Recording) -> Replay:
    """What was measured, and what the identified model makes of the same joints.

    A result that cannot predict leaves the measured motion alone, and says why.

    Raises:
        InputError: as `recorded_motion`.
    """
    recording = cleaned(result.robot, recording, Settings()).recording
    try:
        model = result.dynamics().robot
        prediction = predict(result, recording)
    except InputError as error:
        alone = recorded_motion(result.robot, recording)
        return alone._replace(model=None, warnings=(f"no prediction: {error}",))
    measured, t = prediction.measured, prediction.t
    motion = _measured(model, recording, t, measured)
    known = bool(measured.moving.any())
    predicted = motion._replace(
        x_WB=prediction.x_WB, w=prediction.w, v_S=prediction.v_S
    )
    r_S = motion.r_S[0] + _integral(t, prediction.v_S)
    return Replay(motion, predicted._replace(r_S=r_S), model, known, ())


def _integral(
    t: Float[np.ndarray, " n"], v: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    """The integral from the first time on, by the trapezoidal rule."""
    steps = np.diff(t)[:, None] * (v[1:] + v[:-1]) / 2
    return np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])


def _measured(
    robot: Robot, recording: Recording, t: Float[np.ndarray, " n"], batch: Batch
) -> MotionHistory:
    if batch.moving.any():
        v_S = _between(t, t[batch.moving], batch.v_S[batch.moving])
        r_S = _integral(t, v_S)
    else:
        r_S, v_S = _about_resting_cm(robot, batch)
    if recording.has(*(f"position.{k}" for k in "xyz")):
        position = recording.vector("position")
        seen = np.isfinite(position).all(axis=1)
        if seen.any():
            r_S = _between(t, recording.t[seen], position[seen])
    return MotionHistory(
        t, batch.q, batch.qd, batch.x_WB, batch.w, r_S, v_S, batch.qd_rw
    )


def _between(
    t: Float[np.ndarray, " n"],
    t_seen: Float[np.ndarray, " m"],
    values: Float[np.ndarray, "m 3"],
) -> Float[np.ndarray, "n 3"]:
    return np.column_stack([np.interp(t, t_seen, column) for column in values.T])


def _about_resting_cm(
    robot: Robot, batch: Batch
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """Position and velocity of S about a CM that rests at the origin (Eq. 28)."""
    at, R_WB = inertia(robot, batch.q), quaternion_matrix(batch.x_WB)
    v_cm_S = np.cross(batch.w, at.r_cm) + rotate(at.J_cm, batch.qd)
    return -rotate(R_WB, at.r_cm), -rotate(R_WB, v_cm_S)
