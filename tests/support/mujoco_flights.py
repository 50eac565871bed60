"""Robots that MuJoCo flies while something acts on them, and what their sensors show.

MuJoCo integrates every body, wheel and rotor. Joints and wheels are servoed: computed
torques that know nothing of what acts, and a PD law that holds against it. A rotor is
held to its joint's rate times its gear by what acts between bodies of the robot. What
only MuJoCo knows of, such as a panel on a spring, no motor moves.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np
from acting_in_mujoco import Acts, Capture, Stage
from mujoco_model import mujoco_spec, rotor_name

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.measure import Truth, measure_truth
from orbident.trajectories.trajectory import Trajectory

STEP = 0.01
"""s; half of it moves no attitude or place by more than 1e-9 rad or 3e-9 m."""

KP, KD, WHEEL_KD = 9.0, 6.0, 4.0
"""1/s^2, 1/s and 1/s: joints settle in a second."""


@dataclass(frozen=True, eq=False)
class Flight:
    """A robot, what it is told to do, and what acts on it."""

    robot: Robot
    """As it is at the start."""
    motion: Trajectory
    acts: Acts
    breath: float = 0.0
    """The wheels' speeds rise and fall once, by this part of them."""
    ramp: float = 0.0
    """One wheel after another is so much faster for a while, rad/s: its speed rises and
    falls at a constant rate, with corners."""
    dt: float = STEP
    """MuJoCo's steps, s."""
    hidden: Callable[[mujoco.MjSpec], None] = lambda _: None
    """Adds what the robot does not have; its mass is that of no body of the robot."""

    def recorded(self, seed: int) -> Recording:
        """What the robot's sensors show of it, with the noise of this seed."""
        return measure_truth(self.robot, *self.flown, seed)

    @cached_property
    def flown(self) -> tuple[np.ndarray, Truth]:
        """Times, and what is true at them."""
        plant = _Plant(self)
        every = round(1 / self.robot.sensors.rows_per_second / self.dt)
        rows = []
        mujoco.set_mjcb_control(plant)
        try:
            plant.start()
            rows.append(plant.row())
            for k in range(round(self.motion.duration / self.dt)):
                plant.step(k)
                if (k + 1) % every == 0:
                    rows.append(plant.row())
        finally:
            mujoco.set_mjcb_control(None)
        t, *columns = (np.array(column) for column in zip(*rows, strict=True))
        true = Truth(*columns)
        return t, true._replace(
            q_rw=true.q_rw - true.q_rw[0], position=true.position - true.position[0]
        )


