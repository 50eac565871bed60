"""Free-flying motion: thrusters, wheels and joint torques move the robot (Eq. 13)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.bounds import SHORTEST
from orbident.model.equations_of_motion import check_regular
from orbident.model.kinematics import inertia_at
from orbident.model.rotations import quaternion_matrix, rotate_back, rotation_angle
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.robot.parameters import inertia_about_com
from orbident.simulation.flight import (
    AT_S,
    Driven,
    FlightStates,
    FlyingState,
    FreeFlying,
    JointLaw,
    WheelLaw,
    WheelLimits,
    commanded,
    integrate,
    vehicle_of,
)
from orbident.simulation.free_floating import JointMotion, check_plane
from orbident.simulation.outside import (
    Path,
    Pulse,
    Wrenches,
    check_pulses,
    outside_of,
    thrust,
    true_pulses,
)
from orbident.trajectories.environment import Environment

MOST_STEPS = 2**19
"""Of RK4; a motion that needs more does not settle."""


def free_flying(
    robot: Robot,
    t: Float[np.ndarray, " n"],
    start: FlyingState,
    command: JointMotion,
    joints: JointLaw,
    wheels: WheelLaw | None = None,
    limits: WheelLimits | None = None,
    pulses: Sequence[Pulse] = (),
    tolerance: float = 1e-8,
    environment: Environment | None = None,
    seed: int = 0,
) -> FreeFlying:
    """How the robot moves under controllers, thrusters and what acts from outside.

    Eqs. 13 and 15.

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
        environment: what acts from outside; nothing by default.
        seed: of what is random of it.

    Raises:
        InputError: a planar robot starts out of its plane, the mass matrix is singular,
            the wheels are heavier than the base, a pulse cannot be flown, the
            environment is not one of this robot, joints are controlled and some are
            passive, or no step is small enough.
    """
    environment = environment or Environment()
    pulses = (*pulses, *true_pulses(environment))
    if not isinstance(joints, Driven):
        require_measured(robot, "control of joints")
    if robot.motion == "planar":
        check_plane(start.base)
    check_regular(robot)
    _check_wheels(robot)
    check_pulses(robot, pulses, float(t[0]), float(t[-1]))
    outside = outside_of(robot, environment, t, seed)
    edges = [edge for pulse in pulses for edge in (pulse.on, pulse.off)]
    edges += [edge for edge in outside.edges if t[0] < edge < t[-1]]
    breaks = _breaks(t, np.unique(edges))

    def thrust_at(nodes: Float[np.ndarray, "steps 3"]) -> Float[np.ndarray, "steps 6"]:
        # No step straddles an edge: the thrust is that of its middle.
        return thrust(robot, pulses, nodes[:, 1])

    vehicle = vehicle_of(robot, joints, wheels, limits, (*AT_S, *outside.points))
    at_start = _at_start(robot, start)

    def solve(parts: int, path: Path | None) -> StateHistory:
        nodes = _step_nodes(breaks, parts)
        wanted = np.zeros(len(nodes), dtype=bool)
        wanted[parts * np.searchsorted(breaks, t)] = True

        def fly(wrenches: Wrenches) -> FlightStates:
            def at(some: Float[np.ndarray, "steps 3"]) -> Float[np.ndarray, "..."]:
                net = np.tile(thrust_at(some)[:, None, None], (1, 3, 1, 1))
                both = np.concatenate([net, wrenches(some)], axis=2)
                return commanded(robot, command, (joints, wheels), some, both)

            # What acts depends on the motion everywhere.
            shown = wanted if not outside.points else np.ones_like(wanted)
            return integrate(vehicle, at_start, nodes, at, shown)

        seen, path = outside.settled(fly, nodes[:, 0], path, tolerance / 10)
        if outside.points:
            seen = FlightStates(*(each[wanted] for each in seen))
        return StateHistory(seen, thrust_at(nodes[wanted]), path)

    solved, error, parts = _refined(robot, solve, breaks.size, tolerance)
    flown = _flown(t, solved.seen, solved.thrust, error, parts * (breaks.size - 1))
    pull = rotate_back(quaternion_matrix(flown.attitude), outside.pull_at_S(flown.r_S))
    return flown._replace(f_S=flown.f_S - pull)


ROUNDING = 1e-12
"""Relative; a base that is all wheels has inertia zero but for this."""


def _check_wheels(robot: Robot) -> None:
    """What the base is without its wheels must still be a body."""
    I = inertia_about_com(robot.theta[0])
    largest = np.linalg.eigvalsh(I).max()
    for wheel in robot.wheels:
        I = I - wheel.inertia * np.outer(wheel.axis, wheel.axis)
    free = I[2:, 2:] if robot.motion == "planar" else I
    smallest = np.linalg.eigvalsh(free).min()
    if smallest < -ROUNDING * largest:
        raise InputError(
            f"{robot.name}: without its wheels the base has inertia {smallest:g} "
            "kg m^2 about some axis; a wheel's inertia is counted in the base: give "
            "the base more, or the wheels less"
        )


class StateHistory(NamedTuple):
    """A motion with steps of one length."""

    seen: FlightStates
    thrust: Float[np.ndarray, "n 6"]
    path: Path | None
    """The motion between the samples, where something acts that depends on it."""


def _breaks(
    t: Float[np.ndarray, " n"], edges: Float[np.ndarray, " edges"]
) -> Float[np.ndarray, " breaks"]:
    """Sample times and edges, but one of those that differ by rounding alone."""
    edges = edges[np.diff(edges, prepend=-np.inf) > SHORTEST]
    nearest = t[np.searchsorted((t[1:] + t[:-1]) / 2, edges)]
    return np.union1d(t, edges[np.abs(edges - nearest) > SHORTEST])


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


def _at_start(robot: Robot, start: FlyingState) -> Float[np.ndarray, " states"]:
    """`[r_cm, x_WB, q, q_rw, v]`."""
    base, at = start.base, inertia_at(robot, start.q)
    R_WB = quaternion_matrix(base.attitude)
    # Eq. 28, the other way round.
    v_cm = R_WB.T @ base.velocity + at.J_cm @ start.qd
    v_cm += np.cross(base.angular_velocity, at.r_cm)
    return np.concatenate(
        [
            start.r_S + R_WB @ at.r_cm,
            base.attitude / np.linalg.norm(base.attitude),
            start.q,
            start.q_rw,
            v_cm,
            base.angular_velocity,
            start.qd,
            base.wheel_speed,
        ]
    )


def _refined(
    robot: Robot,
    solve: Callable[[int, Path | None], StateHistory],
    breaks: int,
    tolerance: float,
) -> tuple[StateHistory, float, int]:
    """The motion, its error, and the number of steps from each break to the next."""
    parts, coarse, error = 1, solve(1, None), np.inf
    while 2 * parts * breaks <= MOST_STEPS:
        parts *= 2
        fine = solve(parts, coarse.path)
        # Where a limit cuts in, halving does not divide the error by RK4's 16: the
        # whole difference is taken.
        error = _difference(coarse.seen, fine.seen)
        if error <= tolerance:
            return fine, error, parts
        coarse = fine
    raise InputError(
        f"{robot.name}: the motion does not settle: with {parts * breaks} steps it "
        f"changes by {error:.2g} when they are halved, more than {tolerance:g}; lower "
        "the gains, raise the tolerance, or fly a shorter time"
    )


def _difference(a: FlightStates, b: FlightStates) -> float:
    """The largest of attitude, joints and position, rad or m; infinite for a NaN."""
    with np.errstate(all="ignore"):
        largest = (
            np.abs(a.r_cm - b.r_cm).max(),
            np.abs(a.q - b.q).max(initial=0.0),
            rotation_angle(a.x_WB, b.x_WB).max(),
        )
    # A motion that blew up is not a number.
    return float(np.nan_to_num(largest, nan=np.inf).max())


def _flown(
    t: Float[np.ndarray, " n"],
    seen: FlightStates,
    thrust: Float[np.ndarray, "n 6"],
    error: float,
    steps: int,
) -> FreeFlying:
    named, joints_end = seen._asdict(), 6 + seen.q.shape[1]
    _, w, qd, qd_rw = np.split(named.pop("v"), [3, 6, joints_end], axis=1)
    _, w_dot, qdd, qdd_rw = np.split(named.pop("vd"), [3, 6, joints_end], axis=1)
    return FreeFlying(
        t=t,
        attitude=named.pop("x_WB"),
        qd=qd,
        qdd=qdd,
        w=w,
        w_dot=w_dot,
        qd_rw=qd_rw,
        qdd_rw=qdd_rw,
        force=thrust[:, :3],
        torque=thrust[:, 3:],
        error=error,
        steps=steps,
        **named,
    )
