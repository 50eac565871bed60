"""The base's motion along joint motions that are tried, and gradients through it.

The same motion as `simulation.free_floating`, by RK4 on one grid of nodes and
mid-nodes, and with the nominal or another plausible inertia.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_trapezoid

from orbident import _core
from orbident.model.core_robot import Wheels, core_robot, wheels_of
from orbident.model.kinematics import Inertia, inertia, inertia_at, momentum_regressors
from orbident.model.minimal_sets import MinimalSets
from orbident.model.rotations import quaternion_matrix, rotate, rotate_back
from orbident.robot.description import Robot
from orbident.threads import processors
from orbident.trajectories.trajectory import InitialState

JointNodes = Float[np.ndarray, "nodes joints"]
"""Positions or rates of joints at the nodes of a motion; rad or m, and s."""
Standing = Float[np.ndarray, "joints 3"]
"""Position, rate and acceleration of each joint at an end, rad or m, and s."""

Rows = Float[np.ndarray, "n axes columns"]


@dataclass(frozen=True, eq=False)
class NodalMotion:
    """A motion at evenly spaced nodes, and what it shows; base axes."""

    craft: "Craft"
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    dt: float
    """s."""
    Y: Float[np.ndarray, "n h pi"]
    """`h` are the axes in which angular momentum is conserved."""
    W: Float[np.ndarray, "n v phi"]
    """`v` are the axes in which linear momentum is conserved."""
    w: Float[np.ndarray, "n 3"]
    """Base rate, rad/s."""
    x_WB: Float[np.ndarray, "n 4"]
    along: tuple[_core.RateLaws, JointNodes, JointNodes] | None = None
    """Laws of the base rate, and joints at nodes and mid-nodes, for gradients; only of
    a motion that `Craft.along` made."""

    @cached_property
    def R(self) -> Float[np.ndarray, "n 3 3"]:
        """`R_WB`."""
        return quaternion_matrix(self.x_WB)

    @cached_property
    def v_S(self) -> Float[np.ndarray, "n 3"]:
        """The velocity of S, inertial axes, m/s."""
        return self.craft.velocity + self._v_from_cm - self._v_from_cm[0]

    @property
    def r_S(self) -> Float[np.ndarray, "n 3"]:
        """From where S is at first, inertial axes, m."""
        t, r_cm = self.dt * np.arange(len(self.w)), rotate(self.R, self.r_cm)
        return np.outer(t, self.v_cm) + r_cm[0] - r_cm

    @property
    def v_cm(self) -> Float[np.ndarray, "3"]:
        """The velocity of the system CM, inertial axes, m/s."""
        return self.craft.velocity - self._v_from_cm[0]

    @cached_property
    def _v_from_cm(self) -> Float[np.ndarray, "n 3"]:
        return rotate(self.R, self.v_B)

    @cached_property
    def v_B(self) -> Float[np.ndarray, "n 3"]:
        """The velocity of S seen from the CM, base axes, m/s: `W phi` (Eq. 29)."""
        sets = self.craft.sets
        v = np.zeros_like(self.w)
        v[:, sets.regressors.velocity_axes] = self.W @ sets.phi(self.craft.robot.theta)
        return v

    @cached_property
    def qd_rw(self) -> Float[np.ndarray, "n wheels"]:
        """Wheel speeds relative to the base, rad/s."""
        wheels = self.craft.wheels
        return self.craft.spin - wheels.free * (self.w @ wheels.axes)

    @cached_property
    def E(self) -> Float[np.ndarray, "n 3 3"]:
        """`dw = E R_0^T dh_cm`, with `E = (D - D_free)^-1`; in the plane of z alone."""
        axes, wheels = self.craft.sets.regressors.momentum_axes, self.craft.wheels
        D = self._inertia.D - (wheels.A_rw * wheels.free) @ wheels.axes.T
        E, own = np.zeros_like(D), np.ix_(range(len(D)), axes, axes)
        E[own] = np.linalg.inv(D[own])
        return E

    @property
    def r_cm(self) -> Float[np.ndarray, "n 3"]:
        """Vector from S to the system CM, m."""
        return self._inertia.r_cm

    @cached_property
    def _inertia(self) -> Inertia:
        return inertia(self.craft.robot, self.q)


@dataclass(eq=False)
class Gradient:
    """The gradient of a scalar with respect to a motion; zero at first."""

    motion: NodalMotion
    Y: Float[np.ndarray, "n h pi"] = field(init=False)
    W: Float[np.ndarray, "n v phi"] = field(init=False)
    w: Float[np.ndarray, "n 3"] = field(init=False)
    q: Float[np.ndarray, "n joints"] = field(init=False)
    """Only what depends on `q` beside the others, as of `qd`."""
    qd: Float[np.ndarray, "n joints"] = field(init=False)
    R: Float[np.ndarray, "n 3 3"] = field(init=False)
    E: Float[np.ndarray, "n 3 3"] = field(init=False)
    r_cm: Float[np.ndarray, "n 3"] = field(init=False)

    def __post_init__(self) -> None:
        self.Y, self.W = np.zeros_like(self.motion.Y), np.zeros_like(self.motion.W)
        self.w, self.r_cm = np.zeros((2, len(self.motion.w), 3))
        self.q, self.qd = np.zeros((2, len(self.motion.q), self.motion.q.shape[1]))
        self.R, self.E = np.zeros((2, len(self.motion.w), 3, 3))

    def add_v_S(self, by: Float[np.ndarray, "n 3"]) -> None:
        """Adds the gradient, from that with respect to `motion.v_S`."""
        motion = self.motion
        self.R += by[:, :, None] * motion.v_B[:, None]
        self.add_v_B(rotate_back(motion.R, by))

    def add_v_B(self, by: Float[np.ndarray, "n 3"]) -> None:
        """Adds the gradient, from that with respect to `motion.v_B`."""
        sets, robot = self.motion.craft.sets, self.motion.craft.robot
        axes = list(sets.regressors.velocity_axes)
        self.W += by[:, axes, None] * sets.phi(robot.theta)

    @property
    def turn(self) -> Float[np.ndarray, "n 3"]:
        """Gradient with respect to a small rotation of the base, `dR = R [turn]x`."""
        return axial(np.swapaxes(self.motion.R, 1, 2) @ self.R)

    @property
    def D(self) -> Float[np.ndarray, "n 3 3"]:
        """Gradient with respect to `D`, by `dE = -E dD E`."""
        if not self.E.any():
            return self.E
        E_T = np.swapaxes(self.motion.E, 1, 2)
        return -(E_T @ self.E @ E_T)


def block(
    X: Float[np.ndarray, "n 3 3"], rows: tuple[int, ...], columns: tuple[int, ...]
) -> Float[np.ndarray, "n rows columns"]:
    """The part of each matrix with these rows and columns: a view.

    Axes in which momentum is conserved stand side by side.
    """
    return X[:, rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def axial(G: Float[np.ndarray, "n 3 3"]) -> Float[np.ndarray, "n 3"]:
    """The gradient with respect to `v`, from that with respect to `[v]x`."""
    return np.stack(
        [G[:, 2, 1] - G[:, 1, 2], G[:, 0, 2] - G[:, 2, 0], G[:, 1, 0] - G[:, 0, 1]],
        axis=1,
    )


def running_integral(X: Rows, dt: float) -> Rows:
    """The integral from the first node on, by the trapezoidal rule."""
    return cumulative_trapezoid(X, dx=dt, axis=0, initial=0)


def running_integral_transposed(G: Rows, dt: float) -> Rows:
    """The gradient with respect to `X`, from that with respect to its integral."""
    after = np.cumsum(G[:0:-1], axis=0)[::-1]
    none = np.zeros_like(G[:1])
    return dt / 2 * (np.concatenate([after, none]) + np.concatenate([none, after]))


@dataclass(frozen=True, eq=False)
class Craft:
    """A robot with one plausible inertia, floating with a constant momentum."""

    robot: Robot
    """The robot with that inertia."""
    sets: MinimalSets
    wheels: Wheels
    spin: Float[np.ndarray, " wheels"]
    """Speeds of the wheels where the base does not turn, rad/s."""
    h_cm: Float[np.ndarray, "3"]
    """Inertial axes, N m s."""
    velocity: Float[np.ndarray, "3"]
    """Of S at the start, inertial axes, m/s."""
    floating: _core.Floating

    def along(self, q: JointNodes, qd: JointNodes, dt: float) -> NodalMotion:
        """Eqs. 2, 17, 18 along a joint motion, given at nodes and mid-nodes in turn.

        Positions are in rad or m; `dt`, from node to node, in s.
        """
        w, x_WB, laws = _core.float_along(self.floating, q, qd, dt, processors())
        return replace(self.seen(q[::2], qd[::2], w, x_WB, dt), along=(laws, q, qd))

    def seen(
        self,
        q: Float[np.ndarray, "n joints"],
        qd: Float[np.ndarray, "n joints"],
        w: Float[np.ndarray, "n 3"],
        x_WB: Float[np.ndarray, "n 4"],
        dt: float,
    ) -> NodalMotion:
        """What a motion shows, however it was found."""
        Y, W = self.sets.regressors(q, qd, w)
        return NodalMotion(self, q, qd, dt, Y, W, w, x_WB)

    def pull_back(self, f: Gradient) -> tuple[JointNodes, JointNodes]:
        """The gradient with respect to `q` and `qd` at nodes and mid-nodes."""
        motion, regressors = f.motion, self.sets.regressors
        assert motion.along is not None
        laws, q, qd = motion.along
        by_q, by_qd = _core.float_gradient(
            self.floating,
            laws,
            regressors.core,
            q,
            qd,
            motion.dt,
            motion.w,
            motion.x_WB,
            _all_axes(f.Y, regressors.momentum_axes),
            _all_axes(f.W, regressors.velocity_axes),
            f.D,
            f.r_cm,
            f.w,
            f.turn,
            processors(),
        )
        by_q[::2] += f.q
        by_qd[::2] += f.qd
        return by_q, by_qd


def craft_of(
    robot: Robot,
    sets: MinimalSets,
    initial: InitialState,
    start: Standing,
    at_rest: bool,
) -> Craft:
    """The robot as it starts a manoeuvre.

    Its `theta` decides. Where all was at rest before the wheels spun up, `h_cm = 0`
    whatever the inertia, and that gives `w` at the start.
    """
    wheels = wheels_of(robot)
    speeds = initial.wheel_speeds(robot.wheel_names)
    w, h_cm = momentum_at_start(robot, initial, start, at_rest)
    spin = speeds + wheels.free * (wheels.axes.T @ w)
    floating = _core.Floating(
        robot=core_robot(robot),
        planar=robot.motion == "planar",
        D_free=(wheels.A_rw * wheels.free) @ wheels.axes.T,
        h_rw=wheels.A_rw @ spin,
        h_cm=h_cm,
        x_WB=np.array(initial.attitude),
    )
    return Craft(robot, sets, wheels, spin, h_cm, initial.velocity, floating)


def _all_axes(
    X: Float[np.ndarray, "n some m"], axes: tuple[int, ...]
) -> Float[np.ndarray, "n 3 m"]:
    if len(axes) == 3:
        return X
    full = np.zeros((X.shape[0], 3, X.shape[2]))
    full[:, axes] = X
    return full


WHEEL_SPEED = 200.0
"""rad/s, some 1900 turns a minute: half of what reaction wheels are made for."""

TUMBLE = (0.01, 0.03, 0.025)
"""rad/s, base axes: Table 3's."""

