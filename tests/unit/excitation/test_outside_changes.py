"""What may act, against its covariance in the data and against differences."""

from dataclasses import replace

import numpy as np
import pytest
from design_gradients import check_gradient
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import block_diag

from orbident.environment.worlds import radius_of_gyration
from orbident.excitation.conditions import conditions_for
from orbident.excitation.design_problem import problem_for
from orbident.excitation.floating import craft_of, was_at_rest
from orbident.excitation.information import Information, sensing_of
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import quaternion_matrix
from orbident.robot.may_act import MayAct
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.studies.spatial import paper_case

ON_A_TABLE = {
    "slow_torque": MayAct(2e-3, 6.0),
    "pull": MayAct(1e-3),
    "uneven": MayAct(5e-4),
    "drag": MayAct(0.015),
}
IN_SPACE = {"slow_torque": MayAct(0.02, 60.0), "pull": MayAct(1e-4)}
TURNING = {
    "base_torque": MayAct(0.01),
    "slow_base_torque": MayAct(0.02, 60.0),
    "wheel_loss": MayAct(0.02, 60.0),
}


class Dense:
    """The paper's motion of a robot at some nodes, and rows as data sheets state them.

    The changes that are given have the axes in which momentum is conserved.
    """

    def __init__(self, robot, nodes):
        self.robot, self.trajectory = robot, paper_case(robot).trajectory
        self.sets = minimal_sets(robot)
        self.sensing = sensing_of(robot, self.sets)
        initial = self.trajectory.initial
        speeds = initial.wheel_speeds(robot.wheel_names)
        start = BaseState(
            initial.angular_velocity, initial.attitude, initial.velocity, speeds
        )
        t = np.linspace(0.0, self.trajectory.duration, nodes)
        self.motion = free_floating(robot, self.trajectory, t, start)
        self.t, self.dt = t, t[1]
        self.R = quaternion_matrix(self.motion.attitude)
        self.at_rest = was_at_rest(robot, initial, self.trajectory.start)

    def ours(self):
        """The information as the search computes it."""
        craft = craft_of(
            self.robot,
            self.sets,
            self.trajectory.initial,
            self.trajectory.start,
            self.at_rest,
        )
        m = self.motion
        seen = craft.seen(m.q, m.qd, m.w, m.attitude, self.dt)
        return Information(self.sensing, seen, self.at_rest).F

    def moved(self, theta):
        """`w` and `v_S` less the CM's velocity, momentum and attitude as they are."""
        h, m = list(self.sensing.h), self.motion
        h_rw = wheels_of(self.robot).A_rw @ m.qd_rw[0]
        at = inertia(replace(self.robot, theta=theta), m.q)
        h_B = np.einsum("nji,j->ni", self.R, m.h_cm) - h_rw
        h_B -= np.einsum("nij,nj->ni", at.D_q, m.qd)
        w = np.zeros_like(h_B)
        D = at.D[:, h][:, :, h]
        w[:, h] = np.linalg.solve(D, h_B[:, h, None])[..., 0]
        v = -(np.cross(w, at.r_cm) + np.einsum("nij,nj->ni", at.J_cm, m.qd))
        return w, np.einsum("nij,nj->ni", self.R, v)

    def by_unknowns(self):
        """Changes of `w` and `v_S` by each unknown, by differences."""
        dw, dv = [], []
        for direction in (self.sets.base.theta_of @ self.sensing.beta_of).T:
            direction = direction.reshape(self.robot.theta.shape)
            step = 1e-5 / np.abs(direction).max()
            (more, more_v), (less, less_v) = (
                self.moved(self.robot.theta + s * step * direction) for s in (1, -1)
            )
            dw.append((more - less) / (2 * step))
            dv.append((more_v - less_v) / (2 * step))
        return np.stack(dw, axis=-1), np.stack(dv, axis=-1)

    def by_momentum(self, dh, dv_cm):
        """Changes of `w`, `v_S` by those of the momenta, all axes, inertial ones."""
        h = list(self.sensing.h)
        at = inertia(self.robot, self.motion.q)
        dw, D = np.zeros_like(dh), at.D[:, h][:, :, h]
        dw[:, h] = np.linalg.solve(D, (np.swapaxes(self.R, 1, 2) @ dh)[:, h])
        dv = self.R @ np.cross(at.r_cm[:, :, None], dw, axis=1)
        return dw, dv + dv_cm

    def rows(self, dw, dv, felt):
        """What all sensors see, over their noise."""
        h, v = list(self.sensing.h), list(self.sensing.v)
        see = {
            "gyro": lambda: dw[:, h],
            "attitude": lambda: self.integral(self.R @ dw)[:, h],
            "accelerometer": lambda: np.diff(felt, axis=0)[:, v] / self.dt,
            "position": lambda: self.integral(dv)[:, v],
        }
        return np.concatenate(
            [
                np.sqrt(weight * self.dt) * see[sensor]().reshape(-1, dw.shape[2])
                for sensor, weight in self.sensing.weights.items()
            ]
        )

    def integral(self, x):
        return cumulative_trapezoid(x, dx=self.dt, axis=0, initial=0.0)

    def own_constants(self):
        """Columns of the constants of each sensor, and of the momentum."""
        one, t = np.broadcast_to(np.eye(3), self.R.shape), self.t[:, None, None]
        h, v = list(self.sensing.h), list(self.sensing.v)
        own = {
            "gyro": one[:, h][:, :, h],
            "attitude": one[:, h][:, :, h],
            "accelerometer": self.R[1:][:, v][:, :, v],
            "position": np.concatenate([one[:, :, v], t * one[:, :, v]], 2)[:, v],
        }
        blocks = [own[sensor] for sensor in self.sensing.weights]
        columns = np.asarray(block_diag(*(x.reshape(-1, x.shape[2]) for x in blocks)))
        if not self.at_rest:
            dw, dv = self.by_momentum(one, 0.0)
            columns = np.column_stack([columns, self.rows(dw, dv, dv)])
        return columns

    def slow_torque(self, size, shortest):
        """Rows of a torque at each node about each axis, and its covariance."""
        n, h = self.t.size, list(self.sensing.h)
        impulses = np.zeros((n, 3, n * len(h)))
        for j, axis in enumerate(h):
            impulses[:, axis, j * n : (j + 1) * n] = np.eye(n)
        dw, dv = self.by_momentum(self.integral(impulses), 0.0)
        lag = self.t[:, None] - self.t
        K = size**2 * (1 + np.exp(-(lag**2) / 2 / (shortest / np.pi) ** 2))
        return self.rows(dw, dv, dv), np.kron(np.eye(len(h)), K)

    def information(self, acting):
        """Generalised least squares: what acts is part of the data's covariance."""
        dw, dv = self.by_unknowns()
        A, N = self.rows(dw, dv, dv), self.own_constants()
        S = np.eye(len(A))
        for columns, covariance in acting:
            S += columns @ covariance @ columns.T
        L = np.linalg.cholesky(S)
        A, N = np.linalg.solve(L, A), np.linalg.solve(L, N)
        Q = np.linalg.qr(N / np.linalg.norm(N, axis=0))[0]
        left = A - Q @ (Q.T @ A)
        return left.T @ left


