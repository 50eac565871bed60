"""A free-flying motion: what commands it, where it starts, its steps, what it was.

What a robot is commanded to do is data, which the core evaluates.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from orbident import _core
from orbident.model.core_robot import core_robot, wheels_of
from orbident.model.equations_of_motion import movable
from orbident.model.kinematics import JointState, springs_on
from orbident.model.rotations import UNTURNED
from orbident.robot.description import Robot
from orbident.simulation.free_floating import BaseState, JointMotion


class Hold(NamedTuple):
    """Joints that are commanded to stay."""

    q: Float[np.ndarray, " joints"]

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at the times `t`, s: all joints rest."""
        q = np.tile(self.q, (t.size, 1))
        return q, np.zeros_like(q), np.zeros_like(q)


class JointPD(NamedTuple):
    """`tau = Kp (q_d - q) + Kd (qd_d - qd)`, N m or N."""

    Kp: Float[np.ndarray, " joints"]
    Kd: Float[np.ndarray, " joints"]


class Driven(NamedTuple):
    """The joints do exactly as commanded, whatever torque that takes."""


class WheelSpeed(NamedTuple):
    """`tau_rw = k (qd_rw,d - qd_rw)`: brings each wheel to a speed."""

    k: Float[np.ndarray, " wheels"]
    """N m s/rad."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


class AttitudeHold(NamedTuple):
    """The wheels turn the base back to an attitude: `n = -kp e - kd w`.

    `e` is twice the vector part of the quaternion from the wanted attitude, base
    axes; a rotor that is driven by `tau_rw` turns the base by `-a tau_rw`. The wheels
    share the moment about the axes that they span, by the pseudo-inverse of their axes.
    """

    kp: float
    """N m/rad."""
    kd: float
    """N m s/rad."""
    x_WD: Float[np.ndarray, "4"]
    """The attitude to hold, unit quaternion, scalar last."""


class OpenLoop(NamedTuple):
    """Torques that depend on time alone."""

    torque: Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, "n actuators"]]
    """Torque at given times (s): of each joint (N m or N), or on each rotor (N m)."""


AttitudeState = tuple[
    Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]
]
"""Attitude `x_WD`; its rate and acceleration in D's axes, rad and s."""


@runtime_checkable
class AttitudeMotion(Protocol):
    """What the base is commanded to do: any function of time."""

    def at(self, t: Float[np.ndarray, " n"]) -> AttitudeState:
        """The attitude at the times `t`, s, and how it changes."""
        ...


class ComputedTorque(NamedTuple):
    """The torques for which a model says `y'' = y_d'' + kd e' + kp e`, for all of y.

    `y` are the joints and the attitude of the base; the wheels' accelerations are what
    this takes, and the system CM is left alone. One such law is the law of the joints
    and of the wheels.
    """

    model: Robot
    """The robot as the controller has it: torques follow from its `theta`."""
    base: AttitudeMotion
    kp: float
    """1/s^2."""
    kd: float
    """1/s."""


JointLaw = JointPD | Driven | OpenLoop | ComputedTorque
WheelLaw = WheelSpeed | AttitudeHold | OpenLoop | ComputedTorque


