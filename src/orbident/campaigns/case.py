"""Run `k` of a campaign: what is drawn, what flies, and what it records.

Every quantity draws from a stream of its own, so that one which is added, removed or
changed leaves the numbers of all others as they were; so do the sensors' noises.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from orbident.campaigns.distributions import Distribution
from orbident.campaigns.instrument_errors import moved_joints, with_instrument_errors
from orbident.campaigns.spec import Disperse, Spec
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.model.minimal_sets import conserved_axes
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.robot.sensor_schema import SensorsSpec
from orbident.simulation.measure import measure_truth
from orbident.simulation.noise_processes import stream
from orbident.simulation.simulate import made_along
from orbident.trajectories.trajectory import InitialState, Trajectory

Draws = dict[str, float]


@dataclass(frozen=True, eq=False)
class Subject:
    """A robot as its file describes it, and the motion that it is asked for."""

    robot: Robot
    trajectory: Trajectory


@dataclass(frozen=True, eq=False)
class Case:
    """One run: all that its number decides."""

    k: int
    subject: Subject
    """As declared: what an estimator is given."""
    disperse: Disperse
    seed: int
    """The seed of all random numbers that this run draws."""

    @classmethod
    def of(cls, spec: Spec, subjects: tuple[Subject, ...], k: int) -> "Case":
        """Run `k` of a campaign."""
        words = np.random.SeedSequence(spec.entropy, spawn_key=(k,)).generate_state(4)
        # All 128 bits, as one whole number.
        seed = sum(int(word) << (32 * i) for i, word in enumerate(words))
        return cls(k, subjects[k % len(subjects)], spec.disperse, seed)

    @cached_property
    def draws(self) -> Draws:
        """What was drawn, by name: shares of CAD and of noise, the rest in SI."""
        robot, what = self.subject.robot, self.disperse
        draws = self._draw("inertia", what.inertia, _names_of_inertia(robot))
        errors = {
            each.name: each.std
            for each in calibrations_of(robot, set(robot.sensors.declared))
            if each.std > 0
        }
        drawn = self._draw("instruments", what.instruments, tuple(errors))
        draws |= {name: x * errors[name.partition(".")[2]] for name, x in drawn.items()}
        draws |= self._draw("noise", what.noise, tuple(robot.sensors.declared))
        turning, moving = (
            tuple("xyz"[axis] for axis in axes) for axes in conserved_axes(robot)
        )
        for key, names in (
            ("angular_velocity", turning),
            ("velocity", moving),
            ("attitude", turning),
            ("wheel_speed", robot.wheel_names),
        ):
            draws |= self._draw(f"initial.{key}", getattr(what.initial, key), names)
        return draws

    def _draw(
        self, group: str, given: Distribution | None, names: tuple[str, ...]
    ) -> Draws:
        if given is None:
            return {}
        keys = [f"{group}.{name}" for name in names]
        # Sensors' noises have the streams without this beginning.
        random = (stream(self.seed, f"disperse.{key}") for key in keys)
        return {
            key: float(given.draw(each, 1)[0])
            for key, each in zip(keys, random, strict=True)
        }

    def _of(self, group: str) -> Draws:
        start = f"{group}."
        return {
            name.removeprefix(start): x
            for name, x in self.draws.items()
            if name.startswith(start)
        }

    @cached_property
    def robot(self) -> Robot:
        """The one that flies, with the sensors that it has."""
        declared = self.subject.robot
        moved = moved_joints(declared, self._of("instruments"))
        return replace(
            moved,
            theta=_theta(declared, self._of("inertia")),
            sensors=_louder(declared.sensors, self._of("noise")),
        )

    @cached_property
    def trajectory(self) -> Trajectory:
        """The motion from the state in which this run begins."""
        trajectory = self.subject.trajectory
        wheels = self.subject.robot.wheel_names
        state = _state(trajectory.initial, self._of("initial"), wheels)
        return replace(trajectory, initial=state)

    def recording(self) -> Recording:
        """What the sensors record of it.

        Raises:
            InputError: this robot cannot fly that, or its sensors cannot record it.
        """
        robot, rate = self.robot, self.robot.sensors.rows_per_second
        t, true, known = made_along(robot, self.trajectory, rate, seed=self.seed)
        seen = with_instrument_errors(robot, t, true, self._of("instruments"))
        return measure_truth(robot, t, seen, self.seed).with_columns(known)


def _names_of_inertia(robot: Robot) -> tuple[str, ...]:
    kinds = ("mass", "com", "inertia")
    return tuple(f"{body}.{kind}" for body in robot.bodies for kind in kinds)


def _theta(robot: Robot, drawn: Draws) -> np.ndarray:
    """Factors `e^x`: `1 + x` where x is small, and never a body that cannot exist."""
    if not drawn:
        return robot.theta
    bodies = []
    for body, theta_i in zip(robot.bodies, robot.theta, strict=True):
        m, c, I = (math.exp(drawn[f"{body}.{k}"]) for k in ("mass", "com", "inertia"))
        if theta_i[MASS] == 0.0:
            # Such a body has no CM; its inertia, if any, is about its origin.
            bodies.append(I * theta_i)
            continue
        com = c * theta_i[FIRST_MOMENT] / theta_i[MASS]
        I_com = I * inertia_about_com(theta_i)
        bodies.append(from_mass_com_inertia(m * theta_i[MASS], com, I_com))
    return np.array(bodies)


def _louder(sensors: SensorsSpec, drawn: Draws) -> SensorsSpec:
    every = sensors.declared
    louder = {name: every[name].louder(math.exp(x)) for name, x in drawn.items()}
    return sensors.model_copy(update=louder)


def _state(
    initial: InitialState, drawn: Draws, wheels: tuple[str, ...]
) -> InitialState:
    def vector(key: str) -> np.ndarray:
        return np.array([drawn.get(f"{key}.{axis}", 0.0) for axis in "xyz"])

    turn = Rotation.from_rotvec(vector("attitude"))
    turned = (Rotation.from_quat(initial.attitude) * turn).as_quat()
    speeds = {
        name: initial.wheel_speed.get(name, 0.0) + drawn.get(f"wheel_speed.{name}", 0.0)
        for name in wheels
    }
    return InitialState(
        angular_velocity=initial.angular_velocity + vector("angular_velocity"),
        attitude=turned if vector("attitude").any() else initial.attitude,
        velocity=initial.velocity + vector("velocity"),
        wheel_speed=speeds,
    )
