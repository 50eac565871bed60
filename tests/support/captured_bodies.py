"""A robot whose inertia changes on the way: a capture, a release, a loss.

What is captured moves with the body that it is attached to already, so nothing jumps:
base rate, attitude and the velocity of S go on as they were. From then on the momentum
is that of both together.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.parameters import from_mass_com_inertia
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.simulation.measure import Truth, measure_truth, truth_of
from orbident.simulation.simulate import sample_times
from orbident.trajectories.trajectory import Trajectory


class CapturedBody(NamedTuple):
    """A rigid body, in the frame of the body it is attached to."""

    mass: float
    """kg; negative for what is let go."""
    com: Float[np.ndarray, "3"]
    """m."""
    I_com: Float[np.ndarray, "3 3"]
    """About its CM, kg m^2; negative for what is let go."""


def holding(robot: Robot, target: CapturedBody, body: str | None = None) -> Robot:
    """The robot with the target attached.

    Args:
        robot: before.
        target: what is attached.
        body: to which; the last link where it is None.

    Raises:
        InputError: the robot has no such body.
    """
    name = robot.bodies[-1] if body is None else body
    if name not in robot.bodies:
        raise InputError(
            f"{robot.name}: no body '{name}'; give one of {listed(robot.bodies)}"
        )
    theta = robot.theta.copy()
    theta[robot.bodies.index(name)] += from_mass_com_inertia(*target)
    return replace(robot, theta=theta)


def simulate_change(
    before: Robot,
    after: Robot,
    trajectory: Trajectory,
    at: float,
    seed: int = 0,
    rate: float | None = None,
) -> Recording:
    """Record a free-floating motion through a change, with the robot's sensors.

    Args:
        before: the robot until then.
        after: the robot from then on: the same but for its inertia.
        trajectory: of the joints, with the initial state of base and wheels.
        at: when, s.
        seed: of the sensors' noise.
        rate: samples per second; the robot file's by default, else 20 Hz.

    Raises:
        InputError: as `simulate`, or the change is not between two samples.
    """
    rate = before.sensors.rows_per_second if rate is None else float(rate)
    t = sample_times(trajectory.duration, rate)
    if not t[1] <= at <= t[-2]:
        raise InputError(f"change at {at:g} s: give a time from {t[1]:g} to {t[-2]:g}")
    true = truth_through_change(before, after, trajectory, at, t)
    return measure_truth(before, t, true, seed)


def truth_through_change(
    before: Robot,
    after: Robot,
    trajectory: Trajectory,
    at: float,
    t: Float[np.ndarray, " n"],
) -> Truth:
    """What ideal sensors would show at the times `t`, s."""
    return truth_through_changes([before, after], trajectory, [at], t)


def truth_through_changes(
    robots: Sequence[Robot],
    trajectory: Trajectory,
    times: Sequence[float],
    t: Float[np.ndarray, " n"],
) -> Truth:
    """What ideal sensors would show of a robot that changes several times.

    Args:
        robots: the robot before the first change, after it, and so on.
        trajectory: of the joints, with the initial state of base and wheels.
        times: of the changes, s; one fewer than robots.
        t: when the sensors are read, s.
    """
    trajectory = trajectory.for_robot(robots[0])
    initial = trajectory.initial
    state = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        initial.wheel_speeds(robots[0].wheel_names),
    )
    parts, q_rw, position = list[dict[str, np.ndarray]](), 0.0, 0.0
    for robot, begin, end in zip(
        robots, [-np.inf, *times], [*times, np.inf], strict=True
    ):
        # The sample at a change itself is the last one before it.
        counts = (begin < t) & (t <= end)
        ends = [x for x in (begin, end) if np.isfinite(x)]
        nodes = np.union1d(t[counts], ends)
        motion = free_floating(robot, trajectory, nodes, state)
        truth = truth_of(robot, motion, trajectory)
        truth = truth._replace(
            q_rw=truth.q_rw + q_rw, position=truth.position + position
        )
        q_rw, position = truth.q_rw[-1], truth.position[-1]
        state = BaseState(
            motion.w[-1], motion.attitude[-1], motion.v_S[-1], motion.qd_rw[-1]
        )
        kept = np.isin(nodes, t[counts])
        seen = truth._asdict().items()
        parts.append({name: x[kept] for name, x in seen if x is not None})
    return Truth(**{x: np.concatenate([each[x] for each in parts]) for x in parts[0]})
