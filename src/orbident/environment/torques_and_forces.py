"""Torques and forces that depend on time, and on how the base turns.

    constant torque            tau = e_k                    inertial axes
    torque fixed to the base   tau = R_WB e_k
    slow torque                tau = e_k f(t)
    the same on the base       tau = R_WB e_k f(t)
    wheel losing speed unseen  tau = d/dt (R_WB a_k l),  dl/dt = f(t)
    leak                       F = R_WB e_k,   tau = R_WB e_k
    push for a short time d    tau = e_k p,  b = e_k p      p = cos(m pi s / d) / d

What is slow is a Gaussian process of the size `s` beside its mean, which hardly swings
faster than its shortest time `d`, as its spectrum at `1 / d` is `e^-2` of the largest,

    cov(f(t), f(t')) = s^2 exp(-(t - t')^2 / (2 l^2)),    l = d / pi

A flight draws what is slow, cov(tau(t), tau(t + s)) = std^2 exp(-abs(s) / T), and its
pushes are forces at S, constant for a while in base axes.

White torque and force of the density `q`, by which momentum walks at random, are waves
whose sizes are independent,

    tau(t) = c_0 sqrt(1/T) + sum_m c_m sqrt(2/T) cos(m pi t / T),   c_m ~ N(0, q^2)

Their integral is a random walk with the deviation `q sqrt(t)` (the cosines are
orthonormal; Karhunen 1947). The first `WAVES` of them leave out a part of
`1 / (pi^2 WAVES)` of its variance. Such a force acts through the system CM.

Noise of a wheel's speed is such waves, of the density `q = s sqrt(dt)`, where samples
`dt` apart have the deviation `s`. So is what smoothing leaves of it, but for what is
faster. A fit that uses `qd_rw + n` has the momentum `R_WB a I n` too much, as if it had
come from outside.

What swings inside a robot that its file takes for rigid, such as a panel, a boom or
fuel, and faster than the robot moves, follows the base with a little more than its own
momentum. To first order in the square of the two frequencies' ratio that of the robot
is, in base axes, with its inertia `I` at the frequency `f`,

    h = D w + ... - K d2w/dt2,      K = I / (2 pi f)^2

So it acts on a rigid robot as the torque `d/dt (R_WB K d2w/dt2)`.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from orbident.environment.agent import AXES, Agent, Disturbance, Named, World
from orbident.environment.motion import (
    Load,
    RobotMotion,
    Vectors,
    by_step,
)
from orbident.environment.worlds import SHORTEST, radius_of_gyration, world_of
from orbident.model.kinematics import inertia
from orbident.model.rotations import rotate
from orbident.recordings.derivatives import HALF, derivatives

WAVES = 24
"""So a walk's deviation is wrong by a fifth of a percent."""

TIMES = 128
"""Times at which the covariance of what swings slowly is decomposed."""

SWINGS = 36.0
"""Times that it is correlated in a recording, at most, along all axes together: some 72
shapes."""

SMALL = 3e-3
"""Shapes that are smaller than this part of the largest are left out: they move the
momentum by less than sensors show."""

LEAST = 1e-9
"""SI: the first guess of a density where nothing moves."""


class ConstantTorque(Agent):
    """The same torque all the time."""

    group = "torque"
    words = "a constant torque acts, inertial axes"
    alike = ("base_torque", "wheel_loss")

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """A moment on the base."""
        if world.environment.torque:
            yield motion.load(moment=motion.always(world.environment.torque))

    def torques(self, motion: RobotMotion) -> Named:
        """About each axis about which momentum is conserved."""
        for k in motion.robot.conserved_axes[0]:
            yield AXES[k], motion.always(np.eye(3)[k])


