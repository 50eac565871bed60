"""Torques in one step of the filter, against energies, differences and elimination.

The reference is `reference/driven_joints.py`.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_motions import random_motion
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_wheels,
)
from recorded_samples import random_samples
from reference.driven_joints import forgotten, gained, momentum_rows
from reference.filter_step import (
    axes_of,
    information,
    laws,
    transition,
    white_equations,
)

from orbident.estimation.recursive.driven_joints import DrivenJoints, torques_of
from orbident.estimation.recursive.filter import (
    Extended,
    GaussianPrior,
    Sample,
    packed,
)
from orbident.estimation.recursive.filter_input import Noise
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import TorqueSpec
from orbident.simulation.simulate import simulate

pytestmark = pytest.mark.core


def driven_samples(robot: Robot, count: int, driven: int, random) -> list[Sample]:
    """Some rates turn back, some torques are missing, and once there is a gap."""
    samples = []
    for k, sample in enumerate(random_samples(robot, count)):
        impulse = random.standard_normal(driven)
        impulse[random.uniform(size=driven) < 0.1] = np.nan
        qd = random.uniform(-0.2, 1.0, sample.qd.size)
        t = sample.t + (0.5 if k > count / 2 else 0.0)
        samples.append(sample._replace(t=t, qd=qd, impulse=impulse))
    return samples


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**16),
    slides=st.lists(st.booleans(), min_size=1, max_size=3),
    planar=st.booleans(),
    wheels=st.booleans(),
    accelerometer=st.booleans(),
)
def test_one_step(
    seed: int, slides: list[bool], planar: bool, wheels: bool, accelerometer: bool
):
    random, joints = np.random.default_rng(seed), len(slides)
    build = random_planar_robot if planar else random_robot
    held = random_wheels(seed, ("held", "held")) if wheels else ()
    parents = random_parents(random, joints)
    robot = build(seed, parents, np.flatnonzero(slides).tolist(), held)
    which = np.flatnonzero(random.uniform(size=joints) < 0.7)
    table = np.column_stack(
        [which, random.uniform(0.05, 0.2, (which.size, 12))]
    ).reshape(-1, 13)
    stds = Noise(
        gyro=0.1,
        velocity=0.2,
        gyro_bias=0.3,
        gyro_walk=0.1,
        attitude=0.1,
        velocity_walk=0.2,
        accelerometer_bias=0.3,
        accelerometer_walk=0.1,
        joint_rates=0.1,
        momentum_walk=0.2,
        accelerometer=accelerometer,
        driven=DrivenJoints(table, 0.3),
    )
    kalman, sets = Extended.of(robot, stds), minimal_sets(robot)
    every = driven_samples(robot, len(sets.pi_of_beta) + 4, which.size, random)
    beta = sets.beta(robot.theta)
    prior = GaussianPrior(beta, np.diag(1.0 / (0.3 * np.abs(beta) + 0.1)))
    state = kalman.start(prior, every[0])
    t, rows = np.array([s.t for s in every]), np.array([packed(s) for s in every])
    state, _, _ = kalman.gathered(state, t[:-1], rows[:-1])
    before, sample = every[-2:]
    after, info = kalman.step(state, sample)

    axes, top, n = axes_of(sets), state.top, len(state.top)
    change, lost = gained(robot, stds, state, before, sample, axes)
    for place in lost:
        top = forgotten(top, int(place))
    back, kick = transition(stds, state, sample, axes)
    kick_of_all = top[:, :n] @ kick
    # The last column, the right-hand side, is that of `-1`.
    turned = np.eye(len(change))
    turned[:n, :n] = back
    top = top @ turned @ change
    own = laws(robot, stds, state, sample, axes)
    stacked = np.vstack(
        [
            white_equations(top, kick_of_all, own, axes.h.size),
            momentum_rows(robot, stds, state, sample, axes),
            np.hstack([np.zeros((len(state.R_z), n)), state.R_z]),
        ]
    )
    both = np.vstack([after.top, np.hstack([np.zeros((len(after.R_z), n)), after.R_z])])
    found, expected = both.T @ both, information(stacked, 0)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    # The last row is the residual, which the innovation has the new part of.
    assert np.abs((found - expected) / scale)[:-1].max() < 1e-8
    # Changes of the robot are seen by the innovation, which has no rows of torques.
    assert info.dof == len(own.rows) == len(info.white)


def test_a_gap_between_torques_is_not_bridged():
    """No impulse is known inside it, nor until a step from before it would be long."""
    robot = load_robot("paper-spatial")
    shown = robot.sensors.model_copy(update={"torques": TorqueSpec(std=1e-6)})
    robot = replace(robot, sensors=shown)
    motion = random_motion(robot, duration=20.0)
    flown = simulate(robot, motion, rate=20.0, noise="sensors")
    name = f"joint.{robot.joint_names[0]}.torque"
    torque, gap = flown.columns[name].copy(), slice(100, 161)
    torque[gap] = np.nan
    recording = flown.with_columns({name: torque})
    found = torques_of(robot, recording, samples_of(robot, recording), {})
    assert found.driven.table[:, 0].tolist() == [0.0, 1.0, 2.0]
    unknown = np.isnan(found.impulses[:, 0])
    # Steps of up to two and a half rows are followed.
    assert np.flatnonzero(unknown).tolist() == [*range(100, 164)]
    assert np.isfinite(found.impulses[:, 1:]).all()
    steps = np.diff(flown.t) * (torque[1:] + torque[:-1]) / 2
    known = ~unknown[1:] & ~unknown[:-1]
    gained, scale = np.diff(found.impulses[:, 0])[known], np.abs(steps[known]).max()
    np.testing.assert_allclose(gained, steps[known], atol=0.02 * scale)
