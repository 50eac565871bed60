"""A free-flying motion: where it starts, its steps, what it was."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident import _core
from orbident.model.core_robot import core_robot, wheels_of
from orbident.model.equations_of_motion import movable
from orbident.model.kinematics import springs_on
from orbident.model.rotations import UNTURNED
from orbident.robot.description import Robot
from orbident.simulation.control_laws import (
    AttitudeHold,
    ComputedTorque,
    Driven,
    JointLaw,
    JointPD,
    OpenLoop,
    WheelLaw,
    WheelLimits,
    WheelSpeed,
)
from orbident.simulation.free_floating import BaseState, JointMotion


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
    pd, speed = JointPD(np.zeros(K), np.zeros(K)), WheelSpeed(np.zeros(W), np.zeros(W))
    hold = AttitudeHold(0.0, 0.0, UNTURNED, np.zeros((W, 3)))
    pd = joints if isinstance(joints, JointPD) else pd
    springs = springs_on(robot)
    speed = wheels if isinstance(wheels, WheelSpeed) else speed
    hold = wheels if isinstance(wheels, AttitudeHold) else hold
    unlimited = np.full(W, np.inf)
    limits = limits or WheelLimits(unlimited, unlimited)
    free = movable(robot).astype(float)
    if isinstance(joints, Driven):
        free[6 : 6 + K] = [name in robot.passive for name in robot.joint_names]
    if wheels is None:
        free[6 + K :] = wheels_of(robot).free
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
        share=hold.share,
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