class VaryingTorque(ConstantTorque):
    """A torque that changes slowly."""

    group = "slow_torque"
    words = "a torque acts that changes slowly, inertial axes"
    alike = ("slow_base_torque", "wheel_loss")
    mean = ConstantTorque.group
    slow = True

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """A moment on the base."""
        if self.group in world.drawn:
            yield motion.load(moment=world.drawn[self.group](motion.t))

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Each of its shapes about all axes."""
        return _slowly(self, motion, [*self.torques(motion)])


class BaseTorque(Agent):
    """A torque that turns with the base."""

    group = "base_torque"
    words = "a torque acts that turns with the base, base axes"
    alike = ("torque", "wheel_loss")
    needs = "a robot whose motion is spatial"

    def torques(self, motion: RobotMotion) -> Named:
        """About each axis of the base."""
        for k, axis in enumerate(AXES if motion.robot.motion == "spatial" else ""):
            yield axis, motion.R_WB[:, :, k]


class VaryingBaseTorque(BaseTorque):
    """A torque that turns with the base and changes slowly."""

    group = "slow_base_torque"
    words = "a torque acts that turns with the base and changes slowly, base axes"
    alike = ("slow_torque", "wheel_loss")
    mean = BaseTorque.group
    slow = True

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """All of its shapes about each axis."""
        for each in self.torques(motion):
            yield from _slowly(self, motion, [each])


class WheelLoss(Agent):
    """A wheel that slows down unseen gives its momentum to the rest of the robot.

    About the vertical of a table a loss and a torque are the same.
    """

    group = "wheel_loss"
    words = "wheels lose momentum that their recorded speeds do not show"
    remedy = "see that wheel speeds were measured and not commanded only"
    alike = ("slow_torque", "slow_base_torque")
    needs = "a wheel, and a robot whose motion is spatial"
    slow = True

    def torques(self, motion: RobotMotion) -> Named:
        """A constant loss, and one that changes slowly, of each wheel."""
        wheels = motion.robot.wheels if motion.robot.motion == "spatial" else ()
        if not wheels:
            return
        shapes = slow_shapes(motion, self.group)
        rates = np.column_stack([np.ones(motion.t.size), shapes])
        lost = cumulative_simpson(rates, x=motion.t, axis=0, initial=0.0)
        for wheel in wheels:
            for m, (rate, loss) in enumerate(zip(rates.T, lost.T, strict=True)):
                turned = np.cross(motion.w, np.outer(loss, wheel.axis))
                torque = turned + np.outer(rate, wheel.axis)
                yield f"{wheel.name}.{m}", motion.in_inertial(torque)


class WheelNoise(Agent):
    """Tachometers' noise: wheels have other momentum than their speeds say."""

    group = "wheel speeds"
    unit = "rad/s/sqrt(Hz)"

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """The waves of each wheel's speed."""
        t, R_WB = motion.t[::2], motion.R_WB[::2]
        waves = _waves(t, motion.speed_waves)
        for wheel, std in zip(motion.robot.wheels, motion.speed_noise, strict=False):
            for m, wave in enumerate(waves.T if std else ()):
                h = rotate(R_WB, np.outer(wave, wheel.inertia * wheel.axis))
                # That at the first row is there as soon as the second.
                h[0] = 0.0
                torque = np.diff(h, axis=0) / np.diff(t)[:, None]
                steps = np.repeat(torque[:, None], 3, axis=1)
                effect = motion.nothing._replace(torque=steps)
                yield self.column(f"{wheel.name}.{m}", effect)._replace(std=std)


class ForceAtS(Agent):
    """A force on the base at S: a fit sees a pull, and torques."""

    group = "force"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """What is constant of it, and what is drawn; inertial axes."""
        if world.environment.force:
            yield motion.load(force=motion.always(world.environment.force))
        if "slow_force" in world.drawn:
            yield motion.load(force=world.drawn["slow_force"](motion.t))


class Leak(Agent):
    """What leaves by a hole in the base pushes it: a force and its moment about S.

    Along the base's axes both stay as they are. It is flown as a push that lasts.
    """

    group = "leak"
    words = "a valve or a vent that leaks pushes the base, base axes"
    remedy = "see that all valves shut and nothing is vented"
    needs = "position or velocity of S"
    unit = "N"

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """The force along each axis of the base, and the moment about each."""
        turning, moving = motion.robot.conserved_axes if motion.S else ((), ())
        arm = radius_of_gyration(motion.robot)
        for k in moving:
            force = by_step(motion.R_WB[:, :, k])
            yield self.column(f"force.{AXES[k]}", motion.nothing._replace(force=force))
        for k in turning:
            effect = motion.turning(motion.R_WB[:, :, k])
            moment = self.column(f"moment.{AXES[k]}", effect, "N m")
            yield moment._replace(std=arm)


class Push(Agent):
    """What acts for a short time, which is not tested for but looked for."""

    group = "push"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """Forces on the base, each on or off all through a step."""
        R_WB, middle = by_step(motion.R_WB), by_step(motion.t)[:, 1]
        for burst in world.environment.bursts:
            on = (burst.start <= middle) & (middle < burst.start + burst.duration)
            force = rotate(R_WB, on[:, None, None] * np.array(burst.force))
            yield motion.load()._replace(force=force)

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """What it adds to both momenta in all, and how early or late."""
        if motion.pushed is None:
            return
        begin, end = motion.pushed
        turning, moving = motion.robot.conserved_axes
        s = by_step(motion.t - begin)
        during = (s[:, :1] >= 0) & (s[:, 2:] <= end - begin)
        for m in (0, 1):
            shape = during * np.cos(m * np.pi * s / (end - begin)) / (end - begin)
            for k in turning:
                torque = shape[..., None] * np.eye(3)[k]
                effect = motion.nothing._replace(torque=torque)
                yield self.column(f"turning.{AXES[k]}.{m}", effect, "N m s")
            for k in moving if motion.S else ():
                push = shape[..., None] * np.eye(3)[k]
                effect = motion.nothing._replace(push=push)
                yield self.column(f"moving.{AXES[k]}.{m}", effect, "m/s")


