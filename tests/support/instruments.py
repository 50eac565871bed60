"""Badly calibrated instruments: what they show of a truth."""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from orbident.model.kinematics import JointState
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.free_floating import JointMotion


@dataclass(frozen=True)
class Errors:
    """Calibration errors, in the core's order; SI."""

    zero: np.ndarray
    scale: np.ndarray
    wheel: np.ndarray
    axis: np.ndarray
    """Turns of the axes of wheels about the base's, three numbers each."""
    feature_point: np.ndarray
    attitude: np.ndarray
    gyro: np.ndarray
    gyro_scale: np.ndarray
    position: np.ndarray
    clock: np.ndarray
    """How late joints and wheels, the attitude and the position are shown."""
    place: np.ndarray
    """Displacement of the joints in their parents' axes, three numbers each."""
    direction: np.ndarray

    @property
    def vector(self) -> np.ndarray:
        return np.concatenate([getattr(self, each.name) for each in fields(self)])

    def robot(self, robot: Robot) -> Robot:
        """The true one, whose joints are elsewhere and whose wheels are tilted."""
        moved = zip(
            robot.joints,
            self.place.reshape(-1, 3),
            rotation(self.direction.reshape(-1, 3)).as_matrix(),
            strict=True,
        )
        joints = (
            replace(joint, p_PJ=joint.p_PJ + place, R_PJ=R @ joint.R_PJ)
            for joint, place, R in moved
        )
        turns = rotation(self.axis.reshape(-1, 3)).as_matrix()
        wheels = tuple(
            replace(wheel, axis=R @ wheel.axis)
            for wheel, R in zip(robot.wheels, turns, strict=True)
        )
        return replace(robot, joints=tuple(joints), wheels=wheels)

    def joints(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> JointState:
        """The true ones, but for what the third derivative adds to accelerations."""
        gain, late = 1 + self.scale, self.clock[0]
        return gain * q + self.zero + late * qd, gain * qd + late * qdd, gain * qdd

    def wheels(
        self, qd: np.ndarray, qdd: np.ndarray, rate: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rates and accelerations of wheels with less inertia, the same momentum.

        Args:
            qd: the true rates, samples x wheels.
            qdd: the true accelerations.
            rate: takes accelerations at all samples to their rates.
        """
        gain, late = 1 + self.wheel, self.clock[0]
        systems = gain[:, None, None] * np.eye(len(qdd)) + late * rate
        a = np.linalg.solve(systems, qdd.T[..., None])[..., 0].T
        return (qd - late * a) / gain, a

    def rates(self, w: np.ndarray) -> np.ndarray:
        return (1 + self.gyro_scale) * rotation(self.gyro).inv().apply(w)

    def attitudes(self, x_WB: np.ndarray, w: np.ndarray) -> np.ndarray:
        old = Rotation.from_quat(x_WB) * rotation(-self.clock[1] * w)
        return (old * rotation(self.attitude)).as_quat()

    def positions(self, r: np.ndarray, v: np.ndarray, x_WB: np.ndarray) -> np.ndarray:
        offset = Rotation.from_quat(x_WB).apply(self.feature_point)
        return (1 + self.position) * (r + offset - self.clock[2] * v)

    def velocities(
        self, v: np.ndarray, a: np.ndarray, w: np.ndarray, x_WB: np.ndarray
    ) -> np.ndarray:
        """Those of a point, from velocity and acceleration of S, inertial axes."""
        beside = Rotation.from_quat(x_WB).apply(np.cross(w, self.feature_point))
        return v + beside - self.clock[2] * a


@dataclass(frozen=True)
class TrueMotion:
    """The true motion of joints whose encoders show the motion `shown`."""

    errors: Errors
    shown: JointMotion

    def at(self, t: np.ndarray) -> JointState:
        return self.errors.joints(*self.shown.at(t))


def random_errors(robot: Robot, seed: int, size: float) -> Errors:
    """All of them; a planar robot stays planar."""
    random = np.random.default_rng(seed)
    joints, wheels = len(robot.joints), len(robot.wheels)
    sizes = joints, joints, wheels, 3 * wheels, 3, 3, 3, 3, 1, 3, 3 * joints, 3 * joints
    errors = Errors(*(size * random.standard_normal(n) for n in sizes))
    if robot.motion == "planar":
        errors.axis[:] = 0.0
        errors.place[2::3] = 0.0
        errors.direction[np.arange(3 * joints) % 3 < 2] = 0.0
    return errors


def no_errors(robot: Robot) -> Errors:
    return random_errors(robot, 0, 0.0)


def rotation(m: np.ndarray) -> Rotation:
    """About a vector of length 2 sin(angle / 2), or about each of an array."""
    half = m / 2
    w = np.sqrt(1 - np.sum(half**2, axis=-1, keepdims=True))
    return Rotation.from_quat(np.concatenate([half, w], axis=-1))


def _delayed(t: np.ndarray, x: np.ndarray, late: float) -> np.ndarray:
    """`x` as it was `late` before, by the quintic through all samples."""
    return make_interp_spline(t, x, k=5)(t - late)


def shown_with(errors: Errors, robot: Robot, recording: Recording) -> Recording:
    """What was recorded of all sensors without noise, by these instruments."""
    t, columns = recording.t, dict(recording.columns)
    shown: dict[str, np.ndarray] = {}

    def put(name: str, values: np.ndarray, components: str = "xyz") -> None:
        shown.update(
            (f"{name}.{k}", column)
            for k, column in zip(components, values.T, strict=True)
        )

    x_WB = recording.vector("attitude", "xyzw")
    w, v = recording.vector("gyro"), recording.vector("velocity")
    put("attitude", errors.attitudes(x_WB, w), "xyzw")
    put("position", errors.positions(recording.vector("position"), v, x_WB))
    put("gyro", errors.rates(w))
    a = make_interp_spline(t, v, k=5).derivative()(t)
    put("velocity", errors.velocities(v, a, w, x_WB))
    offsets = {
        f"joint.{n}.position": errors.zero[k] for k, n in enumerate(robot.joint_names)
    }
    gains = {
        f"joint.{name}.{key}": errors.scale[k]
        for k, name in enumerate(robot.joint_names)
        for key in ("position", "velocity")
    }
    gains |= {
        f"wheel.{name}.{key}": errors.wheel[k]
        for k, name in enumerate(robot.wheel_names)
        for key in ("speed", "position")
    }
    for key, gain in gains.items():
        if key in columns:
            seen = _delayed(t, columns[key], errors.clock[0])
            shown[key] = (seen - offsets.get(key, 0.0)) / (1 + gain)
    return Recording(t, columns | shown)
