"""One segment of a simulated motion, as output error sees it."""

from typing import NamedTuple

import jax
import numpy as np
from random_robots import random_start, random_swing

from orbident.dynamics.free_floating import FreeFloating, free_floating
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.dynamics.wheels import wheels_of
from orbident.estimation.output_error.course import _hermite
from orbident.estimation.output_error.segment import Course, Point, Shown
from orbident.estimation.output_error.terms import Body, JointState
from orbident.estimation.output_error.unknowns import Own
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.sensing.accelerations import accelerations
from orbident.spatial.rotations import quaternion_matrix

GYRO, ACCELEROMETER = np.array([1.0, -2.0, 3.0]), np.array([0.3, 0.1, -0.2])
"""Biases, rad/s and m/s^2."""

Z = np.array([0.0, 0.0, 1.0])


class Segment(NamedTuple):
    """What `linearised` is given; the sensors show the truth, with biases."""

    body: Body
    planar: bool
    substeps: int
    beta: np.ndarray
    point: Point
    course: Course
    shown: Shown
    motion: FreeFloating
    """At the nodes."""


def segment_of(
    robot: Robot, seed: int, rows: int = 8, dt: float = 0.02, substeps: int = 1
) -> Segment:
    """From the simulator, at every node; nothing is interpolated."""
    t = np.arange(2 * rows + 1) * dt / 2
    swing = random_swing(seed, len(robot.joints))
    motion = free_floating(robot, swing, t, random_start(seed, robot), 1e-12)
    felt = accelerations(robot, motion, swing.at(t)[2])
    A_rw = wheels_of(robot).A_rw
    planar = robot.motion == "planar"
    course = Course(
        joints=JointState(*swing.at(t)),
        h_rw=motion.qd_rw @ A_rw.T,
        h_rw_rate=felt.qdd_rw @ A_rw.T,
        basis=_hermite(t[None], t[[0, -1]])[0],
        t=t,
        dt=np.full(rows, dt),
    )
    sets = minimal_sets(robot)
    at = jax.jit(inertia)(tree_of(robot), robot.theta, motion.q[0])
    r_cm = np.asarray(quaternion_matrix(motion.attitude[0])) @ np.asarray(at.r_cm)
    own = Own(*np.zeros((len(Own._fields), 3)))
    own = own._replace(gyro=GYRO, accelerometer=ACCELEROMETER)
    own = own._replace(h_cm=motion.h_cm, v_cm=motion.v_cm, r_cm=r_cm)
    row = slice(0, -1, 2)
    values = {
        "accelerometer": felt.f_S[row] + ACCELEROMETER,
        "attitude": motion.attitude[row],
        "gyro": motion.w[row] + GYRO,
        "joints": motion.q[row],
        "position": motion.r_S[row],
        "velocity": motion.v_S[row],
    }
    every = np.ones(3)
    turning, moving = (Z, every - Z) if planar else (every, every)
    axes = {
        "accelerometer": moving,
        "attitude": turning,
        "gyro": turning,
        "joints": np.ones(len(robot.joints)),
        "position": moving,
        "velocity": moving,
    }
    return Segment(
        body=Body(tree_of(robot), sets.base.theta_of),
        planar=planar,
        substeps=substeps,
        beta=sets.beta(robot.theta),
        point=Point(motion.attitude[0], own, np.zeros((4, len(robot.joints)))),
        course=course,
        shown=Shown(values, {key: np.tile(k, (rows, 1)) for key, k in axes.items()}),
        motion=motion,
    )