class TorqueWalk(Agent):
    """A white torque, where it is declared or asked for."""

    group = "torque_walk"
    words = "torques act that change at random: angular momentum walks"
    unit = "N m/sqrt(Hz)"
    density = "torque"

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Its waves about each axis about which momentum is conserved."""
        if self.group in motion.robot.said_to_act:
            axes = motion.robot.conserved_axes[0]
            D = inertia(motion.robot, motion.q[:1]).D[0]
            std = _density(self, motion, float(np.trace(D)), motion.w)
            for name, wave in _white(motion, axes):
                effect = motion.nothing._replace(torque=by_step(wave))
                yield self.column(name, effect)._replace(std=std)


class ForceWalk(Agent):
    """A white force, where it is declared or asked for."""

    group = "force_walk"
    words = "forces act that change at random: linear momentum walks"
    needs = "position or velocity of S"
    unit = "N/sqrt(Hz)"
    density = "force"

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Its waves along each axis along which momentum is conserved."""
        robot = motion.robot
        if self.group in robot.said_to_act and motion.S:
            std = _density(self, motion, robot.mass, motion.S.v)
            for name, wave in _white(motion, robot.conserved_axes[1]):
                effect = motion.nothing._replace(push=by_step(wave / robot.mass))
                yield self.column(name, effect)._replace(std=std)


def _slowly(
    agent: Agent, motion: RobotMotion, torques: Sequence[tuple[str, Vectors]]
) -> Iterator[Disturbance]:
    for m, shape in enumerate(slow_shapes(motion, agent.group).T, start=1):
        for name, x in torques:
            yield agent.column(f"{name}.{m}", motion.turning(x * shape[:, None]))


def slow_shapes(motion: RobotMotion, group: str) -> Float[np.ndarray, "nodes shapes"]:
    """What swings slowly, as a sum of shapes whose sizes are independent and alike.

    With the covariance `K` at some times, `V` and `L` its eigenvectors and values, they
    are `K(t, times) V L^-1/2` (Karhunen 1947), as far as they are large.
    """
    allowed = motion.allowed.get(group)
    shortest = allowed.shortest if allowed else None
    shortest = shortest or SHORTEST[world_of(motion.robot)]
    start, end = motion.t[0], motion.t[-1]
    # With more shapes beside thrusters a slow torque takes the place of their thrust,
    # and a robot seems to have a twentieth of its mass.
    alone = not motion.robot.thrusters
    each = SWINGS / (len(motion.robot.conserved_axes[0]) if alone else 3)
    lasts = max(shortest / np.pi, (end - start) / each)
    times = np.linspace(start, end, TIMES)
    K = _covariance(times, times, lasts)
    values, V = np.linalg.eigh(K)
    large = np.flatnonzero(values > SMALL**2 * values[-1])[::-1]
    return _covariance(motion.t, times, lasts) @ V[:, large] / np.sqrt(values[large])


def _covariance(t: np.ndarray, s: np.ndarray, lasts: float) -> np.ndarray:
    return np.exp(-(((t[:, None] - s) / lasts) ** 2) / 2)


def _white(motion: RobotMotion, axes: Sequence[int]) -> Named:
    for m, wave in enumerate(_waves(motion.t, WAVES).T):
        for k in axes:
            yield f"{AXES[k]}.{m}", wave[:, None] * np.eye(3)[k]


def _waves(t: Float[np.ndarray, " n"], last: int) -> Float[np.ndarray, "n waves"]:
    """Orthonormal cosines of up to so many half periods."""
    m, T = np.arange(last + 1), t[-1] - t[0]
    return np.sqrt(np.where(m, 2, 1) / T) * np.cos(m * np.pi * (t[:, None] - t[0]) / T)


def _density(agent: Agent, motion: RobotMotion, mass: float, v: Vectors) -> float:
    """That declared, or so much that it could have moved the base as it moved."""
    declared = getattr(motion.robot.momentum_walk, agent.density)
    root = np.sqrt(motion.t[-1] - motion.t[0])
    return declared or max(mass * float(np.sqrt(np.mean(v**2))) / root, LEAST)


class OnSprings(Agent):
    """Something on springs, of which the momentum is `K d2w/dt2` more."""

    group = "on_springs"
    words = (
        "something on a spring swings in the robot, which its file takes for rigid (a "
        "panel, a boom, fuel, a flexible joint)"
    )
    remedy = "declare what swings as a passive joint"
    needs = "some 20 rows"
    unit = "kg m^2 s^2"

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Each entry of the symmetric matrix."""
        turning = motion.w if motion.predicted_w is None else motion.predicted_w
        t, w = motion.t[::2], turning[::2]
        if t.size <= 2 * HALF:
            return
        _, bent = derivatives(t, w)
        axes = motion.robot.conserved_axes[0]
        for i in axes:
            for k in axes[axes.index(i) :]:
                K = np.zeros((3, 3))
                K[i, k] = K[k, i] = 1.0
                momentum = rotate(motion.R_WB[::2], bent @ K)
                torque = CubicSpline(t, momentum)(motion.t, 1)
                name = f"{AXES[i]}{AXES[k]}"
                yield self.column(name, motion.turning(torque), positive=i == k)
