"""What a trajectory is at even times: as it is recorded, and as it is to be flown."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.choices import SensorNoise
from orbident.environment.agent import World
from orbident.environment.orbital import seen_from_base
from orbident.errors import InputError
from orbident.files.replacing import write_text
from orbident.model.equations_of_motion import check_regular
from orbident.recordings.columns import vector_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.simulation.flight import Driven, FreeFlying, standing
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import (
    Columns,
    Truth,
    measure_truth,
    truth_of,
    truth_of_flight,
)
from orbident.simulation.outside import arc_of, part_on, thrust_columns
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory

MOST_SAMPLES = 2_000_000
"""A simulated sample of a small robot takes 0.8 kB: so many take 1.6 GB."""


def simulate(
    robot: Robot,
    trajectory: Trajectory,
    rate: float | None = None,
    tolerance: float = 1e-9,
    noise: SensorNoise = "none",
    seed: int = 0,
    truth: bool = False,
) -> Recording:
    """Let the robot float free along a trajectory, and record it.

    What acts from outside meanwhile is the trajectory's `environment`. Without one,
    nothing acts but the gravity gradient of the robot's orbit, if it has one.

    Args:
        robot: with its nominal inertia.
        trajectory: of the joints, with the initial state of base and wheels; passive
            joints begin at rest where their springs are.
        rate: samples per second; the robot file's by default, else 20 Hz.
        tolerance: of the attitude, rad.
        noise: `"none"` for ideal sensors of everything, `"sensors"` for those that the
            robot file declares, as `measure` has them.
        seed: of the sensors' noise, and of what is random from outside.
        truth: add noise-free columns `truth.*` beside what the sensors measured.

    Raises:
        InputError: the trajectory is not for this robot's joints and wheels, its mass
            matrix is singular, the rate is not positive, the base turns too fast for
            it, a sensor cannot sample at it, or the environment is not one of this
            robot.
    """
    if noise not in {"none", "sensors"}:
        raise InputError(f"noise {noise!r}: give 'none' or 'sensors'")
    if truth and noise == "none":
        raise InputError("truth: a recording without noise is the truth already")
    rate = robot.sensors.rows_per_second if rate is None else float(rate)
    if noise == "none":
        motion, known = _moved_along(robot, trajectory, rate, tolerance, seed)
        return motion_recording(robot, motion).with_columns(known)
    made = made_along(robot, trajectory, rate, tolerance, seed)
    return measure_truth(robot, made.t, made.true, seed, truth).with_columns(made.known)


class Made(NamedTuple):
    """A simulated motion at its rows."""

    t: Float[np.ndarray, " rows"]
    """s."""
    true: Truth
    known: Columns
    """What is recorded beside what sensors measure: the thrust that was commanded, and
    where Earth, air, sun and field are."""


def made_along(
    robot: Robot,
    trajectory: Trajectory,
    rate: float,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> Made:
    """The motion along a trajectory, in its environment if it has one.

    Arguments are those of `simulate`; the tolerance is of the motion, rad or m.

    Raises:
        InputError: as `float_along` and `fly_along`.
    """
    motion, known = _moved_along(robot, trajectory, rate, tolerance, seed)
    if isinstance(motion, FreeFlying):
        return Made(motion.t, truth_of_flight(motion), known)
    true = truth_of(robot, motion, trajectory.for_robot(robot))
    return Made(motion.t, true, known)


def _moved_along(
    robot: Robot, trajectory: Trajectory, rate: float, tolerance: float, seed: int
) -> tuple[FreeFloating | FreeFlying, Columns]:
    """The motion, and the columns of thrust and of directions."""
    environment = trajectory.environment
    if environment is None:
        # Momentum alone does not say how passive joints swing.
        if robot.orbit is None and not robot.passive:
            return float_along(robot, trajectory, rate, tolerance), {}
        environment = Environment(gravity_gradient=robot.orbit is not None)
    trajectory = replace(trajectory, environment=environment)
    flight = fly_along(robot, trajectory, rate, tolerance, seed)
    R_WB = Rotation.from_quat(flight.attitude).as_matrix()
    world = World(environment, arc_of(robot, environment, flight.t))
    return flight, {
        **thrust_columns(environment, flight.t),
        **seen_from_base(world, flight.t, R_WB),
    }


def float_along(
    robot: Robot, trajectory: Trajectory, rate: float, tolerance: float = 1e-9
) -> FreeFloating:
    """The free-floating motion along a trajectory, from its initial state.

    Arguments are those of `simulate`.

    Raises:
        InputError: the trajectory is not for this robot's joints and wheels, its mass
            matrix is singular, the rate is not positive, or the base turns too fast
            for it.
    """
    require_measured(robot, "momentum alone")
    trajectory, t, start = _task(robot, trajectory, rate)
    try:
        return free_floating(robot, trajectory, t, start, tolerance)
    except InputError as error:
        raise InputError(f"{trajectory.source}: {error}") from None


def fly_along(
    robot: Robot,
    trajectory: Trajectory,
    rate: float,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> FreeFlying:
    """The motion along a trajectory, from its initial state, as its environment acts.

    Arguments are those of `simulate`; the tolerance is of attitude, joints and
    position, rad or m.

    Raises:
        InputError: as `float_along`, or the environment is not one of this robot.
    """
    trajectory, t, base = _task(robot, trajectory, rate)
    q, qd, _ = trajectory.at(t[:1])
    start = standing(base, q[0])._replace(qd=qd[0])
    try:
        return free_flying(
            robot,
            t,
            start,
            trajectory,
            Driven(),
            tolerance=tolerance,
            environment=trajectory.environment,
            seed=seed,
        )
    except InputError as error:
        raise InputError(f"{trajectory.source}: {error}") from None


def _task(
    robot: Robot, trajectory: Trajectory, rate: float
) -> tuple[Trajectory, Float[np.ndarray, " n"], BaseState]:
    """The trajectory in the robot's order, sample times, and how the base starts."""
    check_regular(robot)
    if not 0.0 < rate < np.inf:
        raise InputError(f"rate {rate} Hz: give a positive number of samples a second")
    trajectory = trajectory.for_robot(robot)
    start = BaseState.of(trajectory.initial, robot)
    return trajectory, sample_times(trajectory.duration, rate), start