NO_MOMENTUM = 1e-6
"""Share of the wheels' momentum: more than rounding in a file, less than tumbling."""


def usual_initial(
    robot: Robot,
    start: Standing,
    wheel_speed: float | None = None,
    at_rest: bool | None = None,
) -> InitialState:
    """A state of slow tumbling, all wheels spinning; on a table, spun up from rest.

    Args:
        robot: whose wheels and inertia count.
        start: position, velocity and acceleration of each joint.
        wheel_speed: of all wheels, rad/s; `WHEEL_SPEED` where it is not said.
        at_rest: whether all was at rest before the wheels spun up, on a table or not.
    """
    planar = robot.motion == "planar"
    speed = WHEEL_SPEED if wheel_speed is None else wheel_speed
    speeds = dict.fromkeys(robot.wheel_names, speed)
    if at_rest or (at_rest is None and planar):
        return spun_up(robot, speeds, start)
    tumble = np.array([0.0, 0.0, TUMBLE[2]] if planar else TUMBLE)
    return InitialState(tumble, wheel_speed=speeds)


def spun_up(
    robot: Robot, wheel_speed: dict[str, float], start: Standing
) -> InitialState:
    """The state after the wheels spun up when all was at rest (Eq. 25).

    The wheels' speeds are relative to the base, rad/s.
    """
    initial = InitialState(wheel_speed=wheel_speed)
    w, _ = momentum_at_start(robot, initial, start, at_rest=True)
    # The CM stays where it is, so S moves where the base turns.
    q, qd, _ = start.T[:, None]
    p = momentum_regressors(robot, q, qd, w[None]).P[0] @ robot.theta.ravel()
    return InitialState(w, velocity=-p / robot.mass, wheel_speed=wheel_speed)


