"""Free-floating motion (Eqs. 2, 3, 17, 18): momentum conserved by construction.

Momentum conservation makes the base rate an algebraic function of time and attitude,

    w = E(t) R_0^T h_cm - b(t).

`E` and `b` do not depend on the attitude, so they are known for all times at once;
only the quaternion is integrated, by the one differential equation of free floating.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.model.core_robot import core_robot, wheels_of
from orbident.model.kinematics import JointState, inertia_at
from orbident.model.rotations import quaternion_matrix, rotate, rotate_back
from orbident.robot.description import Robot
from orbident.threads import processors
from orbident.trajectories.trajectory import InitialState

MOST_SUBSTEPS = 256
"""Between two samples; a base that needs more turns too fast for them."""


class RateLaw(NamedTuple):
    """`w = E R_0^T h_cm - b` at some times; base axes."""

    E: Float[np.ndarray, "*n 3 3"]
    b: Float[np.ndarray, "*n 3"]

    def rate(
        self, x_WB: Float[np.ndarray, "*n 4"], h_cm: Float[np.ndarray, "*#n 3"]
    ) -> Float[np.ndarray, "*n 3"]:
        """The base rate, rad/s, base axes."""
        h_B = rotate_back(quaternion_matrix(x_WB), h_cm)
        return rotate(self.E, h_B) - self.b


def rate_law(
    D: Float[np.ndarray, "n 3 3"], h_moving: Float[np.ndarray, "n 3"], planar: bool
) -> RateLaw:
    """The law from `D w + h_moving = R_0^T h_cm`; in the plane of its z row alone."""
    return RateLaw(*_core.rate_laws(D, h_moving, planar, processors()))


def step_nodes(t: Float[np.ndarray, " n"], substeps: int) -> Float[np.ndarray, " m"]:
    """The ends and middles of `substeps` equal steps from each sample to the next."""
    parts = np.arange(2 * substeps) / (2 * substeps)
    inner = t[:-1, None] + np.diff(t)[:, None] * parts
    return np.append(inner.ravel(), t[-1])


def float_attitude(
    law_at: Callable[[Float[np.ndarray, " nodes"]], RateLaw],
    t: Float[np.ndarray, " n"],
    h_cm: Float[np.ndarray, "3"],
    x_WB: Float[np.ndarray, "4"],
    tolerance: float,
) -> tuple[Float[np.ndarray, "n 4"], RateLaw, float, int]:
    """Integrate with steps that are halved until the error is below `tolerance`.

    The law may be had at any times. Sample times are in s; `h_cm` is about the system
    CM, inertial axes, N m s; `x_WB` is at the first sample, and the tolerance in rad.

    Returns:
        Attitude and law of the base rate at the samples; an estimate of the largest
        error, rad; and RK4 steps from one sample to the next.

    Raises:
        InputError: the base turns too fast for these sample times.
    """
    substeps = 2
    while True:
        nodes = step_nodes(t, substeps)
        law, momentum = law_at(nodes), np.tile(h_cm, (nodes.size, 1))
        x, apart = _core.attitudes(law.E, law.b, momentum, x_WB, t, substeps)
        # Richardson: halving the step of RK4 divides its error by 16.
        error = apart / 15
        if error <= tolerance:
            at_samples = RateLaw(*(part[:: 2 * substeps] for part in law))
            return x, at_samples, error, substeps
        if substeps == MOST_SUBSTEPS:
            raise InputError(
                f"the base turns too fast for samples up to {np.diff(t).max():g} s "
                f"apart: attitude error {error:.2g} rad with {substeps} steps a "
                f"sample, more than {tolerance:g}; sample faster or start with less "
                "momentum"
            )
        substeps *= 2


OUT_OF_PLANE = 1e-9
"""m/s, rad/s, or of a quaternion: so much is not rounding."""


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

    @classmethod
    def of(cls, initial: InitialState, robot: Robot) -> "BaseState":
        """As a trajectory of a robot begins."""
        speeds = initial.wheel_speeds(robot.wheel_names)
        return cls(initial.angular_velocity, initial.attitude, initial.velocity, speeds)


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


def free_floating(
    robot: Robot,
    motion: JointMotion,
    t: Float[np.ndarray, " n"],
    start: BaseState,
    tolerance: float = 1e-9,
) -> FreeFloating:
    """How the free-floating robot moves while its joints do as commanded.

    It starts at `t[0]`, s, with its nominal inertia; the tolerance is of the attitude,
    rad.

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

    x_WB, law, error, _ = float_attitude(law_at, t, h_cm, start.attitude, tolerance)
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