class _Plant:
    """MuJoCo's robot, and the law that drives its joints and wheels."""

    def __init__(self, flight: Flight):
        self.flight, robot = flight, flight.robot
        self.planar = robot.motion == "planar"
        self.model, acts = _embodied(robot, flight), flight.acts
        if isinstance(acts, Capture):
            # Compiling a model calls the law that drives: this is before it is set.
            theta = acts.onto(robot.theta, robot.bodies)
            self.after = _embodied(replace(robot, theta=theta), flight)
        self.data = mujoco.MjData(self.model)
        geared = {k: r for k, r in robot.rotors.items() if r.inertia}
        self.gear = np.array([rotor.gear for rotor in geared.values()])
        self.geared = [robot.joint_names.index(name) for name in geared]
        model, rotors = self.model, map(rotor_name, geared)
        names = (*robot.joint_names, *robot.wheel_names, *rotors)
        self.driven = np.array([model.joint(name).dofadr[0] for name in names])
        self.places = np.array([model.joint(name).qposadr[0] for name in names])
        # The base comes first: x, y and its turn on a table, or three and three.
        self.left = np.setdiff1d(np.arange(model.nv), self.driven)
        self.M = np.zeros((model.nv, model.nv))
        # RK4 asks at the ends and in the middle of a step.
        halves = 2 * round(flight.motion.duration / flight.dt)
        nodes = np.arange(halves + 1) * flight.dt / 2
        self.commanded = flight.motion.for_robot(robot).at(nodes)
        speeds = flight.motion.initial.wheel_speeds(robot.wheel_names)
        angle = 2 * np.pi * nodes[:, None] / flight.motion.duration
        turning = 2 * np.pi / flight.motion.duration
        self.speeds = speeds * (1 + flight.breath * np.sin(angle))
        self.slopes = speeds * flight.breath * turning * np.cos(angle)
        for part, size in ((0.2, flight.ramp), (0.55, -flight.ramp)):
            since = nodes[:, None] / flight.motion.duration - part
            risen = (since - 0.07 * np.arange(speeds.size)) / 0.15
            self.speeds += size * np.clip(risen, 0.0, 1.0)
            rises = (risen > 0) & (risen < 1)
            self.slopes += size * rises / (0.15 * flight.motion.duration)
        self.inside = flight.dt / 2
        self.tau = np.zeros(len(robot.joints))

    def start(self) -> None:
        """Stand as the trajectory begins."""
        data, initial = self.data, self.flight.motion.initial
        q, qd, _ = (history[0] for history in self.commanded)
        data.qpos[self.places[: q.size]] = q
        data.qvel[self.driven] = [*qd, *self.speeds[0], *self.gear * qd[self.geared]]
        if self.planar:
            x, y, z, w = initial.attitude
            assert x == y == 0.0
            data.qpos[2] = 2 * np.arctan2(z, w)
            data.qvel[2] = initial.angular_velocity[2]
        else:
            data.qpos[3:7] = np.roll(initial.attitude, 1)
            data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
            data.qvel[3:6] = initial.angular_velocity
        mujoco.mj_forward(self.model, data)

    def step(self, k: int) -> None:
        acts = self.flight.acts
        if isinstance(acts, Capture) and k == round(acts.at / self.flight.dt):
            self._capture()
        self.inside = (k + 0.5) * self.flight.dt
        mujoco.mj_step(self.model, self.data)

    def _capture(self) -> None:
        """What is at rest adds no momentum; joints and wheels hold their rates."""
        data, left, driven = self.data, self.left, self.driven
        before = self._mass_matrix()[left] @ data.qvel
        self.model = self.after
        mujoco.mj_forward(self.model, data)
        M = self._mass_matrix()
        rest = before - M[np.ix_(left, driven)] @ data.qvel[driven]
        data.qvel[left] = np.linalg.solve(M[np.ix_(left, left)], rest)

    def _mass_matrix(self) -> np.ndarray:
        mujoco.mj_fullM(self.model, self.data, self.M)
        return self.M.copy()

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Torques for the commanded accelerations, as if nothing acted; what acts."""
        node = round(data.time * 2 / self.flight.dt)
        q, qd, qdd = (history[node] for history in self.commanded)
        left, driven, n = self.left, self.driven, q.size
        wheels = n + self.speeds.shape[1]
        rate = data.qvel[driven]
        a = np.zeros(model.nv)
        a[driven[:n]] = qdd + KD * (qd - rate[:n])
        a[driven[:n]] += KP * (q - data.qpos[self.places[:n]])
        off = self.speeds[node] - rate[n:wheels]
        a[driven[n:wheels]] = self.slopes[node] + WHEEL_KD * off
        slip = self.gear * rate[self.geared] - rate[wheels:]
        a[driven[wheels:]] = self.gear * a[driven[self.geared]] + WHEEL_KD * slip
        mujoco.mj_fullM(model, data, self.M)
        M, bias = self.M, data.qfrc_bias
        force = (
            data.qfrc_passive[left] - bias[left] - M[np.ix_(left, driven)] @ a[driven]
        )
        a[left] = np.linalg.solve(M[np.ix_(left, left)], force)
        outside = np.zeros(model.nv)
        self.flight.acts(Stage(model, data, self.inside), outside)
        data.qfrc_applied[:] = outside
        own = (M @ a + bias)[driven]
        data.qfrc_applied[driven] += own
        # On a joint, and on its rotor, which turns so many times as far.
        self.tau = own[:n].copy()
        self.tau[self.geared] += self.gear * own[wheels:]

    def row(self) -> tuple[np.ndarray | float, ...]:
        """Time, and what is true at it, in the order of `Truth`."""
        data, joints = self.data, len(self.flight.robot.joints)
        shown = joints + self.speeds.shape[1]
        x, v = data.qpos[self.places][:shown], data.qvel[self.driven][:shown]
        felt = np.zeros(3)
        if self.planar:
            px, py, turn = data.qpos[:3]
            vx, vy, w = data.qvel[:3]
            rate, attitude = np.array([0, 0, w]), _about_z(turn)
            place, velocity = np.array([px, py, 0.0]), np.array([vx, vy, 0.0])
        else:
            rate, attitude = data.qvel[3:6].copy(), np.roll(data.qpos[3:7], -1)
            place, velocity = data.qpos[:3].copy(), data.qvel[:3].copy()
            mujoco.mj_forward(self.model, data)
            felt = data.xmat[self.model.body("base").id].reshape(3, 3).T @ data.qacc[:3]
        return (
            data.time,
            x[:joints],
            v[:joints],
            x[joints:],
            v[joints:],
            rate,
            felt,
            attitude,
            place,
            velocity,
            self.tau.copy(),
        )


def _embodied(robot: Robot, flight: Flight) -> mujoco.MjModel:
    """MuJoCo's model; its wheels are at the CM of the base."""
    com = robot.theta[0, 1:4] / robot.theta[0, 0]
    spec = mujoco_spec(robot, [com] * len(robot.wheels))
    flight.hidden(spec)
    model = spec.compile()
    model.opt.timestep = flight.dt
    return model


def _about_z(turn: float) -> np.ndarray:
    return np.array([0.0, 0.0, np.sin(turn / 2), np.cos(turn / 2)])
