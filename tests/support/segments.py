"""Shooting intervals of a simulated motion, as output error sees them."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from instruments import Errors, TrueMotion, no_errors
from random_robots import random_start, random_swing
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.estimation.output_error.problem import NO_ROWS, NOTHING, SENSORS
from orbident.estimation.solution import OUTSIDE, Linear, Unknowns
from orbident.model.core_robot import core_tree, wheels_of
from orbident.model.kinematics import carried_inertia, inertia_at
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import quaternion_matrix
from orbident.robot.description import Robot
from orbident.simulation.free_floating import free_floating
from orbident.simulation.measure import accelerations

GYRO, ACCELEROMETER = np.array([1.0, -2.0, 3.0]), np.array([0.3, 0.1, -0.2])
"""Biases, rad/s and m/s^2."""

Z = np.array([0.0, 0.0, 1.0])


class Segment(NamedTuple):
    """The sensors show the truth, with biases; all that varies has unit deviation."""

    recorded: _core.Recorded
    weights: dict[str, np.ndarray]
    state: Unknowns
    late: float = 0.0
    """Of the position and the velocity, s."""

    def residuals(self, state: Unknowns | None = None) -> dict[str, np.ndarray]:
        """The residuals of every sensor."""
        *_, tables = _core.linearised(self.recorded, **self._at(state, *SENSORS))
        return dict(zip(SENSORS, tables, strict=True))

    def equations(
        self, *sensors: str, state: Unknowns | None = None, interval: int = 0
    ) -> np.ndarray:
        """The equations of these sensors, then of continuity and of encoders."""
        at = self._at(state, *sensors)
        return _core.interval_equations(self.recorded, **at, interval=interval)

    def eliminated(self, threads: int = 1) -> Linear:
        """The equations of all sensors, after elimination."""
        factor, links, cost, tables = _core.linearised(
            self.recorded, **self._at(None, *SENSORS), threads=threads
        )
        residuals: dict[str, np.ndarray] = dict(zip(SENSORS, tables, strict=True))
        return Linear(factor, links, cost, residuals, self.state)

    def changed(self, others: Sequence["Segment"], threads: int = 1) -> np.ndarray:
        """The factor with a column for each of other segments, as if changed by one."""
        at = self._at(None, *SENSORS)
        own = at["acting"], self.state.common, self.state.selected
        every = [(each.recorded, *own) for each in others]
        return _core.changes_factor(
            self.recorded,
            **at,
            changed=every,
            sizes=np.ones(len(every)),
            threads=threads,
        )

    def _at(self, state: Unknowns | None, *sensors: str) -> dict[str, Any]:
        weights = [
            self.weights[name] * (name in sensors) if name in self.weights else NO_ROWS
            for name in SENSORS
        ]
        at = self.state if state is None else state
        white, nothing = np.zeros((2, 3, 4)), np.zeros((0, 15, 0))
        return dict(weights=weights, coloured=white, acting=nothing, **at._asdict())


def segment_of(
    robot: Robot,
    seed: int,
    rows: int = 8,
    dt: float = 0.02,
    substeps: int = 1,
    intervals: int = 1,
    errors: Errors | None = None,
    passive: Sequence[int] = (),
    drives: np.ndarray | None = None,
    follows: Sequence[tuple[int, int, float]] = (),
) -> Segment:
    """A segment from the simulator, at every node; nothing is interpolated.

    With errors of the instruments, these are shown, and all are unknowns. Passive
    joints swing as their springs want, from any state: not as the simulator's did. With
    drives (5 x joints: scale of its torque sensor, armature, viscous and Coulomb
    friction, offset) torques are shown too. Joints that follow, each with the one that
    it follows and a factor, have the corrections of that one.
    """
    by = errors or no_errors(robot)
    believed, robot = robot, by.robot(robot)
    t = np.arange(2 * rows - 1) * dt / 2
    swing = random_swing(seed, len(robot.joints))
    truth = TrueMotion(by, swing)
    motion = free_floating(robot, truth, t, random_start(seed, robot), 1e-12)
    q, qd, qdd = swing.at(t)
    rate = rate_at_rows(t)
    felt = accelerations(
        robot, motion, by.joints(q, qd, qdd)[2] + by.clock[0] * rate @ qdd
    )
    row = slice(None, None, 2)
    wheels = 6 + len(robot.joints)
    qd_rw, qdd_rw = by.wheels(motion.qd_rw, felt.v_dot[:, wheels:], rate)
    x_WB = motion.attitude[row]
    a = Rotation.from_quat(x_WB).apply(felt.f_S[row])
    samples = {
        "gyro": by.rates(motion.w[row]) + GYRO,
        "accelerometer": felt.f_S[row] + ACCELEROMETER,
        "attitude": by.attitudes(x_WB, motion.w[row]),
        "joints": q[row],
        "position": by.positions(motion.r_S[row], motion.v_S[row], x_WB),
        "velocity": by.velocities(motion.v_S[row], a, motion.w[row], x_WB),
        "torques": np.zeros((0, 3)),
    }
    every = np.ones(3)
    turning, moving = (Z, every - Z) if robot.motion == "planar" else (every, every)
    axes = {
        "gyro": turning,
        "accelerometer": moving,
        "attitude": turning,
        "joints": np.ones(len(robot.joints)),
        "position": moving,
        "velocity": moving,
    }
    weights = {name: np.tile(axis, (rows, 1)) for name, axis in axes.items()}
    weights["accelerometer"][-1] = 0.0
    sets, joints = minimal_sets(believed), len(robot.joints)
    r_cm = inertia_at(robot, motion.q[0]).r_cm
    r_cm = quaternion_matrix(motion.attitude[0]) @ r_cm
    outside = NOTHING._replace(h_cm=motion.h_cm, v_cm=motion.v_cm, r_cm=r_cm)
    edges = np.round(np.linspace(0, rows, intervals + 1))
    led = [joint for joint, *_ in follows]
    corrected = [k for k in range(joints) if k not in led]
    weights["joints"][:, led] = 0.0
    local = np.zeros((intervals + 1, 9 + 2 * len(corrected)))
    local[:, 3:9] = np.append(GYRO, ACCELEROMETER)
    for history in (q, qd, qdd):
        history[:, list(passive)] = 0.0
    random = np.random.default_rng(seed)
    for k in passive:
        at = 9 + corrected.index(k)
        local[:, [at, at + len(corrected)]] = random.standard_normal((len(local), 2))
    over_intervals = np.zeros((intervals, joints, 2))
    if drives is not None:
        scale, armature, viscous, coulomb, offset = drives
        jerk = make_interp_spline(t, qdd, k=5).derivative()(t)
        _, qd_true, qdd_true = by.joints(q, qd, qdd)
        qdd_true = qdd_true + by.clock[0] * jerk
        torque = (
            accelerations(robot, motion, qdd_true).Q[:, 6:wheels]
            + armature * qdd_true
            + viscous * qd_true
        )
        ends = t[2 * np.minimum(edges.astype(int), rows - 1)]
        lasts = np.diff(ends)[:, None]
        spline = make_interp_spline(t, torque, k=5)
        mean = np.diff(spline.antiderivative()(ends), axis=0) / lasts
        signs = np.random.default_rng(seed).uniform(-1, 1, mean.shape)
        change = np.diff(spline(ends), axis=0) / lasts
        over_intervals = np.stack([signs, change], axis=-1)
        first = edges[:-1].astype(int)
        samples["torques"], weights["torques"] = np.zeros((2, rows, joints))
        shown = (1 + scale) * (mean + coulomb * signs + offset)
        samples["torques"][first] = shown - by.clock[0] * change
        weights["torques"][first] = 1.0
    laws = [[9.0, 0.5, 1.0, 1.0, *carried_inertia(believed, k)] for k in passive]
    recorded = _core.Recorded(
        tree=core_tree(believed),
        theta_0=robot.theta.ravel() - sets.base.theta_of @ sets.beta(robot.theta),
        theta_of=sets.base.theta_of,
        planar=robot.motion == "planar",
        substeps=substeps,
        corrected=np.array(corrected, dtype=float),
        follows=np.reshape(follows, (-1, 3)).astype(float),
        t=t[::2],
        edge=edges.astype(float),
        knots=t,
        q=columns(q),
        q_slope=columns(qd),
        qd=columns(qd),
        qdd=columns(qdd),
        A_rw=np.ascontiguousarray(wheels_of(believed).A_rw.T),
        qd_rw=columns(qd_rw),
        qdd_rw=columns(qdd_rw),
        samples=[np.ascontiguousarray(samples[name]) for name in SENSORS],
        first=np.ones(9 + 2 * len(corrected)),
        corrections=np.ones(2 * len(corrected)),
        walk=np.ones(9),
        passive=np.array(passive, dtype=float),
        laws=np.reshape(laws, (len(passive), 4 + robot.theta.size)),
        driven=np.zeros((joints, 4)),
        over_intervals=over_intervals,
    )
    common = np.concatenate([*outside, sets.beta(robot.theta)])
    assert common.size == OUTSIDE + sets.base.theta_of.shape[1]
    meets = 2 * np.minimum(edges.astype(int), rows - 1)
    state = Unknowns(np.ascontiguousarray(motion.attitude[meets]), local, common)
    if errors is not None:
        state = state.selecting(np.arange(by.vector.size, dtype=float))
        state = state._replace(common=np.append(common, by.vector))
    if drives is not None:
        last = recorded.places
        state = state.selecting(np.arange(last - drives.size, last, dtype=float))
        state.common[-drives.size :] = drives.ravel()
    return Segment(recorded, weights, state, float(by.clock[2]))


def columns(table: np.ndarray) -> list[np.ndarray]:
    """The columns of a table, each for itself."""
    return [np.ascontiguousarray(x) for x in table.T]


def rate_at_rows(t: np.ndarray) -> np.ndarray:
    """The matrix that takes values to their rates: by the parabola through a row,
    half-way and the next row, or the one before the last; zero half-way."""
    rate, parabola = np.zeros((t.size, t.size)), np.array([-3, 4, -1])
    for node in range(0, t.size - 2, 2):
        rate[node, node : node + 3] = parabola / (t[node + 2] - t[node])
    rate[-1, -3:] = parabola[::-1] / (t[-3] - t[-1])
    return rate
