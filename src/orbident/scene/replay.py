"""Where everything is over time: bodies, wheels, the system CM, momentum and inertia.

The motion is a recorded one, beside it the one that an identified model predicts, or
that of a free-floating base that answers when joints are moved by hand.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from orbident.environment.motion import straight
from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.excitation.table_points import table_points
from orbident.gaussian import NINETY_FIVE
from orbident.identified.prediction import Prediction, predict
from orbident.model.core_robot import wheels_of
from orbident.model.equations_of_motion import check_regular
from orbident.model.kinematics import inertia, poses
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import axis_rotation, quaternion_matrix, rotate
from orbident.preprocessing.samples import Batch, samples_of
from orbident.preprocessing.screening import cleaned
from orbident.preprocessing.smoothing import Settings
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.scene.scene import Scene
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.trajectories.trajectory import Trajectory


class MotionHistory(NamedTuple):
    """What moves, at some times; inertial axes but for `w`."""

    t: Float[np.ndarray, " n"]
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    x_WB: Float[np.ndarray, "n 4"]
    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    r_S: Float[np.ndarray, "n 3"]
    """Position of S, m."""
    v_S: Float[np.ndarray, "n 3"]
    qd_rw: Float[np.ndarray, "n wheels"]

    def thinned(self, most: int) -> "MotionHistory":
        """The motion at no more than `most` of its times, evenly chosen."""
        chosen = np.arange(0, self.t.size, -(-self.t.size // most))
        return MotionHistory(*(column[chosen] for column in self))

    def wheel_angles(self) -> Float[np.ndarray, "n wheels"]:
        """What the wheels have turned since the first time, rad."""
        return cumulative_trapezoid(self.qd_rw, self.t, axis=0, initial=0)


class FramePoses(NamedTuple):
    """The frames of a scene, in the inertial frame."""

    R: Float[np.ndarray, "n frames 3 3"]
    p: Float[np.ndarray, "n frames 3"]


class CentroidalMomentum(NamedTuple):
    """The system CM, and momentum about and of it; inertial axes."""

    r_cm: Float[np.ndarray, "n 3"]
    """m."""
    h_rs: Float[np.ndarray, "n 3"]
    """Momentum of the bodies (Eq. 3), N m s."""
    h_rw: Float[np.ndarray, "n 3"]
    """Momentum of the wheels' relative spin (Eq. 5), N m s."""
    p: Float[np.ndarray, "n 3"]
    """Linear momentum, N s."""


def placed(
    scene: Scene, motion: MotionHistory, wheel_angles: Float[np.ndarray, "n wheels"]
) -> FramePoses:
    """Every frame of the scene; the wheels' angles are in rad."""
    at, n = poses(scene.robot, motion.q), len(motion.q)
    z = np.broadcast_to([0.0, 0.0, 1.0], (n, *scene.p_BWheel.shape))
    turned = scene.R_BWheel @ axis_rotation(z, wheel_angles)
    p_BWheel = np.broadcast_to(scene.p_BWheel, (n, *scene.p_BWheel.shape))
    R = np.concatenate([at.R, turned], axis=1)
    p = np.concatenate([at.d, p_BWheel], axis=1)
    R_WB = quaternion_matrix(motion.x_WB)[:, None]
    return FramePoses(R_WB @ R, motion.r_S[:, None] + rotate(R_WB, p))


def tips(robot: Robot, at: FramePoses) -> dict[str, Float[np.ndarray, "n 3"]]:
    """Where the last links end (`table_points`), inertial frame, m."""
    ends = table_points(robot)[len(robot.bodies) :]
    return {f"tip of {robot.bodies[i]}": at.p[:, i] + at.R[:, i] @ p for i, p in ends}


def centroidal_momentum(robot: Robot, motion: MotionHistory) -> CentroidalMomentum:
    """The CM and the momentum of a robot with the inertia of `robot.theta`.

    In the plane only what the table leaves free: angular momentum about z, linear
    momentum along x and y.
    """
    at, R_WB = inertia(robot, motion.q), quaternion_matrix(motion.x_WB)
    v_cm_S = np.cross(motion.w, at.r_cm) + rotate(at.J_cm, motion.qd)
    found = CentroidalMomentum(
        r_cm=motion.r_S + rotate(R_WB, at.r_cm),
        h_rs=rotate(R_WB, rotate(at.D, motion.w) + rotate(at.D_q, motion.qd)),
        h_rw=rotate(R_WB, motion.qd_rw @ wheels_of(robot).A_rw.T),
        p=robot.mass * (motion.v_S + rotate(R_WB, v_cm_S)),
    )
    if robot.motion == "planar":
        found.h_rs[:, :2] = found.h_rw[:, :2] = found.p[:, 2] = 0.0
    return found


