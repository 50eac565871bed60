"""A free-flying vehicle as the core integrates it, by RK4 steps of given lengths."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import movable
from orbident.model.wheel_arrays import wheels_of
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
from orbident.simulation.free_floating import JointMotion

STEPS = 4096
"""Steps whose commands are in memory at once."""

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


class WrenchPoint(NamedTuple):
    """Where a wrench acts, as long as the flight lasts."""

    body: int
    """Index of the body."""
    point: Float[np.ndarray, "3"]
    """Point where the wrench acts, in the body's frame, m."""


AT_S = (WrenchPoint(0, np.zeros(3)),)
"""The thrusters' net wrench: on the base, its force at S."""


class Drive(NamedTuple):
    """What moves a robot, besides its own state."""

    command: JointMotion
    joints: JointLaw
    wheels: WheelLaw | None
    wrenches: Callable[
        [Float[np.ndarray, "steps 3"]], Float[np.ndarray, "steps 3 wrenches 6"]
    ]
    """Force and moment of each wrench at the nodes of some steps, base axes."""

    def at(
        self, robot: Robot, nodes: Float[np.ndarray, "steps 3"]
    ) -> Float[np.ndarray, "steps 3 columns"]:
        """A row for each node, as the core's `Command` has it."""
        t = nodes.ravel()
        base = np.zeros((t.size, 10))
        if isinstance(self.joints, ComputedTorque):
            base = np.hstack(self.joints.base.at(t))
        columns = (
            *self.command.at(t),
            _open_loop(self.joints, t, len(robot.joints)),
            _open_loop(self.wheels, t, len(robot.wheels)),
            base,
            self.wrenches(nodes).reshape(t.size, -1),
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
    """The robot with its laws; a law of another kind has zero gains."""
    K, W = len(robot.joints), len(robot.wheels)
    pd, speed = JointPD(np.zeros(K), np.zeros(K)), WheelSpeed(np.zeros(W), np.zeros(W))
    hold = AttitudeHold(0.0, 0.0, LEVEL, np.zeros((W, 3)))
    pd = joints if isinstance(joints, JointPD) else pd
    speed = wheels if isinstance(wheels, WheelSpeed) else speed
    hold = wheels if isinstance(wheels, AttitudeHold) else hold
    unlimited = np.full(W, np.inf)
    limits = limits or WheelLimits(unlimited, unlimited)
    free = movable(robot).astype(float)
    if isinstance(joints, Driven):
        free[6 : 6 + K] = 0.0
    if wheels is None:
        free[6 + K :] = wheels_of(robot).free
    return _core.Vehicle(
        robot=core_robot(robot),
        free=free,
        Kp=pd.Kp,
        Kd=pd.Kd,
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
        computed=_computed(joints) if isinstance(joints, ComputedTorque) else None,
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

    Args:
        vehicle: what moves.
        start: the first state `[r_cm, x_WB, q, q_rw, v]`.
        nodes: start, middle and end of each step, s. The last step may have no length,
            and shows the end.
        command_at: what the vehicle is commanded at the nodes of some steps.
        wanted: the steps to show.
    """
    pieces, state = [], start
    for first in range(0, len(nodes), STEPS):
        part = slice(first, first + STEPS)
        dt = nodes[part, 2] - nodes[part, 0]
        shown = wanted[part].astype(float)
        state, seen = _core.fly(vehicle, state, dt, command_at(nodes[part]), shown)
        pieces.append(seen)
    return FlightStates(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))


def _computed(law: ComputedTorque) -> _core.ComputedTorque:
    of_momentum = np.linalg.pinv(wheels_of(law.model).A_rw)
    return _core.ComputedTorque(core_robot(law.model), of_momentum, law.kp, law.kd)


def _open_loop(
    law: JointLaw | WheelLaw | None, t: Float[np.ndarray, " n"], count: int
) -> Float[np.ndarray, "n actuators"]:
    return law.torque(t) if isinstance(law, OpenLoop) else np.zeros((t.size, count))
