"""Robots that do not float free, or change on the way: simulated."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from captured_bodies import truth_through_change
from disturbed import NOTHING, Now, Push, Wrench, pushed
from recordings import Clean, motion_of
from spoiled import Spoil, Spoiled, spoiled

from orbident.model.kinematics import JointState
from orbident.robot.description import Joint, Robot
from orbident.robot.parameters import PER_BODY, from_mass_com_inertia, transformed
from orbident.simulation.free_floating import JointMotion
from orbident.trajectories.trajectory import Trajectory

EDGE = {"spatial": (2.1, 0.5, -0.7), "planar": (0.19, 0.0, 0.0)}
"""Where a thruster is: a corner of the base, from S, base axes, m."""


def moved(push: Push) -> Spoil:
    """The robot is pushed while it moves."""
    return lambda clean: spoiled(clean, recording=clean.recorded(pushed(clean, push)))


def burst(force: float, begin: float, duration: float) -> Spoil:
    """A thruster fires; edges are on rows. N and s."""

    def spoil(clean: Clean) -> Spoiled:
        edge = np.array(EDGE[clean.robot.motion])

        def push(now: Now) -> Wrench:
            on = begin <= now.inside < begin + duration
            f = np.array([0.0, force if on else 0.0, 0.0])
            return Wrench(f, np.cross(edge - now.to_cm, f))

        return moved(push)(clean)

    return spoil


def torque(size: float, period: float = np.inf) -> Spoil:
    """About an axis of the base, steady or as a cosine, N m."""
    about = np.array([0.0, 0.6, 0.8])

    def push(now: Now) -> Wrench:
        return Wrench(NOTHING, about * size * np.cos(2 * np.pi * now.t / period))

    return moved(push)


def acceleration(size: float) -> Spoil:
    """All is pulled along an inertial axis, as by a table that is not level, m/s^2."""

    def push(now: Now) -> Wrench:
        along = np.array([size * now.mass, 0.0, 0.0])
        return Wrench(now.R_WB.T @ along, NOTHING)

    return moved(push)


def drag(time: float) -> Spoil:
    """Slows S down, and the base's turning about it: in so many seconds, M apart."""

    def push(now: Now) -> Wrench:
        f = -now.mass / time * now.R_WB.T @ now.v_S
        # A base whose radius of gyration is that of its CM's distance, or 0.1 m.
        arm = max(float(np.linalg.norm(now.to_cm)), 0.1)
        turning = -now.mass * arm**2 / time * now.w
        return Wrench(f, turning - np.cross(now.to_cm, f))

    return moved(push)


def spun_down(part: float) -> Spoil:
    """Friction takes this part of the wheels' speed; the recording says constant."""

    def spoil(clean: Clean) -> Spoiled:
        end = float(clean.t[-1])

        def spin(t: np.ndarray) -> np.ndarray:
            return 1 - part * t / end

        true = pushed(clean, lambda _: Wrench(NOTHING, NOTHING), spin)
        steady = np.outer(clean.t, clean.start.wheel_speed)
        return spoiled(clean, recording=clean.recorded(true._replace(q_rw=steady)))

    return spoil


def turning_already(rate: float) -> Spoil:
    """The base turned before its wheels spun up, rad/s; the user says at rest."""

    def spoil(clean: Clean) -> Spoiled:
        w = clean.start.angular_velocity + np.array([0.0, 0.0, rate])
        start = clean.start._replace(angular_velocity=w)
        true = motion_of(clean.robot, clean.joints, start, clean.t)
        wrong = spoiled(clean, recording=clean.recorded(true))
        return replace(wrong, initial_momentum="at-rest")

    return spoil


def changing(body: int, part: float) -> Spoil:
    """A body is so much heavier from the middle on; lighter where it is negative."""

    def spoil(clean: Clean) -> Spoiled:
        theta = clean.robot.theta.copy()
        theta[body] *= 1 + part
        after = replace(clean.robot, theta=theta)
        assert isinstance(clean.joints, Trajectory)
        middle = float(clean.t[clean.t.size // 2])
        true = truth_through_change(clean.robot, after, clean.joints, middle, clean.t)
        wrong = spoiled(clean, recording=clean.recorded(true))
        return replace(wrong, true=(clean.robot, after))

    return spoil


class WithLoose(NamedTuple):
    """The joints of a trajectory, and a last one that slides to and fro."""

    joints: JointMotion
    size: float
    """m."""
    rate: float
    """rad/s."""

    def at(self, t: np.ndarray) -> JointState:
        """The joints' state; the last starts from rest: `size sin^2(rate t / 2)`."""
        A, w = self.size / 2, self.rate
        loose = (
            A * (1 - np.cos(w * t)),
            A * w * np.sin(w * t),
            A * w**2 * np.cos(w * t),
        )
        q, qd, qdd = (
            np.column_stack([own, extra])
            for own, extra in zip(self.joints.at(t), loose, strict=True)
        )
        return q, qd, qdd


def loose(part: float, size: float, period: float) -> Spoil:
    """So much of the base's mass slides to and fro in it, m and s."""

    def spoil(clean: Clean) -> Spoiled:
        actual = _with_slider(clean.robot, part * clean.robot.theta[0, 0])
        joints = WithLoose(clean.joints, size, 2 * np.pi / period)
        true = motion_of(actual, joints, clean.start, clean.t)
        own = len(clean.robot.joints)
        seen = true._replace(q=true.q[:, :own], qd=true.qd[:, :own], tau=None)
        return spoiled(clean, recording=clean.recorded(seen))

    return spoil


def _with_slider(robot: Robot, mass: float) -> Robot:
    """The same robot, as long as the slider is at zero."""
    place = np.array(EDGE[robot.motion])
    own = from_mass_com_inertia(mass, np.zeros(3), 1e-3 * mass * np.eye(3))
    theta = np.vstack([robot.theta, own.reshape(1, PER_BODY)])
    theta[0] -= transformed(own, np.eye(3), place)
    axis = np.array([0.6, 0.8, 0.0])
    slider = Joint("slider", "prismatic", 0, axis, np.eye(3), place)
    return replace(
        robot,
        theta=theta,
        bodies=(*robot.bodies, "slider"),
        joints=(*robot.joints, slider),
    )
