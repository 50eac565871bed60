"""Free-flying motion: thrusters, wheels and joint torques move the robot (Eq. 13)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.batches import in_batches
from orbident.dynamics.control_laws import ControlLaw, JointCommand
from orbident.dynamics.equations_of_motion import Model, model_of
from orbident.dynamics.flight import FlyingState, FreeFlying
from orbident.dynamics.flight_checks import check_flight
from orbident.dynamics.flight_steps import Moving, Seen, Told, Vehicle, integrate
from orbident.dynamics.free_floating import JointMotion
from orbident.dynamics.inertia import inertia
from orbident.dynamics.thrusters import Pulse, thrust
from orbident.dynamics.wheel_limits import WheelLimits
from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import (
    cross,
    quaternion_matrix,
    rotate,
    rotate_back,
    rotation_angle,
)

MOST_STEPS = 2**19

Path = tuple[Moving, Seen, Told]
"""A motion at its sample times."""


@in_float64
def free_flying(
    robot: Robot,
    t: Float[np.ndarray, " n"],
    start: FlyingState,
    command: JointMotion,
    joints: ControlLaw,
    wheels: ControlLaw | None = None,
    limits: WheelLimits | None = None,
    pulses: Sequence[Pulse] = (),
    tolerance: float = 1e-8,
) -> FreeFlying:
    """How the robot moves under its controllers and thrusters (Eqs. 13, 15).

    RK4 with steps that end on every sample time and every pulse edge, halved until
    the motion at the samples changes by no more than `tolerance`.

    Args:
        robot: with its nominal inertia.
        t: sample times, s.
        start: the state at `t[0]`.
        command: what the joints are told to do.
        joints: the law of the joint torques, N m or N.
        wheels: the law of the torques on the rotors, N m; without one, each wheel is
            held or free as the robot says.
        limits: of the wheels' motors, where a law drives them.
        pulses: of the thrusters, within the times of the samples.
        tolerance: of attitude, joints and position, rad or m.

    Raises:
        InputError: the times do not increase, something has not the size of the robot,
            a planar robot starts out of its plane, the mass matrix is singular, the
            wheels are heavier than the base, a pulse cannot be flown, or no step is
            small enough.
    """
    vehicle = _vehicle(robot, joints, wheels, limits)
    check_flight(robot, vehicle, t, start, command, pulses)
    edges = [edge for pulse in pulses for edge in (pulse.on, pulse.off)]
    breaks = np.unique(np.concatenate([t, edges]))
    at_start = _at_start(vehicle.model, start)

    def told_at(nodes: Float[np.ndarray, "rows 3"]) -> Told:
        # No step straddles an edge: the thrust is that of its middle.
        force = np.repeat(thrust(robot, pulses, nodes[:, 1])[:, None], 3, axis=1)
        return Told(nodes, _commanded(command, nodes), force)

    def solve(parts: int) -> Path:
        nodes = _step_nodes(breaks, parts)
        wanted = np.zeros(len(nodes), dtype=bool)
        wanted[parts * np.searchsorted(breaks, t)] = True
        return integrate(vehicle, at_start, nodes, told_at, wanted)

    path, error, parts = _refined(robot, solve, breaks.size, tolerance)
    return _flown(vehicle.model, t, path, error, parts * (breaks.size - 1))


def _step_nodes(
    breaks: Float[np.ndarray, " n"], parts: int
) -> Float[np.ndarray, "steps 3"]:
    """Start, middle and end of `parts` equal steps from each break to the next.

    A last step of no length is at the last break.
    """
    part = np.arange(parts + 1) / parts
    grid = breaks[:-1, None] * (1 - part) + breaks[1:, None] * part
    starts = np.append(grid[:, :-1], breaks[-1])
    ends = np.append(grid[:, 1:], breaks[-1])
    return np.stack([starts, (starts + ends) / 2, ends], axis=1)


def _vehicle(
    robot: Robot,
    joints: ControlLaw,
    wheels: ControlLaw | None,
    limits: WheelLimits | None,
) -> Vehicle:
    model, count = model_of(robot), len(robot.wheels)
    if wheels is None:
        free = np.concatenate([model.free[: 6 + len(robot.joints)], model.wheels.free])
        model = replace(model, free=free)
    if limits is None:
        limits = WheelLimits(np.full(count, np.inf), np.full(count, np.inf))
    return Vehicle(model, joints, wheels, limits)


def _commanded(command: JointMotion, t: Float[np.ndarray, "steps 3"]) -> JointCommand:
    q, qd, qdd = command.at(t.ravel())
    return JointCommand(*(x.reshape(*t.shape, x.shape[1]) for x in (q, qd, qdd)))


@compiled
def _at_start(model: Model, start: FlyingState) -> Moving:
    base, at = start.base, inertia(model.tree, model.theta, start.q)
    R_WB = quaternion_matrix(base.attitude)
    # Eq. 28, the other way round.
    v_cm = rotate_back(R_WB, base.velocity) + at.J_cm @ start.qd
    v_cm += cross(base.angular_velocity, at.r_cm)
    return Moving(
        r_cm=start.r_S + rotate(R_WB, at.r_cm),
        x_WB=base.attitude / jnp.linalg.norm(base.attitude),
        q=jnp.asarray(start.q),
        q_rw=jnp.asarray(start.q_rw),
        v=jnp.concatenate([v_cm, base.angular_velocity, start.qd, base.wheel_speed]),
    )


def _refined(
    robot: Robot, solve: Callable[[int], Path], breaks: int, tolerance: float
) -> tuple[Path, float, int]:
    """The motion, its error, and the number of steps from each break to the next."""
    parts, coarse, error = 1, solve(1), np.inf
    while 2 * parts * breaks <= MOST_STEPS:
        parts *= 2
        fine = solve(parts)
        # Where a limit cuts in, halving does not divide the error by RK4's 16: the
        # whole difference is taken.
        error = float(_difference(coarse[0], fine[0]))
        if error <= tolerance:
            return fine, error, parts
        coarse = fine
    raise InputError(
        f"{robot.name}: the motion does not settle: with {parts * breaks} steps it "
        f"changes by {error:.2g} when they are halved, more than {tolerance:g}; lower "
        "the gains, raise the tolerance, or fly a shorter time"
    )


@compiled
def _difference(a: Moving, b: Moving) -> Float[AnyArray, ""]:
    """The largest of attitude, joints and position, rad or m."""
    largest = [
        jnp.abs(a.r_cm - b.r_cm).max(),
        jnp.abs(a.q - b.q).max(initial=0.0),
        rotation_angle(a.x_WB, b.x_WB).max(),
    ]
    # A motion that blew up is not a number.
    return jnp.nan_to_num(jnp.stack(largest), nan=jnp.inf).max()


def _flown(
    model: Model, t: Float[np.ndarray, " n"], path: Path, error: float, steps: int
) -> FreeFlying:
    motion, seen, told = jax.tree.map(np.asarray, path)
    p_S_cm, v_S, h_cm, v_cm = in_batches(
        _rotated, motion.x_WB, (seen.p_S_cm, seen.v_S, seen.h, motion.v[:, :3])
    )
    joints_end = 6 + motion.q.shape[1]
    return FreeFlying(
        t=t,
        q=motion.q,
        qd=motion.v[:, 6:joints_end],
        qdd=seen.vd[:, 6:joints_end],
        attitude=motion.x_WB,
        w=motion.v[:, 3:6],
        w_dot=seen.vd[:, 3:6],
        q_rw=motion.q_rw,
        qd_rw=motion.v[:, joints_end:],
        qdd_rw=seen.vd[:, joints_end:],
        r_S=motion.r_cm - p_S_cm,
        v_S=v_S,
        f_S=seen.f_S,
        r_cm=motion.r_cm,
        v_cm=v_cm,
        h_cm=h_cm,
        tau=seen.tau,
        tau_rw=seen.tau_rw,
        force=told.thrust[:, :3],
        torque=told.thrust[:, 3:],
        error=error,
        steps=steps,
    )


@compiled
def _rotated(
    x_WB: Float[AnyArray, "n 4"], vectors: tuple[Float[AnyArray, "n 3"], ...]
) -> tuple[Float[AnyArray, "n 3"], ...]:
    """From base into inertial axes."""
    R_WB = quaternion_matrix(x_WB)
    return tuple(rotate(R_WB, vector) for vector in vectors)