class WheelLimits(NamedTuple):
    """The greatest torques and speeds of motors; infinite where there is no limit.

    A motor gives at most its greatest torque, and none that drives the wheel beyond its
    top speed: over the last 2 % of that speed the torque falls to zero.
    """

    torque: Float[np.ndarray, " wheels"]
    """N m."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


class FlyingState(NamedTuple):
    """Everything that moves, at one time."""

    base: BaseState
    q: Float[np.ndarray, " joints"]
    qd: Float[np.ndarray, " joints"]
    r_S: Float[np.ndarray, "3"]
    """Position of S, inertial axes, m."""
    q_rw: Float[np.ndarray, " wheels"]
    """Wheel angles over full turns, rad."""


def standing(base: BaseState, q: Float[np.ndarray, " joints"]) -> FlyingState:
    """Joints at rest; S is at the origin, and wheel angles are counted from here."""
    return FlyingState(base, q, np.zeros_like(q), np.zeros(3), 0 * base.wheel_speed)


class FreeFlying(NamedTuple):
    """A free-flying motion at its sample times."""

    t: Float[np.ndarray, " n"]
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    qdd: Float[np.ndarray, "n joints"]
    attitude: Float[np.ndarray, "n 4"]
    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    w_dot: Float[np.ndarray, "n 3"]
    """Its derivative, rad/s^2."""
    q_rw: Float[np.ndarray, "n wheels"]
    """Wheel angles over full turns, rad."""
    qd_rw: Float[np.ndarray, "n wheels"]
    """Relative to the base, rad/s."""
    qdd_rw: Float[np.ndarray, "n wheels"]
    r_S: Float[np.ndarray, "n 3"]
    """Position of S, inertial axes, m."""
    v_S: Float[np.ndarray, "n 3"]
    """Velocity of S, inertial axes, m/s."""
    f_S: Float[np.ndarray, "n 3"]
    """Specific force at S, base axes, m/s^2."""
    r_cm: Float[np.ndarray, "n 3"]
    """Position of the system CM, inertial axes, m."""
    v_cm: Float[np.ndarray, "n 3"]
    """Velocity of the system CM, inertial axes, m/s."""
    h_cm: Float[np.ndarray, "n 3"]
    """Angular momentum about the system CM, inertial axes, N m s."""
    tau: Float[np.ndarray, "n joints"]
    """Joint torques, N m or N."""
    tau_rw: Float[np.ndarray, "n wheels"]
    """Torques on the rotors, N m."""
    force: Float[np.ndarray, "n 3"]
    """Net thruster force, base axes, N; at an edge that of what follows."""
    torque: Float[np.ndarray, "n 3"]
    """Net moment of the thrusters about S, base axes, N m."""
    error: float
    """Estimate of the largest error of attitude, joints and position; rad or m."""
    steps: int
    """RK4 steps in all."""

    def state(self, k: int) -> FlyingState:
        """Where a motion that goes on from sample `k` starts."""
        base = BaseState(self.w[k], self.attitude[k], self.v_S[k], self.qd_rw[k])
        return FlyingState(base, self.q[k], self.qd[k], self.r_S[k], self.q_rw[k])


STEPS = 4096
"""Steps whose commands are in memory at once."""


class WrenchPoint(NamedTuple):
    """Where a wrench acts, as long as the flight lasts."""

    body: int
    """Index of the body."""
    point: Float[np.ndarray, "3"]
    """Point where the wrench acts, in the body's frame, m."""


AT_S = (WrenchPoint(0, np.zeros(3)),)
"""The thrusters' net wrench: on the base, its force at S."""


def commanded(
    robot: Robot,
    command: JointMotion,
    laws: tuple[JointLaw, WheelLaw | None],
    nodes: Float[np.ndarray, "steps 3"],
    wrenches: Float[np.ndarray, "steps 3 wrenches 6"],
) -> Float[np.ndarray, "steps 3 columns"]:
    """What moves a robot besides its own state, as the core's `Command` has it.

    Nodes are start, middle and end of some steps, s, and wrenches each force and moment
    there, base axes, N and N m. The laws are of the joints and of the wheels.
    """
    t, (joints, wheels) = nodes.ravel(), laws
    base = np.zeros((t.size, 10))
    if isinstance(joints, ComputedTorque):
        base = np.hstack(joints.base.at(t))
    columns = (
        *command.at(t),
        _open_loop(joints, t, len(robot.joints)),
        _open_loop(wheels, t, len(robot.wheels)),
        base,
        wrenches.reshape(t.size, -1),
    )
    return np.hstack(columns).reshape(*nodes.shape, -1)


