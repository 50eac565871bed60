"""Free-floating motion (Eqs. 2, 3, 17, 18): momentum conserved by construction."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.model.core_robot import core_robot
from orbident.model.inertia import inertia_at
from orbident.model.rotations import quaternion_matrix
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.description import Robot
from orbident.simulation.attitude import RateLaw, float_attitude
from orbident.threads import processors

OUT_OF_PLANE = 1e-9

JointState = tuple[
    Float[np.ndarray, "n joints"],
    Float[np.ndarray, "n joints"],
    Float[np.ndarray, "n joints"],
]


@runtime_checkable
class JointMotion(Protocol):
    """What the joints do: any function of time."""

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at the times `t`, s."""
        ...


class BaseState(NamedTuple):
    """The base and the wheels at the first sample."""

    angular_velocity: Float[np.ndarray, "3"]
    """Base axes, rad/s."""
    attitude: Float[np.ndarray, "4"]
    """Unit quaternion, scalar last; rotates base vectors into inertial axes."""
    velocity: Float[np.ndarray, "3"]
    """Velocity of S, inertial axes, m/s."""
    wheel_speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


class FreeFloating(NamedTuple):
    """A free-floating motion at its sample times."""

    t: Float[np.ndarray, " n"]
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    attitude: Float[np.ndarray, "n 4"]
    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    qd_rw: Float[np.ndarray, "n wheels"]
    r_S: Float[np.ndarray, "n 3"]
    """Position of S, inertial axes, m; zero at the start."""
    v_S: Float[np.ndarray, "n 3"]
    h_cm: Float[np.ndarray, "3"]
    """Angular momentum about the system CM, inertial axes, N m s: constant."""
    v_cm: Float[np.ndarray, "3"]
    """Velocity of the system CM, inertial axes, m/s: constant."""
    attitude_error: float
    """Estimate of the largest attitude error, rad."""
    substeps: int
    """RK4 steps from one sample to the next."""


def free_floating(
    robot: Robot,
    motion: JointMotion,
    t: Float[np.ndarray, " n"],
    start: BaseState,
    tolerance: float = 1e-9,
) -> FreeFloating:
    """How the free-floating robot moves while its joints do as commanded.

    Args:
        robot: with its nominal inertia.
        motion: what the joints do.
        t: sample times, s.
        start: the base and the wheels at `t[0]`.
        tolerance: of the attitude, rad.

    Raises:
        InputError: the base turns too fast for these sample times, or a planar robot
            starts out of its plane.
    """
    planar = robot.motion == "planar"
    if planar:
        check_plane(start)
    core, wheels = core_robot(robot), wheels_of(robot)
    # A free wheel keeps its absolute spin qd_rw + a w, a held one its relative spin.
    spin = start.wheel_speed + wheels.free * (wheels.axes.T @ start.angular_velocity)
    # What a free wheel adds to D w: its momentum is A_rw (spin - a w).
    D_free = (wheels.A_rw * wheels.free) @ wheels.axes.T

    h_spin = wheels.A_rw @ spin

    def law_at(t: Float[np.ndarray, " n"]) -> RateLaw:
        q, qd, _ = motion.at(t)
        law = _core.floating_laws(core, q, qd, D_free, h_spin, planar, processors())
        return RateLaw(*law)

    q, qd, _ = motion.at(t)
    at = inertia_at(robot, q[0])
    h_B = at.D @ start.angular_velocity + at.D_q @ qd[0]
    h_B += wheels.A_rw @ start.wheel_speed
    h_cm = quaternion_matrix(start.attitude) @ h_B
    if planar:
        h_cm[:2] = 0.0

    x_WB, law, error, substeps = float_attitude(
        law_at, t, h_cm, start.attitude, tolerance
    )
    h = np.tile(h_cm, (t.size, 1))
    w, r_S, v_S = _core.floating_motion(
        core, q, qd, law.E, law.b, h, x_WB, processors()
    )
    v_cm = start.velocity - v_S[0]
    return FreeFloating(
        t=t,
        q=q,
        qd=qd,
        attitude=x_WB,
        w=w,
        qd_rw=spin - wheels.free * (w @ wheels.axes),
        r_S=r_S - r_S[0] + v_cm * (t - t[0])[:, None],
        v_S=v_S + v_cm,
        h_cm=h_cm,
        v_cm=v_cm,
        attitude_error=error,
        substeps=substeps,
    )


def check_plane(start: BaseState) -> None:
    """Refuse a planar robot's start that leaves the plane.

    Raises:
        InputError: so.
    """
    out = {
        "angular_velocity": start.angular_velocity[:2],
        "attitude": start.attitude[:2],
        "velocity": start.velocity[2:],
    }
    for name, components in out.items():
        if np.abs(components).max() > OUT_OF_PLANE:
            raise InputError(
                f"initial {name} {np.array(getattr(start, name)).tolist()} leaves the "
                "plane; a planar robot turns about z and moves in x and y only"
            )