class InertiaEllipsoids(NamedTuple):
    """Ellipsoids of even density, in the inertial frame."""

    R: Float[np.ndarray, "n 3 3"]
    """Their axes, as columns."""
    r_cm: Float[np.ndarray, "n 3"]
    """m."""
    lengths: Float[np.ndarray, "n 3"]
    """Half of their axes, m."""


def inertia_ellipsoids(robot: Robot, motion: MotionHistory) -> InertiaEllipsoids:
    """The ellipsoids with the system's mass, CM and inertia, joints held.

    Moments about their axes are `I_1 = M/5 (a_2^2 + a_3^2)`, and so on; those of the
    system are of `D` (Eq. 3), which is identified while its bodies' inertia is not.
    """
    at, R_WB = inertia(robot, motion.q), quaternion_matrix(motion.x_WB)
    _, R = np.linalg.eigh(at.D)
    # For a rotation: eigenvectors may be left-handed.
    R[..., 0] *= np.linalg.det(R)[:, None]
    return InertiaEllipsoids(
        R_WB @ R,
        motion.r_S + rotate(R_WB, at.r_cm),
        np.sqrt(np.maximum(_squared_lengths(robot, motion.q, R), 0.0)),
    )


def _squared_lengths(
    robot: Robot, q: Float[np.ndarray, "n joints"], R: Float[np.ndarray, "n 3 3"]
) -> Float[np.ndarray, "n 3"]:
    """`a_k^2 = 5/(2 M) (tr D - 2 u_k^T D u_k)`, m^2, `u_k` the columns of `R`."""
    moments = np.einsum("nik,nij,njk->nk", R, inertia(robot, q).D, R)
    return 2.5 / robot.mass * (moments.sum(axis=1, keepdims=True) - 2 * moments)


def inertia_intervals(
    robot: Robot, root: Float[np.ndarray, "beta beta"], motion: MotionHistory
) -> tuple[InertiaEllipsoids, InertiaEllipsoids]:
    """Ellipsoids with the lower and the upper 95 % ends of every half axis by itself.

    The interval is that of a half axis' square, whose deviation is of first order in
    the base parameters. CM and directions are held. The covariance of the robot's
    identified base parameters is `root root^T`.
    """
    found = inertia_ellipsoids(robot, motion)
    R = quaternion_matrix(motion.x_WB).mT @ found.R
    variance = np.zeros_like(found.lengths)
    for column in (minimal_sets(robot).base.theta_of @ root).T:
        off = column.reshape(robot.theta.shape)
        above, below = (
            _squared_lengths(replace(robot, theta=theta), motion.q, R)
            for theta in (robot.theta + off, robot.theta - off)
        )
        variance += ((above - below) / 2) ** 2
    half = NINETY_FIVE * np.sqrt(variance)
    low, high = (np.sqrt(np.maximum(found.lengths**2 + x, 0.0)) for x in (-half, half))
    return found._replace(lengths=low), found._replace(lengths=high)


def with_resting_cm(scene: Scene, motion: MotionHistory, inertia: Robot) -> FramePoses:
    """Every frame of the scene, where the CM stays where it is at the first time.

    Wheels are held: from one time to the next they may turn too far for an eye to see.
    The inertia of a robot says where the CM is.
    """
    r_cm = centroidal_momentum(inertia, motion).r_cm
    at = placed(scene, motion, np.zeros_like(motion.qd_rw))
    return at._replace(p=at.p - (r_cm - r_cm[0])[:, None])


class Replay(NamedTuple):
    """Motions at the same times; what was not measured is derived."""

    measured: MotionHistory
    predicted: MotionHistory | None
    """None without a model, or where it cannot predict."""
    by_cad: MotionHistory | None
    """The motion that CAD predicts; None where it cannot, or was not asked."""
    model: Robot | None
    """The robot with the inertia that momentum is computed with; None as above."""
    root: Float[np.ndarray, "beta beta"] | None
    """A square root of the covariance of the model's base parameters; None where the
    model is not identified, or the covariance not known."""
    velocity_known: bool
    """Whether the velocity of S was measured; else the system CM is taken to rest."""
    warnings: tuple[str, ...]

    def thinned(self, most: int) -> "Replay":
        """Every motion at no more than `most` of its times, evenly chosen."""
        return self._replace(
            measured=self.measured.thinned(most),
            predicted=self.predicted and self.predicted.thinned(most),
            by_cad=self.by_cad and self.by_cad.thinned(most),
        )


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
    return Replay(motion, None, None, robot, None, bool(measured.moving.any()), ())