class FlightStates(NamedTuple):
    """The states of some steps at their starts, and what else there is to see."""

    q: Float[np.ndarray, "n joints"]
    x_WB: Float[np.ndarray, "n 4"]
    q_rw: Float[np.ndarray, "n wheels"]
    v: Float[np.ndarray, "n speeds"]
    """Generalised speeds, base axes."""
    vd: Float[np.ndarray, "n speeds"]
    r_cm: Float[np.ndarray, "n 3"]
    """Inertial axes, as the next three are."""
    r_S: Float[np.ndarray, "n 3"]
    v_cm: Float[np.ndarray, "n 3"]
    v_S: Float[np.ndarray, "n 3"]
    f_S: Float[np.ndarray, "n 3"]
    """Acceleration of S, base axes."""
    h_cm: Float[np.ndarray, "n 3"]
    """Inertial axes."""
    tau: Float[np.ndarray, "n joints"]
    tau_rw: Float[np.ndarray, "n wheels"]


def vehicle_of(
    robot: Robot,
    joints: JointLaw,
    wheels: WheelLaw | None,
    limits: WheelLimits | None,
    points: Sequence[WrenchPoint] = AT_S,
) -> _core.Vehicle:
    """The robot with its laws; a law of another kind has zero gains.

    Passive joints are on their springs, whatever the law.
    """
    K, W = len(robot.joints), len(robot.wheels)
    pd = joints if isinstance(joints, JointPD) else JointPD(*np.zeros((2, K)))
    speed = wheels if isinstance(wheels, WheelSpeed) else WheelSpeed(*np.zeros((2, W)))
    none = AttitudeHold(0.0, 0.0, UNTURNED)
    hold = wheels if isinstance(wheels, AttitudeHold) else none
    springs, rotors = springs_on(robot), wheels_of(robot)
    limits = limits or WheelLimits(*np.full((2, W), np.inf))
    free = movable(robot).astype(float)
    if isinstance(joints, Driven):
        free[6 : 6 + K] = [name in robot.passive for name in robot.joint_names]
    if wheels is None:
        free[6 + K :] = rotors.free
    computed = None
    if isinstance(joints, ComputedTorque):
        of_momentum = np.linalg.pinv(wheels_of(joints.model).A_rw)
        model = core_robot(joints.model)
        computed = _core.ComputedTorque(model, of_momentum, joints.kp, joints.kd)
    return _core.Vehicle(
        robot=core_robot(robot),
        free=free,
        Kp=pd.Kp + springs.k,
        Kd=pd.Kd + springs.c,
        k=speed.k,
        speed=speed.speed,
        share=np.linalg.pinv(rotors.axes),
        kp=hold.kp,
        kd=hold.kd,
        x_WD=hold.x_WD,
        torque_limit=limits.torque,
        speed_limit=limits.speed,
        body=np.array([point.body for point in points], dtype=float),
        point=np.reshape([point.point for point in points], (-1, 3)),
        computed=computed,
    )


def integrate(
    vehicle: _core.Vehicle,
    start: Float[np.ndarray, " states"],
    nodes: Float[np.ndarray, "steps 3"],
    command_at: Callable[
        [Float[np.ndarray, "rows 3"]], Float[np.ndarray, "rows 3 columns"]
    ],
    wanted: Bool[np.ndarray, " steps"],
) -> FlightStates:
    """What is seen at the start of the wanted steps.

    The first state is `[r_cm, x_WB, q, q_rw, v]`. Nodes are start, middle and end of
    each step, s; the last step may have no length, and shows the end. The vehicle is
    commanded at the nodes of some steps at a time.
    """
    pieces, state = [], start
    for first in range(0, len(nodes), STEPS):
        part = slice(first, first + STEPS)
        dt = nodes[part, 2] - nodes[part, 0]
        shown = wanted[part].astype(float)
        state, seen = _core.fly(vehicle, state, dt, command_at(nodes[part]), shown)
        pieces.append(seen)
    return FlightStates(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))


def _open_loop(
    law: JointLaw | WheelLaw | None, t: Float[np.ndarray, " n"], count: int
) -> Float[np.ndarray, "n actuators"]:
    return law.torque(t) if isinstance(law, OpenLoop) else np.zeros((t.size, count))
