"""Free-floating motion (Eqs. 2, 3, 17, 18): momentum conserved by construction."""

from functools import partial
from typing import NamedTuple, Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.attitude import RateLaw, float_attitude, rate_law
from orbident.dynamics.batches import in_batches
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import Tree, tree_of
from orbident.dynamics.wheels import wheels_of
from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, quaternion_matrix, rotate

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
    """Of S, inertial axes, m/s."""
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


@in_float64
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
    tree, wheels = tree_of(robot), wheels_of(robot)
    # A free wheel keeps its absolute spin qd_rw + a w, a held one its relative spin.
    spin = start.wheel_speed + wheels.free * (wheels.axes.T @ start.angular_velocity)
    # What a free wheel adds to D w: its momentum is A_rw (spin - a w).
    D_free = (wheels.A_rw * wheels.free) @ wheels.axes.T

    def terms_at(t: Float[np.ndarray, " n"]) -> Terms:
        q, qd, _ = motion.at(t)
        return in_batches(partial(_terms, tree, robot.theta), q, qd)

    def law_at(t: Float[np.ndarray, " n"]) -> RateLaw:
        at = terms_at(t)
        return rate_law(at.D - D_free, at.h_q + wheels.A_rw @ spin, planar)

    at = terms_at(t)
    h_start = at.D[0] @ start.angular_velocity + at.h_q[0]
    R_start = np.asarray(_matrix(start.attitude))
    h_cm = R_start @ (h_start + wheels.A_rw @ start.wheel_speed)
    if planar:
        h_cm[:2] = 0.0

    x_WB, law, error, substeps = float_attitude(
        law_at, t, h_cm, start.attitude, tolerance
    )
    w, r_S, v_S = in_batches(partial(_observe, h_cm), x_WB, law, at.r_cm, at.v_q)
    v_cm = start.velocity - v_S[0]
    q, qd, _ = motion.at(t)
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


_matrix = compiled(quaternion_matrix)


class Terms(NamedTuple):
    """What momentum needs of the joint states, base axes."""

    D: Float[AnyArray, "n 3 3"]
    h_q: Float[AnyArray, "n 3"]
    """`D_q qd`."""
    r_cm: Float[AnyArray, "n 3"]
    """From S to the system CM."""
    v_q: Float[AnyArray, "n 3"]
    """Velocity of the CM relative to S by the joints alone."""


@compiled
def _terms(
    tree: Tree,
    theta: Float[AnyArray, "bodies 10"],
    q: Float[AnyArray, "n joints"],
    qd: Float[AnyArray, "n joints"],
) -> Terms:
    def terms(q: Float[AnyArray, " joints"], qd: Float[AnyArray, " joints"]) -> Terms:
        at = inertia(tree, theta, q)
        return Terms(at.D, at.D_q @ qd, at.r_cm, at.J_cm @ qd)

    return jax.vmap(terms)(q, qd)


@compiled
def _observe(
    h_cm: Float[AnyArray, "3"],
    x_WB: Float[AnyArray, "n 4"],
    law: RateLaw,
    r_cm: Float[AnyArray, "n 3"],
    v_q: Float[AnyArray, "n 3"],
) -> tuple[Float[AnyArray, "n 3"], Float[AnyArray, "n 3"], Float[AnyArray, "n 3"]]:
    """Base rate; position and velocity of S relative to the CM, inertial axes."""
    w = law.rate(x_WB, h_cm)
    R_WB = quaternion_matrix(x_WB)
    return w, -rotate(R_WB, r_cm), -rotate(R_WB, cross(w, r_cm) + v_q)


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
