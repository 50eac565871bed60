"""What identification is for: tracking with the CAD model and with the identified one.

A controller that computes its torques from a model tracks as well as the model is. The
paper's servicer moves its arm and slews its base, free-flying on its wheels, twice: by
a CAD model whose masses, first moments and inertias are off by 20 %, and by the model
that was identified from one recording of Table 2's trajectory.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.seeds import ONE_RUN, SeedRuns, Series, StudyRuns
from orbident.choices import StudyNoise
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.files.json_parts import nulled
from orbident.gaussian import rms_of
from orbident.model.rotations import rotation_angle
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.simulation.flight import AttitudeState, ComputedTorque, standing
from orbident.simulation.free_floating import BaseState, FreeFloating
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import Truth, measure_truth, truth_of
from orbident.simulation.simulate import float_along, motion_recording, sample_times
from orbident.studies import paper_tables
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory import Trajectory


class Slew(NamedTuple):
    """The base turns by an angle about an axis, from rest to rest, by a quintic."""

    start: Float[np.ndarray, "4"]
    """Attitude at the start, unit quaternion, scalar last."""
    axis: Float[np.ndarray, "3"]
    """Unit vector, base axes."""
    angle: float
    """rad."""
    duration: float
    """s."""

    def at(self, t: Float[np.ndarray, " n"]) -> AttitudeState:
        """Attitude `x_WD`, rate and acceleration in D's axes, rad and s."""
        s = np.clip(t / self.duration, 0.0, 1.0)[:, None]
        turned = self.angle * s**3 * (10 - 15 * s + 6 * s**2)
        rate = self.angle * 30 * s**2 * (1 - s) ** 2 / self.duration
        faster = self.angle * 60 * s * (1 - s) * (1 - 2 * s) / self.duration**2
        v, w = self.start[:3], self.start[3]
        e, c = np.sin(turned / 2) * self.axis, np.cos(turned / 2)
        x_WD = np.hstack([w * e + c * v + np.cross(v, e), w * c - (e @ v)[:, None]])
        return x_WD, rate * self.axis, faster * self.axis


CAD_ERROR = 0.2
FACTOR = 5.0
"""Tracking is to be so many times better with the identified model."""
DURATION = 20.0
"""s."""
RATE = 10.0
"""Samples of the tracking error, Hz."""
REACH = (1.0, -0.8, 1.2)
"""Where the joints go, rad."""
SLEW = 0.3
"""Angle by which the base turns about the diagonal of its axes, rad."""
KP, KD = 1.0, 2.0
"""A closed loop of 1 rad/s, critically damped."""

MODELS = ("CAD", "identified")


class Tracked(NamedTuple):
    """RMS errors of one flight, rad."""

    joints: float
    base: float


@dataclass(frozen=True)
class ControlStudy(StudyRuns):
    """How well the same task was tracked with either model."""

    errors: Mapping[str, Tracked]
    """RMS errors over the seeds, by model."""
    factor: float
    """How many times better the identified model is, where this is least: of joints and
    base, of all seeds."""
    trajectory: Trajectory
    """The trajectory of the identification."""
    recording: Recording
    result: Result

    @property
    def trusted(self) -> bool:
        """Whether tracking is as much better as was asked for."""
        return not self.rejected and self.factor >= FACTOR

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "rms_error": {
                name: {part: nulled(value) for part, value in tracked._asdict().items()}
                for name, tracked in self.errors.items()
            },
            "factor": nulled(self.factor),
            "cad_error": CAD_ERROR,
            **self.counts,
        }


def run_control(noise: StudyNoise = "none", runs: SeedRuns = ONE_RUN) -> ControlStudy:
    """Identify, then track with the CAD model and with the identified one.

    The noise is that of the recording. Each seed has a CAD model and sensors of its
    own.

    Raises:
        InputError: there are no seeds.
    """
    started = time.perf_counter()
    robot = spatial_robot()
    trajectory = spatial_trajectory(robot)
    motion = float_along(robot, trajectory, paper_tables.SPATIAL_RATE)
    task = _Task(robot, motion, truth_of(robot, motion, trajectory), noise)
    first = task.identified(runs.first)
    (found,) = runs.over(Series(task.identified, runs.numbers, task.errors, (first,)))
    by_seed = found.runs.reshape(runs.seeds, 2, 2)
    return ControlStudy(
        errors={
            name: Tracked(*map(float, row))
            for name, row in zip(MODELS, found.rms.reshape(2, 2), strict=True)
        },
        factor=float((by_seed[:, 0] / by_seed[:, 1]).min()),
        trajectory=trajectory,
        recording=first[0],
        result=first[1],
        seeds=runs.seeds,
        rejected=int(np.isnan(by_seed).any(axis=(1, 2)).sum()),
        elapsed_s=time.perf_counter() - started,
    )


class _Task(NamedTuple):
    """The same motion, identified with a CAD model and sensors of each seed's own."""

    robot: Robot
    motion: FreeFloating
    true: Truth
    noise: StudyNoise

    def identified(self, seed: int) -> tuple[Recording, Result]:
        recording = (
            motion_recording(self.robot, self.motion)
            if self.noise == "none"
            else measure_truth(self.robot, self.motion.t, self.true, seed)
        )
        cad = off_by(self.robot, CAD_ERROR, seed)
        return recording, identify(cad, recording, "least-squares")

    def errors(self, made: tuple[Recording, Result]) -> Float[np.ndarray, "4"]:
        _, result = made
        if result.status == "rejected":
            return np.full(4, np.nan)
        models = result.robot, result.dynamics().robot
        return np.concatenate([tracked(self.robot, model) for model in models])


def off_by(robot: Robot, error: float, seed: int) -> Robot:
    """The robot with each mass, first moment and central inertia too large or small.

    About their CMs, so that bodies stay what can exist, as those of a CAD model are.
    The error is relative, of each; the seed is that of the signs.
    """
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (len(robot.bodies), 3))
    bodies = []
    for theta_i, (m, s, I) in zip(robot.theta, 1 + error * signs, strict=True):
        mass = m * theta_i[MASS]
        com = s * theta_i[FIRST_MOMENT] / mass
        bodies.append(from_mass_com_inertia(mass, com, I * inertia_about_com(theta_i)))
    return replace(robot, theta=np.array(bodies))


def tracked(robot: Robot, model: Robot) -> Tracked:
    """The errors with which the robot tracks the task, by torques from a model."""
    initial = spatial_trajectory(robot).initial
    joints = len(robot.joints)
    none, there = np.zeros((joints, 0)), np.zeros((joints, 3))
    there[:, 0] = REACH
    task = Trajectory(DURATION, robot.joint_names, none, none, end=there)
    slew = Slew(initial.attitude, np.ones(3) / np.sqrt(3), SLEW, DURATION)
    law = ComputedTorque(model, slew, KP, KD)
    still = {"angular_velocity": np.zeros(3), "velocity": np.zeros(3)}
    start = BaseState.of(initial, robot)._replace(**still)
    flight = free_flying(
        robot,
        sample_times(DURATION, RATE),
        standing(start, np.zeros(joints)),
        task,
        law,
        law,
    )
    wanted, _, _ = task.at(flight.t)
    turned = rotation_angle(slew.at(flight.t)[0], flight.attitude)
    return Tracked(rms_of(flight.q - wanted), rms_of(turned[:, None]))
