"""The six problems that are simulated: what flies, how it moves, what acts on it.

The robot file of a problem is what CAD says. What flies is another robot: each body's
mass, CM and inertia are off by up to a fifth, with a fixed seed. Its parameters are the
truth.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from problem_folder import DESCRIPTION, TRUTH, digest, mean_square, parameters_of

from orbident.choices import InitialMomentum
from orbident.excitation.bound import bound_of
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia_at
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.paper_tables import planar_trajectory, spatial_trajectory
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import InitialState, Trajectory

SEEDS = 3
"""Recordings of a problem: one motion, other noise."""
WRONG = 0.2
"""The largest relative error of CAD."""
DECIMALS = 9
"""Numbers are recorded so: far below any sensor's noise, in files half as large."""
WHEEL_SPEED = 200.0
"""rad/s."""
REACH = 0.9
"""How far a joint swings, at most, as a part of the way to its nearer stop."""
TARGET = from_mass_com_inertia(
    50.0, np.array([0.4, 0.1, -0.2]), np.diag([6.0, 5.0, 4.0])
)
"""What was captured, in the frame of the paper's last link."""


def exciting(robot: Robot, seed: int, duration: float, harmonics: int) -> Trajectory:
    """All joints at once on random Fourier series, with all wheels spinning."""
    random = np.random.default_rng(seed)
    a, b = random.normal(0.0, 0.1, (2, len(robot.joints), harmonics))
    at_rest = np.zeros((len(robot.joints), 3))
    speeds = dict.fromkeys(robot.wheel_names, WHEEL_SPEED)
    initial = InitialState(np.array([0.01, 0.03, 0.025]), wheel_speed=speeds)
    free = Trajectory(duration, robot.joint_names, a, b, at_rest, at_rest, initial)
    q, _, _ = free.at(np.linspace(0.0, duration, 1000))
    stops = [min(map(abs, j.position)) if j.position else np.inf for j in robot.joints]
    less = np.minimum(1.0, REACH * np.array(stops) / np.abs(q).max(axis=0))[:, None]
    return replace(free, a=less * a, b=less * b)


def spun_up(robot: Robot, trajectory: Trajectory) -> Trajectory:
    """From rest the wheels were spun up, so the base turns and the momentum is zero."""
    initial = trajectory.initial
    D = inertia_at(robot, trajectory.start[:, 0]).D
    h_rw = wheels_of(robot).A_rw @ initial.wheel_speeds(robot.wheel_names)
    w = np.array([0.0, 0.0, -h_rw[2] / D[2, 2]])
    return replace(trajectory, initial=replace(initial, angular_velocity=w))


@dataclass(frozen=True)
class MadeProblem:
    """A problem, but for its robot file."""

    about: str
    flown: Callable[[Robot], Trajectory]
    """The motion to identify from; of the robot that flies."""
    unused: Callable[[Robot], Trajectory]
    """The motion to predict."""
    initial_momentum: InitialMomentum = "unknown"
    captured: bool = False


PROBLEMS = {
    "paper-spatial": MadeProblem(
        "The paper's Section 4: encoders and an IMU, Table 2's motion, 80 s.",
        spatial_trajectory,
        lambda robot: exciting(robot, 1, 40.0, 3),
    ),
    "paper-planar": MadeProblem(
        "The paper's Section 5: encoders and motion capture, Table 5's motion, 20 s.",
        lambda robot: spun_up(robot, planar_trajectory(robot)),
        lambda robot: spun_up(robot, exciting(robot, 1, 20.0, 2)),
        "at-rest",
    ),
    "servicer": MadeProblem(
        "A chaser of the size of ETS-VII with a six-joint arm: encoders, gyro, star "
        "tracker, relative navigation of 1 mm, 120 s.",
        lambda robot: exciting(robot, 0, 120.0, 5),
        lambda robot: exciting(robot, 1, 60.0, 3),
    ),
    "dual-arm": MadeProblem(
        "Two arms of seven joints: encoders, IMU, star tracker, 60 s.",
        lambda robot: exciting(robot, 0, 60.0, 5),
        lambda robot: exciting(robot, 1, 40.0, 3),
    ),
    "real-table": MadeProblem(
        "A table that is tilted by 20 and 35 urad, with drag of the air film: encoders "
        "and motion capture, 20 s.",
        lambda robot: replace(
            spun_up(robot, planar_trajectory(robot)),
            environment=Environment.model_validate(
                {
                    "tilt": ("20 urad", "-35 urad"),
                    "film_drag": {robot.bodies[0]: {"c": 8e-3, "c_r": 1e-4}},
                }
            ),
        ),
        lambda robot: spun_up(robot, exciting(robot, 1, 20.0, 2)),
        "at-rest",
    ),
    "capture": MadeProblem(
        "The spatial servicer after a capture: 50 kg on the last link, of which CAD "
        "knows nothing; encoders and an IMU, 80 s.",
        spatial_trajectory,
        lambda robot: exciting(robot, 1, 40.0, 3),
        captured=True,
    ),
}


def flying(robot: Robot, captured: bool) -> Robot:
    """The robot that flies; its structure is as declared."""
    random = np.random.default_rng(7)
    theta = robot.theta.copy()
    for body in theta:
        mass, com, inertia = 1 + random.uniform(-WRONG, WRONG, 3)
        c, I = body[FIRST_MOMENT] / body[MASS], inertia_about_com(body)
        body[:] = from_mass_com_inertia(mass * body[MASS], com * c, inertia * I)
    if captured:
        theta[-1] += TARGET
    return replace(robot, theta=theta)


def rounded(recording: Recording) -> Recording:
    """Without digits that mean nothing."""
    columns = {k: np.round(x, DECIMALS) for k, x in recording.columns.items()}
    return Recording(np.round(recording.t, DECIMALS), columns, recording.source)


def make(name: str, folder: Path) -> None:
    """Write recordings, their checksums and the truth into a problem's folder."""
    problem, declared = PROBLEMS[name], load_robot(folder / "robot.yaml")
    robot = flying(declared, problem.captured)
    flown, unused = problem.flown(robot), problem.unused(robot)
    made = {
        f"identify-{seed}.parquet": simulate(robot, flown, noise="sensors", seed=seed)
        for seed in range(SEEDS)
    }
    made["unused.parquet"] = simulate(robot, unused)
    for file, recording in made.items():
        write_recording(rounded(recording), folder / file)
    *identify, last = made
    description = {
        "about": problem.about,
        "initial_momentum": problem.initial_momentum,
        "identify": identify,
        "unused": last,
        "sha256": {file: digest(folder / file) for file in made},
        "mean_square": {file: mean_square(folder / file) for file in made},
    }
    bound = bound_of(robot, flown, problem.initial_momentum).parameters
    values = parameters_of(robot)
    least = [*_std(bound.pi), *_std(bound.phi), _std(bound.base)[0]]
    truth = {
        key: {"value": value, "bound": std if np.isfinite(std) else None}
        for (key, value), std in zip(values.items(), least, strict=True)
    }
    for file, document in ((DESCRIPTION, description), (TRUTH, truth)):
        (folder / file).write_text(json.dumps(document, indent=1) + "\n")


def _std(known) -> list[float]:
    std = np.sqrt(np.diag(known.covariance))
    return np.where(known.determined, std, np.nan).tolist()
