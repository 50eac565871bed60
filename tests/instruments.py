"""Badly calibrated instruments: what they show of a truth."""

from dataclasses import dataclass, fields

import numpy as np
from scipy.spatial.transform import Rotation

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


@dataclass(frozen=True)
class Errors:
    """Calibration errors, in the core's order; SI."""

    zero: np.ndarray
    scale: np.ndarray
    wheel: np.ndarray
    feature_point: np.ndarray
    attitude: np.ndarray
    gyro: np.ndarray
    gyro_scale: np.ndarray
    position: np.ndarray

    @property
    def vector(self) -> np.ndarray:
        return np.concatenate([getattr(self, each.name) for each in fields(self)])

    def encoders(self, q: np.ndarray) -> np.ndarray:
        return (q - self.zero) / (1 + self.scale)

    def joint_rates(self, qd: np.ndarray) -> np.ndarray:
        return qd / (1 + self.scale)

    def wheel_rates(self, qd_rw: np.ndarray) -> np.ndarray:
        """Of wheels with so much less inertia and the same momentum."""
        return qd_rw / (1 + self.wheel)

    def rates(self, w: np.ndarray) -> np.ndarray:
        return (1 + self.gyro_scale) * rotation(self.gyro).inv().apply(w)

    def attitudes(self, x_WB: np.ndarray) -> np.ndarray:
        return (Rotation.from_quat(x_WB) * rotation(self.attitude)).as_quat()

    def positions(self, r: np.ndarray, x_WB: np.ndarray) -> np.ndarray:
        offset = Rotation.from_quat(x_WB).apply(self.feature_point)
        return (1 + self.position) * (r + offset)

    def velocities(self, v: np.ndarray, w: np.ndarray, x_WB: np.ndarray) -> np.ndarray:
        return v + Rotation.from_quat(x_WB).apply(np.cross(w, self.feature_point))


def random_errors(robot: Robot, seed: int, size: float) -> Errors:
    """All of them."""
    random = np.random.default_rng(seed)
    joints, wheels = len(robot.joints), len(robot.wheels)
    sizes = (joints, joints, wheels, 3, 3, 3, 3, 1)
    return Errors(*(size * random.standard_normal(n) for n in sizes))


def no_errors(robot: Robot) -> Errors:
    return random_errors(robot, 0, 0.0)


def rotation(m: np.ndarray) -> Rotation:
    """About a vector of length 2 sin(angle / 2)."""
    return Rotation.from_quat([*(m / 2), np.sqrt(1 - m @ m / 4)])


def shown_with(errors: Errors, robot: Robot, recording: Recording) -> Recording:
    """What was recorded without noise, by these instruments; velocity needs a gyro."""
    columns = dict(recording.columns)
    shown: dict[str, np.ndarray] = {}

    def put(name: str, values: np.ndarray, components: str = "xyz") -> None:
        shown.update(
            (f"{name}.{k}", column)
            for k, column in zip(components, values.T, strict=True)
        )

    x_WB = recording.vector("attitude", "xyzw")
    put("attitude", errors.attitudes(x_WB), "xyzw")
    if "position.x" in columns:
        put("position", errors.positions(recording.vector("position"), x_WB))
    if "gyro.x" in columns:
        w = recording.vector("gyro")
        put("gyro", errors.rates(w))
        if "velocity.x" in columns:
            put("velocity", errors.velocities(recording.vector("velocity"), w, x_WB))
    for k, name in enumerate(robot.joint_names):
        key = f"joint.{name}.position"
        shown[key] = (columns[key] - errors.zero[k]) / (1 + errors.scale[k])
    gains = {
        f"joint.{n}.velocity": errors.scale[k] for k, n in enumerate(robot.joint_names)
    }
    gains |= {
        f"wheel.{name}.{key}": errors.wheel[k]
        for k, name in enumerate(robot.wheel_names)
        for key in ("speed", "position")
    }
    shown |= {
        key: columns[key] / (1 + gain) for key, gain in gains.items() if key in columns
    }
    return Recording(recording.t, columns | shown)