def sample_times(duration: float, rate: float) -> np.ndarray:
    """0, 1/rate, 2/rate ... up to and including the duration, s.

    Raises:
        InputError: that are fewer than two samples, or more than memory can hold.
    """
    # A duration that is a whole number of periods but for rounding has its last one.
    count = np.floor(duration * rate * (1 + 1e-12)) + 1
    if not 2 <= count <= MOST_SAMPLES:
        remedy = "sample faster" if count < 2 else "sample slower"
        raise InputError(
            f"rate {rate:g} Hz, duration {duration:g} s: samples: found {count:.6g}; "
            f"give 2 to {MOST_SAMPLES:g}: {remedy}"
        )
    return np.minimum(np.arange(int(count)) / rate, duration)


def motion_recording(robot: Robot, motion: FreeFloating | FreeFlying) -> Recording:
    """A motion as the columns of a recording."""
    columns = {}
    for k, name in enumerate(robot.joint_names):
        if name in robot.passive:
            continue
        columns[f"joint.{name}.position"] = motion.q[:, k]
        columns[f"joint.{name}.velocity"] = motion.qd[:, k]
    for k, name in enumerate(robot.wheel_names):
        columns[f"wheel.{name}.speed"] = motion.qd_rw[:, k]
    vectors = {
        "gyro": motion.w,
        "attitude": motion.attitude,
        "position": motion.r_S,
        "velocity": motion.v_S,
    }
    for sensor, values in vectors.items():
        columns |= zip(vector_columns(sensor), values.T, strict=True)
    return Recording(motion.t, columns, source=f"simulation of {robot.name}")


SECOND = 1_000_000_000
"""ns."""


def times_to_the_end(
    trajectory: Trajectory, rate: float
) -> Float[np.ndarray, " samples"]:
    """Times at an even rate (Hz), and that of the end, s.

    Raises:
        InputError: the rate is not positive, or gives too few or too many samples.
    """
    t = sample_times(trajectory.duration, rate)
    return t if t[-1] == trajectory.duration else np.append(t, trajectory.duration)


def motion_table(trajectory: Trajectory, t: Float[np.ndarray, " samples"]) -> Recording:
    """As a table: `t`, s, and `joint.<name>.position`, `.velocity`, `.acceleration`.

    And `thruster.<name>.duty`, from 0 to 1, of each thruster that fires, until the next
    sample.
    """
    fired = trajectory.environment.thrusters if trajectory.environment else {}
    columns = {
        f"thruster.{name}.duty": sum(
            (part_on(pulse, t) for pulse in each.pulses), np.zeros(t.size)
        )
        for name, each in fired.items()
    }
    for name, q, qd, qdd in zip(
        trajectory.joints, *(x.T for x in trajectory.at(t)), strict=True
    ):
        columns[f"joint.{name}.position"] = q
        columns[f"joint.{name}.velocity"] = qd
        columns[f"joint.{name}.acceleration"] = qdd
    return Recording(t, columns, source="samples")


def write_joint_trajectory(
    trajectory: Trajectory, t: Float[np.ndarray, " samples"], path: Path
) -> None:
    """Writes a ROS `trajectory_msgs/JointTrajectory` at these times (s) as YAML.

    Raises:
        InputError: there are no joints, or the folder does not exist or cannot be
            written to.
    """
    if not trajectory.joints:
        raise InputError(
            f"{path}: a joint trajectory has no pulses of thrusters, and here are no "
            "joints; write a table"
        )
    points = [
        {
            "positions": q.tolist(),
            "velocities": qd.tolist(),
            "accelerations": qdd.tolist(),
            "effort": [],
            "time_from_start": {"sec": ns // SECOND, "nanosec": ns % SECOND},
        }
        for ns, q, qd, qdd in zip(
            np.round(t * SECOND).astype(int).tolist(), *trajectory.at(t), strict=True
        )
    ]
    message: dict[str, Any] = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(trajectory.joints),
        "points": points,
    }
    write_text(path, yaml.safe_dump(message, sort_keys=False, default_flow_style=None))