def was_at_rest(robot: Robot, initial: InitialState, start: Standing) -> bool:
    """Whether the momentum is zero although wheels spin: `h_cm = 0` (Eqs. 25, 26)."""
    _, h_cm = momentum_at_start(robot, initial, start, at_rest=False)
    size = np.linalg.norm(_wheels_momentum(robot, initial))
    return bool(size > 0 and np.linalg.norm(h_cm) <= NO_MOMENTUM * size)


def momentum_at_start(
    robot: Robot, initial: InitialState, start: Standing, at_rest: bool
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """The base rate, and `h_cm = R_0 (D w + D_q qd + h_rw)` in inertial axes.

    Where all was at rest before the wheels spun up, `h_cm = 0`, and the base rate is
    `-D^-1 (D_q qd + h_rw)`, whatever the initial state says of it.
    """
    at = inertia_at(robot, start[:, 0])
    h = at.D_q @ start[:, 1] + _wheels_momentum(robot, initial)
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    if at_rest:
        w = np.zeros(3)
        w[axes] = -np.linalg.solve(at.D[np.ix_(axes, axes)], h[axes])
        return w, np.zeros(3)
    h_cm = quaternion_matrix(initial.attitude) @ (at.D @ initial.angular_velocity + h)
    if robot.motion == "planar":
        h_cm[:2] = 0.0
    return initial.angular_velocity, h_cm


def nutation(robot: Robot, initial: InitialState, start: Standing) -> float:
    """A bound of how fast the base tumbles and nutates at the start, rad/s.

    In the plane nothing nutates, and the attitude is an integral over time.
    """
    if robot.motion == "planar":
        return 0.0
    D = np.linalg.eigvalsh(inertia_at(robot, start[:, 0]).D)
    w = float(np.linalg.norm(initial.angular_velocity))
    h_rw = float(np.linalg.norm(_wheels_momentum(robot, initial)))
    return w + (float(D[-1]) * w + h_rw) / float(D[0])


def _wheels_momentum(robot: Robot, initial: InitialState) -> Float[np.ndarray, "3"]:
    """`h_rw`, in the axes in which momentum is conserved, base axes."""
    h_rw = wheels_of(robot).A_rw @ initial.wheel_speeds(robot.wheel_names)
    if robot.motion == "planar":
        h_rw[:2] = 0.0
    return h_rw