def deviations(F):
    return np.sqrt(np.diag(np.linalg.inv(F)))


def test_on_a_table(emulator):
    """Film and slopes by where the base is, and not by how fast it moves."""
    dense = Dense(replace(emulator, disturbances=ON_A_TABLE), 401)
    n, t, motion = dense.t.size, dense.t, dense.motion
    none, M = np.zeros((n, 3, 1)), emulator.mass
    at = inertia(emulator, motion.q)
    x = -np.einsum("nij,nj->ni", dense.R, at.r_cm)
    v_cm = motion.v_S[0] - dense.moved(emulator.theta)[1][0]
    steps = np.diff(x, axis=0) + v_cm * dense.dt
    swept = np.cumsum(np.cross((x[1:] + x[:-1]) / 2, steps), axis=0)
    dragged = np.concatenate([np.zeros((1, 3)), -swept])[..., None]
    slowed = (-(x - x[0] + np.outer(t, v_cm)) / M)[..., None]
    angle = dense.integral(motion.w)[..., None]
    fallen = np.einsum("n,ij->nij", t, np.eye(3)[:, :2])
    # The pull is v_cm t times each entry of a symmetric matrix.
    x_cm, y_cm, _ = v_cm
    entries = ([x_cm, 0, 0], [y_cm, x_cm, 0], [0, y_cm, 0])
    sloped = np.einsum("n,ki->nik", t**2 / 2, entries)
    gyration = radius_of_gyration(emulator)
    sizes = ON_A_TABLE
    acting = [dense.slow_torque(*sizes["slow_torque"])]
    for dh, dv, std in (
        (dragged, slowed, sizes["drag"].size),
        (-angle, none, sizes["drag"].size * gyration**2),
        (np.zeros((n, 3, 2)), fallen, sizes["pull"].size),
        (np.zeros((n, 3, 3)), sloped, sizes["uneven"].size),
    ):
        dw, dv = dense.by_momentum(dh, dv)
        acting.append((dense.rows(dw, dv, dv), std**2 * np.eye(dw.shape[2])))
    expected = deviations(dense.information(acting))
    # Trapezia of 20 s in 400 steps; alone, deviations are a tenth of these.
    assert deviations(dense.ours()) == pytest.approx(expected, rel=2e-3)
    alone = deviations(dense.information([]))
    assert (expected > 1.02 * alone).all()
    quiet = Dense(replace(emulator, disturbances={}), 401)
    assert deviations(quiet.ours()) == pytest.approx(alone, rel=1e-4)


def test_in_space(servicer):
    """An accelerometer does not feel a pull."""
    dense = Dense(replace(servicer, disturbances=IN_SPACE), 81)
    acting = [dense.slow_torque(*IN_SPACE["slow_torque"])]
    expected = deviations(dense.information(acting))
    assert deviations(dense.ours()) == pytest.approx(expected, rel=3e-3)
    alone = deviations(dense.information([]))
    assert (expected > 1.1 * alone).all()


def test_sizes_of_zero_are_nothing(emulator):
    nothing = {name: MayAct(0.0) for name in ON_A_TABLE}
    zero, none = (
        Dense(replace(emulator, disturbances=each), 65).ours() for each in (nothing, {})
    )
    np.testing.assert_array_equal(zero, none)


@pytest.mark.parametrize(
    ("name", "acting", "pads", "rel"),
    [
        ("emulator", ON_A_TABLE, (), 2e-3),
        ("emulator", {"drag": MayAct(0.01)}, ("base", "link2"), 5e-3),
        ("servicer", IN_SPACE, (), 1e-5),
        ("servicer", TURNING, (), 2e-2),
        # Sizes go with the motion's momentum.
        ("servicer", None, (), 1e-4),
    ],
)
def test_the_gradient_by_differences(request, name, acting, pads, rel):
    robot = request.getfixturevalue(name)
    places = {robot.bodies[k]: np.array([0.1, 0.05, 0.0]) for k in range(3)}
    robot = replace(robot, disturbances=acting, pads=places if pads else {})
    given = conditions_for(robot, 20.0 if name == "emulator" else 80.0, 4)
    problem = problem_for(robot, given, "d", 0.0)
    check_gradient(problem, 5e-4, rel)