def predicted_motion(result: Result, recording: Recording) -> Replay:
    """What was measured, and what the identified model makes of the same joints.

    A result that cannot predict leaves the measured motion alone, and says why.

    Raises:
        InputError: as `recorded_motion`.
    """
    recording = cleaned(result.robot, recording, Settings()).recording
    try:
        model = result.dynamics()
        prediction = predict(result, recording)
    except InputError as error:
        alone = recorded_motion(result.robot, recording)
        return alone._replace(model=None, warnings=(f"no prediction: {error}",))
    motion = _measured(model.robot, recording, prediction.t, prediction.measured)
    known = bool(prediction.measured.moving.any())
    root = model.root if np.isfinite(model.root).all() else None
    predicted = _predicted(motion, prediction)
    return Replay(motion, predicted, None, model.robot, root, known, ())


def _predicted(measured: MotionHistory, prediction: Prediction) -> MotionHistory:
    """The predicted motion, from where the measured one begins."""
    x_WB, w, v_S = prediction.x_WB, prediction.w, prediction.v_S
    r_S = measured.r_S[0] + cumulative_trapezoid(v_S, prediction.t, axis=0, initial=0)
    return measured._replace(x_WB=x_WB, w=w, r_S=r_S, v_S=v_S)


def motion_residuals(
    measured: MotionHistory, predicted: MotionHistory
) -> dict[str, Float[np.ndarray, "n 3"]]:
    """Measured minus predicted, by name and unit; turns are about base axes."""
    R_WP, R_WB = (Rotation.from_quat(each.x_WB) for each in (predicted, measured))
    return {
        "base rate, rad/s": measured.w - predicted.w,
        "attitude, rad": (R_WP.inv() * R_WB).as_rotvec(),
        "position of S, m": measured.r_S - predicted.r_S,
    }


def with_cad_values(result: Result) -> Result:
    """A result with CAD's parameters, whose predictions are those of CAD."""
    sets = {name: getattr(result, name) for name in ("base", "pi", "phi")}
    return replace(
        result, **{name: replace(x, values=x.nominal) for name, x in sets.items()}
    )


def compared_motions(result: Result, recording: Recording) -> Replay:
    """What was measured, and what the identified model and CAD make of the same joints.

    Raises:
        InputError: as `recorded_motion`.
    """
    replay = predicted_motion(result, recording)
    if replay.predicted is None:
        return replay
    robot = result.robot
    recording = cleaned(robot, recording, Settings()).recording
    try:
        check_regular(robot)
        prediction = predict(with_cad_values(result), recording)
    except InputError as error:
        return replay._replace(warnings=(f"no prediction by CAD: {error}",))
    motion = _measured(robot, recording, prediction.t, prediction.measured)
    return replay._replace(by_cad=_predicted(motion, prediction))


def _measured(
    robot: Robot, recording: Recording, t: Float[np.ndarray, " n"], batch: Batch
) -> MotionHistory:
    if batch.moving.any():
        v_S = straight(t, t[batch.moving], batch.v_S[batch.moving])
        r_S = cumulative_trapezoid(v_S, t, axis=0, initial=0)
    else:
        # About a CM that rests at the origin (Eq. 28).
        at, R_WB = inertia(robot, batch.q), quaternion_matrix(batch.x_WB)
        v_cm_S = np.cross(batch.w, at.r_cm) + rotate(at.J_cm, batch.qd)
        r_S, v_S = -rotate(R_WB, at.r_cm), -rotate(R_WB, v_cm_S)
    if recording.has_vector("position"):
        position = recording.vector("position")
        seen = np.isfinite(position).all(axis=1)
        if seen.any():
            r_S = straight(t, recording.t[seen], position[seen])
    return MotionHistory(
        t, batch.q, batch.qd, batch.x_WB, batch.w, r_S, v_S, batch.qd_rw
    )


NODES = 9
"""Times from one position of the sliders to the next; the integrator adds its own."""


class BasePose(NamedTuple):
    """Where the base is, inertial frame."""

    x_WB: Float[np.ndarray, "4"]
    r_S: Float[np.ndarray, "3"]
    """m."""


def reaction(
    robot: Robot,
    base: BasePose,
    start: Float[np.ndarray, " joints"],
    end: Float[np.ndarray, " joints"],
) -> BasePose:
    """The base after the joints moved, without momentum; held wheels do not spin.

    Then `D w + D_q qd = 0` (Eq. 18): where the base gets to depends on the way of the
    joints, not on their time. Joint positions before and after are in rad or m.
    """
    (first, last), none = np.zeros((2, start.size, 3)), np.zeros((start.size, 0))
    first[:, 0], last[:, 0] = start, end
    straight_on = Trajectory(1.0, robot.joint_names, none, none, first, last)
    still, wheels = np.zeros(3), np.zeros(len(robot.wheels))
    at_rest = BaseState(still, base.x_WB, still, wheels)
    t = np.linspace(0.0, 1.0, NODES)
    moved = free_floating(robot, straight_on, t, at_rest)
    return BasePose(moved.attitude[-1], base.r_S + moved.r_S[-1])
