"""The information against differences of the momentum equations themselves."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.excitation.floating import craft_of
from orbident.excitation.information import Information, sensing_of
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import quaternion_matrix
from orbident.robot.sensor_schema import SensorsSpec
from orbident.simulation.free_floating import BaseState, free_floating

NODES = 81
STEP = 1e-5
"""Relative to the largest parameter; errors of central differences are its square."""


@pytest.fixture(scope="module")
def motion(servicer, table_2):
    initial = table_2.initial
    speeds = initial.wheel_speeds(servicer.wheel_names)
    start = BaseState(
        initial.angular_velocity, initial.attitude, initial.velocity, speeds
    )
    return free_floating(servicer, table_2, np.linspace(0.0, 80.0, NODES), start)


def predicted(robot, motion, theta):
    """`w` and `R_0^T (v_S - v_cm)` with the momentum and attitude of the motion."""
    h_rw = wheels_of(robot).A_rw @ motion.qd_rw[0]
    at = inertia(replace(robot, theta=theta), motion.q)
    R = quaternion_matrix(motion.attitude)
    D, D_q, r_cm, J_cm = at.D, at.D_q, at.r_cm, at.J_cm
    h_B = np.einsum("nji,j->ni", R, motion.h_cm)
    h_q = np.einsum("nij,nj->ni", D_q, motion.qd)
    w = np.linalg.solve(D, (h_B - h_rw - h_q)[..., None])[..., 0]
    v = -(np.cross(w, r_cm) + np.einsum("nij,nj->ni", J_cm, motion.qd))
    return w, np.einsum("nij,nj->ni", R, v)


def differences(robot, motion, direction):
    step = STEP / np.abs(direction).max()
    pairs = [
        predicted(robot, motion, robot.theta + s * step * direction)
        for s in (1.0, -1.0)
    ]
    return [(more - less) / (2 * step) for more, less in zip(*pairs, strict=True)]


def test_the_gyro_and_the_accelerometer(servicer, table_2, motion):
    """`F` from stacked rows, nuisances projected out: nothing is shared with ours."""
    sets = minimal_sets(servicer)
    sensing = sensing_of(servicer, sets)
    dt = motion.t[1]
    craft = craft_of(servicer, sets, table_2.initial, table_2.start, at_rest=False)
    seen = craft.seen(motion.q, motion.qd, motion.w, motion.attitude, dt)
    ours = Information(sensing, seen, at_rest=False).F

    # A theta for every change of the unknowns, and what it does to w and v_S.
    thetas = (sets.base.theta_of @ sensing.beta_of).T.reshape(-1, *servicer.theta.shape)
    dw, dv = zip(*(differences(servicer, motion, each) for each in thetas), strict=True)
    dw, dv = np.stack(dw, axis=-1), np.stack(dv, axis=-1)
    R = quaternion_matrix(motion.attitude)
    at = inertia(servicer, motion.q)
    dw_h = np.linalg.solve(at.D, np.swapaxes(R, 1, 2))
    dv_h = R @ np.cross(at.r_cm[:, :, None], dw_h, axis=1)
    gyro = np.sqrt(sensing.weights["gyro"] * dt)
    accelerometer = np.sqrt(sensing.weights["accelerometer"] / dt)
    one, none = np.broadcast_to(np.eye(3), R.shape), np.zeros_like(R)
    rows = np.concatenate(
        [
            gyro * np.concatenate([dw, dw_h, one, none], axis=2),
            accelerometer
            * np.concatenate(
                [np.diff(dv, axis=0), np.diff(dv_h, axis=0), none[1:], dt * R[1:]],
                axis=2,
            ),
        ]
    ).reshape(-1, thetas.shape[0] + 9)
    unknown, nuisance = rows[:, : len(thetas)], rows[:, len(thetas) :]
    Q = np.linalg.qr(nuisance / np.linalg.norm(nuisance, axis=0))[0]
    left = unknown - Q @ (Q.T @ unknown)
    expected = left.T @ left
    # Differences are good to 1e-7 of the largest entry.
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-6 * expected.max())


def test_without_sensors_the_information_is_refused(servicer):
    bare = replace(servicer, sensors=SensorsSpec())
    with pytest.raises(InputError, match="sensors: found no noise"):
        sensing_of(bare, minimal_sets(servicer))
