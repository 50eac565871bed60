"""Run `k` of a campaign: what is drawn, what flies, and what it records.

Every quantity draws from a stream of its own, so that one which is added, removed or
changed leaves the numbers of all others as they were; so do the sensors' noises.

An error of an instrument or of a joint is named as the unknown that stands for it, and
has the same sign: the truth is what the unknown makes of the shown.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from orbident.campaigns.spec import Disperse, Distribution
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.robot.tolerances import CALIBRATION_KINDS
from orbident.simulation.measure import Truth, measure_truth
from orbident.simulation.sensor import stream
from orbident.simulation.simulate import made_along
from orbident.trajectories.trajectory import InitialState, Trajectory

Draws = dict[str, float]


@dataclass(frozen=True, eq=False)
class Subject:
    """A robot as its file describes it, and the motion that it is asked for."""

    robot: Robot
    trajectory: Trajectory
    name: str
    """What tables call it: the robot, with a number where several subjects have it."""


@dataclass(frozen=True, eq=False)
class Case:
    """One run: all that its number decides."""

    k: int
    subject: Subject
    """As declared: what an estimator is given."""
    disperse: Disperse
    seed: int
    """The seed of all random numbers that this run draws."""

    @cached_property
    def draws(self) -> Draws:
        """What was drawn, by name: shares of CAD and of noise, the rest in SI."""
        robot, what = self.subject.robot, self.disperse
        kinds = ("mass", "com", "inertia")
        names = tuple(f"{body}.{kind}" for body in robot.bodies for kind in kinds)
        draws = self._draw("inertia", what.inertia, names)
        errors = {
            each.name: each.std
            for each in calibrations_of(robot, set(robot.sensors.declared))
            if each.std > 0
        }
        drawn = self._draw("instruments", what.instruments, tuple(errors))
        draws |= {name: x * errors[name.partition(".")[2]] for name, x in drawn.items()}
        draws |= self._draw("noise", what.noise, tuple(robot.sensors.declared))
        axes_h, axes_v = (
            tuple("xyz"[axis] for axis in axes) for axes in robot.conserved_axes
        )
        for key, names in (
            ("angular_velocity", axes_h),
            ("velocity", axes_v),
            ("attitude", axes_h),
            ("wheel_speed", robot.wheel_names),
        ):
            draws |= self._draw(f"initial.{key}", getattr(what.initial, key), names)
        return draws

    def _draw(
        self, group: str, given: Distribution | None, names: tuple[str, ...]
    ) -> Draws:
        if given is None:
            return {}
        # Sensors' noises have the streams without "disperse.".
        return {
            key: float(given.draw(stream(self.seed, f"disperse.{key}"), 1)[0])
            for key in (f"{group}.{name}" for name in names)
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
        moved, every = moved_joints(declared, self.instrument_errors), declared.sensors
        noise = self._of("noise").items()
        louder = {name: every.declared[name].louder(math.exp(x)) for name, x in noise}
        return replace(
            moved,
            theta=_theta(declared, self._of("inertia")),
            sensors=every.model_copy(update=louder),
        )

    @cached_property
    def trajectory(self) -> Trajectory:
        """The motion from the state in which this run begins."""
        trajectory = self.subject.trajectory
        wheels = self.subject.robot.wheel_names
        state = _state(trajectory.initial, self._of("initial"), wheels)
        return replace(trajectory, initial=state)

    @property
    def instrument_errors(self) -> Draws:
        """The errors of instruments and of geometry by their names, SI."""
        return self._of("instruments")

    def recording(self) -> Recording:
        """What the sensors record of it.

        Raises:
            InputError: this robot cannot fly that, or its sensors cannot record it.
        """
        return recorded(self.robot, self.trajectory, self.instrument_errors, self.seed)


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


Errors = Mapping[str, float]
"""The errors of instruments by their names, SI; one that is absent is zero."""


def moved_joints(robot: Robot, errors: Errors) -> Robot:
    """The robot whose joints are elsewhere and whose wheels are heavier and tilted."""
    joints = tuple(
        replace(
            joint,
            p_PJ=joint.p_PJ + _drawn(errors, "joint_place", joint.name),
            R_PJ=_rotation(errors, "joint_direction", joint.name) @ joint.R_PJ,
        )
        for joint in robot.joints
    )
    wheels = tuple(
        replace(
            wheel,
            inertia=wheel.inertia * (1 + float(share)),
            axis=_rotation(errors, "wheel_axis", wheel.name) @ wheel.axis,
        )
        for wheel in robot.wheels
        for share in _drawn(errors, "wheel_inertia", wheel.name)
    )
    return replace(robot, joints=joints, wheels=wheels)


def recorded(
    robot: Robot, trajectory: Trajectory, errors: Errors, seed: int
) -> Recording:
    """What sensors record of a flight.

    The errors are those of instruments: the robot has its own of geometry. The seed is
    of the sensors' noise and of what is random of the environment.

    Raises:
        InputError: this robot cannot fly that, or its sensors cannot record it.
    """
    rate = robot.sensors.rows_per_second
    t, true, known = made_along(robot, trajectory, rate, seed=seed)
    seen = with_instrument_errors(robot, t, true, errors)
    return measure_truth(robot, t, seen, seed).with_columns(known)


def with_instrument_errors(
    robot: Robot, t: Float[np.ndarray, " rows"], true: Truth, errors: Errors
) -> Truth:
    """What instruments with these errors would show without noise.

    The rows are at `t`, s; errors of geometry are `moved_joints`.
    """
    zero, scale = (
        np.ravel([_drawn(errors, kind, name) for name in robot.joint_names])
        for kind in ("joint_zero", "joint_scale")
    )
    gain = 1 + scale
    point = _drawn(errors, "feature_point")
    R_BS = _rotation(errors, "gyro_misalignment")
    turn = Rotation.from_matrix(_rotation(errors, "attitude_misalignment"))
    R_WB = Rotation.from_quat(true.attitude)

    def late(clock: str, x: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "rows n"]:
        (by,) = _drawn(errors, f"{clock}_clock")
        # The motion is smooth, and so is the quintic through all its samples.
        return x if by == 0.0 or x.size == 0 else make_interp_spline(t, x, 5)(t - by)

    shown = late("attitude", (R_WB * turn).as_quat())
    lever = R_WB.apply(np.cross(true.gyro, point))
    size = 1 + _drawn(errors, "position_scale")
    return true._replace(
        q=(late("joint", true.q) - zero) / gain,
        qd=late("joint", true.qd) / gain,
        q_rw=late("joint", true.q_rw),
        qd_rw=late("joint", true.qd_rw),
        gyro=(1 + _drawn(errors, "gyro_scale")) * (true.gyro @ R_BS),
        attitude=shown / np.linalg.norm(shown, axis=1, keepdims=True),
        position=size * late("position", true.position + R_WB.apply(point)),
        velocity=late("position", true.velocity + lever),
    )


def _drawn(errors: Errors, kind: str, of: str = "") -> Float[np.ndarray, " axes"]:
    """The errors of one kind, of one joint or wheel where each has its own."""
    names = CALIBRATION_KINDS[kind].names(of)
    return np.array([errors.get(name, 0.0) for name in names])


def _rotation(errors: Errors, kind: str, of: str = "") -> Float[np.ndarray, "3 3"]:
    return Rotation.from_rotvec(_drawn(errors, kind, of)).as_matrix()
