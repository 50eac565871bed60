"""Can a mistake be seen at all? What is left of it where every parameter is free.

The data are those of the mistake, without noise. The base parameters, the first state
and the gyro's bias are fitted to them by Gauss-Newton, sensors weighted by their noise.
What remains, in deviations, is what the best test that knows the cause could see. By
how much the parameters move, in theirs, is the harm that is done if nobody sees it.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from recordings import Clean, clean
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled

from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import JointState, inertia_at
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY
from orbident.simulation.free_floating import BaseState, free_floating

SEEN = 5.0
"""Deviations: tests of a hundred causes have a false alarm in a hundred beyond 3.9; in
nine of ten recordings a mistake of 5.2 exceeds that."""

ROUNDS = 12
SETTLED = 1e-3
"""Deviations, the step that ends the fit."""


class Visibility(NamedTuple):
    """How well a mistake can be seen, and what harm it does."""

    remains: float
    """Deviations that no parameters explain."""
    harm: float
    """Deviations that the worst base parameter moves."""

    @property
    def seen(self) -> bool:
        return self.remains > SEEN


class Measured(NamedTuple):
    """Joint motions as they were measured."""

    q: CubicSpline

    def at(self, t: np.ndarray) -> JointState:
        return self.q(t), self.q(t, 1), self.q(t, 2)


def visibility(name: str, spoil: Spoil) -> Visibility:
    """The visibility of a mistake on the robot of this name."""
    return visibility_of(clean(name), spoil)


def visibility_of(noisy: Clean, spoil: Spoil) -> Visibility:
    """The visibility of a mistake in the recording of any motion."""
    return Fit(noisy, spoil(_without_noise(noisy))).solve()


def _without_noise(noisy: Clean) -> Clean:
    """The same motion and sensors that show it as it is."""
    sensors = noisy.robot.sensors
    exact = {name: each.louder(0.0) for name, each in sensors.declared.items()}
    robot = replace(noisy.robot, sensors=sensors.model_copy(update=exact))
    return replace(noisy, robot=robot)


class Fit:
    """The fit of `x = [beta, rotation, position, velocity, rate, gyro bias]`; the rate
    is not there where the momentum is known to be zero, nor the bias without a gyro."""

    def __init__(self, noisy: Clean, spoiled: Spoiled):
        self.robot, self.recording = spoiled.robot, spoiled.recording
        self.sets = minimal_sets(self.robot)
        self.space = noisy.space
        self.at_rest = spoiled.initial_momentum == "at-rest"
        self.true = noisy
        self.betas = self.sets.base.T.shape[0]
        self.start = noisy.start
        self.joints = Measured(self._spline())
        self.speed = np.array([self._speed(name) for name in self.robot.wheel_names])
        self.weights = _weights(noisy)

    def _speed(self, wheel: str) -> float:
        """As its encoder shows it, or its tachometer alone, rad/s."""
        if not self.recording.has(f"wheel.{wheel}.position"):
            return float(self.recording.column(f"wheel.{wheel}.speed").mean())
        turns, t = self.recording.column(f"wheel.{wheel}.position"), self.recording.t
        return (turns[1] - turns[0]) / (t[1] - t[0])

    def _spline(self) -> CubicSpline:
        names = [f"joint.{name}.position" for name in self.robot.joint_names]
        q = np.column_stack([self.recording.column(name) for name in names])
        measured = np.isfinite(q).all(axis=1)
        return CubicSpline(self.recording.t[measured], q[measured])

    def solve(self) -> Visibility:
        """Fit by Gauss-Newton, with steps that may only lessen what is left."""
        axes = 3 if self.space else 1
        states = axes + 2 * (3 if self.space else 2) + (0 if self.at_rest else axes)
        biases = 3 if "gyro" in self.weights else 0
        x = np.zeros(self.betas + states + biases)
        x[: self.betas] = self.sets.beta(self.true.robot.theta)
        first, scale = x.copy(), self._scale(x)
        x[: self.betas] *= self._gain()
        r = self.residual(x)
        J = np.zeros((r.size, x.size))
        for _ in range(ROUNDS):
            J = self._derivative(x, scale)
            step = -np.linalg.lstsq(J, r, rcond=1e-12)[0]
            part = 1.0
            while part > 1e-3:
                new = self.residual(x + part * scale * step)
                if new @ new <= r @ r:
                    break
                part /= 2
            else:
                break
            done = np.linalg.norm(J @ step) < SETTLED
            x, r = x + part * scale * step, new
            if done:
                break
        return Visibility(float(np.linalg.norm(r)), self._harm(J, (x - first) / scale))

    def _gain(self) -> float:
        """The wheels' momentum as shown, over the true one: all base parameters are in
        proportion to it."""
        said = wheels_of(self.robot).A_rw @ self.speed
        h_rw = wheels_of(self.true.robot).A_rw @ self.start.wheel_speed
        return float(np.linalg.norm(said) / np.linalg.norm(h_rw))

    def _harm(self, J: np.ndarray, moved: np.ndarray) -> float:
        C = np.linalg.pinv(J.T @ J, rcond=1e-14)
        std = np.sqrt(np.diag(C))
        return float(np.abs(moved / std)[: self.betas].max())

    def _scale(self, x: np.ndarray) -> np.ndarray:
        scale = np.full(x.size, 1e-2)
        beta = np.abs(x[: self.betas])
        scale[: self.betas] = np.maximum(beta, 1e-3 * beta.max())
        return scale

    def _derivative(self, x: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """The derivative of the residual by `x / scale`, by central differences."""
        h, columns = 1e-5, []
        for k in range(x.size):
            d = np.zeros(x.size)
            d[k] = h * scale[k]
            columns.append((self.residual(x + d) - self.residual(x - d)) / (2 * h))
        return np.array(columns).T

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Measured less predicted, whitened; zero where nothing was measured."""
        beta, rest = np.split(x, [self.betas])
        theta = (self.sets.base.theta_of @ beta).reshape(-1, PER_BODY)
        robot = replace(self.robot, theta=theta)
        state, bias = self._state(robot, rest)
        motion = free_floating(robot, self.joints, self.recording.t, state.base)
        off = Rotation.from_quat(motion.attitude).inv() * Rotation.from_quat(
            np.nan_to_num(self.recording.vector("attitude", "xyzw"), nan=0.5)
        )
        missing = np.isnan(self.recording.column("attitude.x"))[:, None]
        parts = {
            "attitude": np.where(missing, 0.0, off.as_rotvec()),
            "position": self.recording.vector("position") - motion.r_S - state.r_S,
        }
        if "gyro" in self.weights:
            parts["gyro"] = self.recording.vector("gyro") - motion.w - bias
        return np.concatenate(
            [np.nan_to_num(parts[k] / self.weights[k]).ravel() for k in parts]
        )

    def _state(self, robot: Robot, rest: np.ndarray) -> tuple["First", np.ndarray]:
        axes, ways = (3, 3) if self.space else (1, 2)
        turn, r_S, v_S, more = np.split(rest, np.cumsum([axes, ways, ways]))
        turn, r_S, v_S = (_in_3d(each, self.space) for each in (turn, r_S, v_S))
        x_WB = Rotation.from_quat(self.start.attitude) * Rotation.from_rotvec(turn)
        at = inertia_at(robot, self.joints.q(0.0))
        h = at.D_q @ self.joints.q(0.0, 1) + wheels_of(robot).A_rw @ self.speed
        if self.at_rest:
            w = np.linalg.solve(at.D, -h)
            w = w if self.space else np.array([0.0, 0.0, -h[2] / at.D[2, 2]])
        else:
            w = self.start.angular_velocity + _in_3d(more[:axes], self.space)
            more = more[axes:]
        base = BaseState(w, x_WB.as_quat(), self.start.velocity + v_S, self.speed)
        return First(base, r_S), more if more.size else np.zeros(3)


class First(NamedTuple):
    """The first state."""

    base: BaseState
    r_S: np.ndarray


def _in_3d(part: np.ndarray, space: bool) -> np.ndarray:
    """A rotation about z, or a vector in the plane, as three numbers."""
    if space:
        return part
    return np.array([0.0, 0.0, part[0]]) if part.size == 1 else np.append(part, 0.0)


def _weights(noisy: Clean) -> dict[str, float]:
    """Deviations of a sample, SI."""
    sensors = noisy.robot.sensors
    dt = 1 / sensors.rows_per_second
    return {name: each.white_std(dt) for name, each in sensors.of_base.items()}
