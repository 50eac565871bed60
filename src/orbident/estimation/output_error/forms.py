"""What may act on a robot from outside, each disturbance at size one.

    constant torque            tau = e_k                    inertial axes
    torque fixed to the base   tau = R_WB e_k
    slow torque                tau = e_k cos(m pi t / T)    m = 1 .. 6
    the same on the base       tau = R_WB e_k cos(m pi t / T)
    constant pull              a = e_k                      such as a table's tilt
    uneven table               a = E_k (r_cm - r_cm(0))     E_k symmetric
    film drag of a body        F = -v_P,  or  tau = -w
    air drag                   F = d,  tau = R_WB e_k x d   d along the flow
    sunlight                   F = -d, tau = R_WB e_k x d   d towards the sun
    magnet in the base         tau = R_WB e_k x B
    wheel losing speed unseen  tau = d/dt (R_WB a_k l),  dl/dt = cos(m pi t / T)
    push for a short time d    tau = e_k p,  b = e_k p     p = cos(m pi s / d) / d
    known wrench               as recorded
    known torquer              tau = R_WB m x B       m as recorded

Torques are about S, accelerations `a` those of all parts alike.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.followed import Followed, by_step
from orbident.model.inertia import inertia
from orbident.model.minimal_sets import conserved_axes
from orbident.orbits.earth import MU

AXES = "xyz"

SLOW = ("slow_torque", "slow_base_torque", "wheel_loss")
"""Groups of what changes slowly."""

STEADY = {"slow_torque": "torque", "slow_base_torque": "base_torque"}
"""What has a mean beside, by groups of what changes slowly."""

FILM = "drag"
"""The group that acts where a robot has pads."""

PUSH = "push"
"""The group of what acts for a short time, which is not tested for but looked for."""

WAVES = 6
"""Half waves in a recording of what changes slowly, at most."""

IN_WORDS: dict[str, str] = {
    "torque": "a constant torque acts, inertial axes",
    "slow_torque": "a torque acts that changes slowly, inertial axes",
    "base_torque": "a torque acts that turns with the base, base axes",
    "slow_base_torque": "a torque acts that turns with the base and changes slowly, "
    "base axes",
    "wheel_loss": "wheels lose momentum that their recorded speeds do not show",
    "pull": "all parts are pulled alike, as on a table that is not level",
    "uneven": "the pull changes from place to place, as on an uneven table",
    "drag": "drag acts, as of an air film",
    "air": "a force acts along the flow of the air",
    "sunlight": "a force acts away from the sun",
    "dipole": "a torque acts across the magnetic field, as on a magnet in the base",
    "torque_walk": "torques act that change at random: angular momentum walks",
    "force_walk": "forces act that change at random: linear momentum walks",
}
"""What acts, by the name of its group."""

NEEDS: dict[str, str] = {
    "base_torque": "a robot whose motion is spatial",
    "slow_base_torque": "a robot whose motion is spatial",
    "wheel_loss": "a wheel, and a robot whose motion is spatial",
    "pull": "position or velocity of S",
    "uneven": "position or velocity of S, and a robot whose motion is planar",
    "drag": "position or velocity of S, and a robot whose motion is planar",
    "air": "position or velocity of S, and flow.x, flow.y and flow.z",
    "sunlight": "position or velocity of S, and sun.x, sun.y and sun.z",
    "dipole": "field.x, field.y and field.z",
    "force_walk": "position or velocity of S",
}
"""Without which nothing shows of a group."""


class Effect(NamedTuple):
    """What acts at a row, half-way and, until then, at the next; inertial axes."""

    force: Float[np.ndarray, "steps 3 3"]
    """N."""
    torque: Float[np.ndarray, "steps 3 3"]
    """About S, N m."""
    pull: Float[np.ndarray, "steps 3 3"]
    """Acceleration of all parts that an accelerometer does not feel, m/s^2."""
    push: Float[np.ndarray, "steps 3 3"]
    """The same of all parts that it feels, m/s^2."""

    @property
    def accelerates(self) -> bool:
        """Whether the system CM is accelerated by it, or only turned."""
        return any(x.any() for x in (self.force, self.pull, self.push))

    def times(self, size: float) -> "Effect":
        """So many times as large."""
        return Effect(*(size * part for part in self))

    def plus(self, other: "Effect") -> "Effect":
        """Both together."""
        return Effect(*(a + b for a, b in zip(self, other, strict=True)))


class Disturbance(NamedTuple):
    """One number that says how large something from outside is."""

    name: str
    """Such as `tilt.x`."""
    group: str
    """What is there or not there together."""
    unit: str
    effect: Effect
    positive: bool = False
    """Whether less than zero is impossible."""
    acts: float = 0.0
    """Its size where the number is zero: 1 for what was recorded."""
    std: float = 0.0
    """Its deviation beforehand: zero for recorded thrust is exact, else unknown."""


def disturbances(followed: Followed) -> Iterator[Disturbance]:
    """All that may act on this robot, and shows in what was recorded.

    Args:
        followed: the motion that was measured.
    """
    if followed.samples.pushed:
        yield from _push(followed)
    yield from _torques(followed)
    yield from _in_orbit(followed)
    if followed.tracked:
        yield from _pulls(followed)
        if followed.robot.motion == "planar":
            yield from _uneven(followed)
            yield from _drag(followed)


def recorded(followed: Followed) -> Iterator[Disturbance]:
    """The wrenches that were recorded, known up to a gain each.

    Args:
        followed: the motion that was measured.
    """
    none = nothing(followed)

    def inertial(
        base_axes: Float[np.ndarray, "rows 3"],
    ) -> Float[np.ndarray, "steps 3 3"]:
        """It holds in base axes, and turns with these, from a row until the next."""
        return np.einsum(
            "skij,sj->ski", by_step(followed.R_WB), base_axes[: len(none.force)]
        )

    for each in followed.wrenches:
        name = f"{each.name}.gain"
        torque = inertial(each.torque)
        if each.dipole.any():
            field = by_step(followed.surroundings["field"])
            torque = torque + np.cross(inertial(each.dipole), field)
        effect = none._replace(force=inertial(each.force), torque=torque)
        yield Disturbance(name, name, "1", effect, acts=1.0, std=each.gain)


def nothing(followed: Followed) -> Effect:
    """Nothing acts."""
    zero = np.zeros((followed.t.size // 2, 3, 3))
    return Effect(zero, zero, zero, zero)


def _torques(followed: Followed) -> Iterator[Disturbance]:
    turning, _ = conserved_axes(followed.robot)
    none = nothing(followed)
    for name, vector in _steady(followed, turning):
        effect = none._replace(torque=by_step(vector))
        yield Disturbance(f"torque.{name}", "torque", "N m", effect)
    for name, vector in _slow(followed, turning):
        effect = none._replace(torque=by_step(vector))
        yield Disturbance(f"slow_torque.{name}", "slow_torque", "N m", effect)
    if followed.robot.motion == "spatial":
        yield from _on_the_base(followed)
        yield from _lost_by_wheels(followed)


def _on_the_base(followed: Followed) -> Iterator[Disturbance]:
    none = nothing(followed)
    for k, axis in enumerate(AXES):
        torque = followed.R_WB[:, :, k]
        effect = none._replace(torque=by_step(torque))
        yield Disturbance(f"base_torque.{axis}", "base_torque", "N m", effect)
        for m, wave in _waves(followed):
            effect = none._replace(torque=by_step(torque * wave))
            name = f"slow_base_torque.{axis}.{m}"
            yield Disturbance(name, "slow_base_torque", "N m", effect)


def _lost_by_wheels(followed: Followed) -> Iterator[Disturbance]:
    """A wheel that slows down unseen gives its momentum to the rest of the robot.

    About the vertical of a table a loss and a torque are the same.
    """
    none = nothing(followed)
    t = followed.t[:, None] - followed.t[0]
    for wheel in followed.robot.wheels:
        for m, rate in ((0, np.ones_like(t)), *_waves(followed)):
            k = m * np.pi / t[-1]
            lost = np.sin(k * t) / k if m else t
            torque = np.cross(followed.w, wheel.axis * lost) + wheel.axis * rate
            effect = none._replace(torque=by_step(followed.in_inertial(torque)))
            name = f"wheel_loss.{wheel.name}.{m}"
            yield Disturbance(name, "wheel_loss", "N m", effect)


def _in_orbit(followed: Followed) -> Iterator[Disturbance]:
    """Drag and light act somewhere on the base: `p x F` is linear in `p |F|`."""
    none, around = nothing(followed), followed.surroundings
    for name, group, sign in (("flow", "air", 1.0), ("sun", "sunlight", -1.0)):
        if name in around:
            along = sign * around[name]
            effect = none._replace(force=by_step(along))
            yield Disturbance(f"{group}.force", group, "N", effect, positive=True)
            yield from _moments(followed, group, "N m", along)
    if "field" in around:
        yield from _moments(followed, "dipole", "A m^2", around["field"])


def _moments(
    followed: Followed, group: str, unit: str, across: Float[np.ndarray, "nodes 3"]
) -> Iterator[Disturbance]:
    """Torques `R_WB e_k x across`, whose sizes are fixed to the base."""
    for k in conserved_axes(followed.robot)[0]:
        torque = np.cross(followed.R_WB[:, :, k], across)
        effect = nothing(followed)._replace(torque=by_step(torque))
        yield Disturbance(f"{group}.{AXES[k]}", group, unit, effect)


def gravity_gradient(
    followed: Followed, beta: Float[np.ndarray, " beta"]
) -> Float[np.ndarray, "nodes 3"]:
    """`3 mu / R^3 n x D n` (Hughes 1986), where the Earth is known; inertial, N m."""
    nadir = followed.surroundings.get("nadir")
    if nadir is None:
        return np.zeros((followed.t.size, 3))
    robot, R = followed.robot, np.linalg.norm(nadir, axis=1, keepdims=True)
    theta = (followed.sets.base.theta_of @ beta).reshape(robot.theta.shape)
    D = inertia(replace(robot, theta=theta), followed.q).D
    n = np.einsum("nji,nj->ni", followed.R_WB, nadir / R)
    tau = 3 * MU / R**3 * np.cross(n, np.einsum("nij,nj->ni", D, n))
    return followed.in_inertial(tau)


def _push(followed: Followed) -> Iterator[Disturbance]:
    """What it adds to both momenta from its begin to its end, and how early or late."""
    turning, moving = conserved_axes(followed.robot)
    t, none = followed.t, nothing(followed)
    assert followed.samples.pushed is not None
    begin, end = followed.samples.pushed
    s = by_step(t - begin)
    during = (s[:, :1] >= 0) & (s[:, 2:] <= end - begin)
    for m in (0, 1):
        shape = during * np.cos(m * np.pi * s / (end - begin)) / (end - begin)
        for k in turning:
            torque = shape[..., None] * np.eye(3)[k]
            yield Disturbance(
                f"push.turning.{AXES[k]}.{m}",
                PUSH,
                "N m s",
                none._replace(torque=torque),
            )
        for k in moving if followed.tracked else ():
            push = shape[..., None] * np.eye(3)[k]
            yield Disturbance(
                f"push.moving.{AXES[k]}.{m}", PUSH, "m/s", none._replace(push=push)
            )


def _pulls(followed: Followed) -> Iterator[Disturbance]:
    _, moving = conserved_axes(followed.robot)
    none = nothing(followed)
    for name, vector in _steady(followed, moving):
        yield Disturbance(
            f"pull.{name}", "pull", "m/s^2", none._replace(pull=by_step(vector))
        )


def _steady(
    followed: Followed, axes: Sequence[int]
) -> Iterator[tuple[str, Float[np.ndarray, "nodes 3"]]]:
    for k in axes:
        vector = np.zeros((followed.t.size, 3))
        vector[:, k] = 1.0
        yield AXES[k], vector


def _slow(
    followed: Followed, axes: Sequence[int]
) -> Iterator[tuple[str, Float[np.ndarray, "nodes 3"]]]:
    for m, wave in _waves(followed):
        for name, vector in _steady(followed, axes):
            yield f"{name}.{m}", vector * wave


def _waves(followed: Followed) -> Iterator[tuple[int, Float[np.ndarray, "nodes 1"]]]:
    """Whatever changes over a sixth of the recording, or more slowly."""
    t = followed.t[:, None] - followed.t[0]
    for m in range(1, WAVES + 1):
        yield m, np.cos(m * np.pi * t / t[-1])


def _uneven(followed: Followed) -> Iterator[Disturbance]:
    r = followed.nominal_cm.r - followed.nominal_cm.r[0]
    none = nothing(followed)
    for a, b in ((0, 0), (0, 1), (1, 1)):
        pull = np.zeros_like(r)
        pull[:, a] = r[:, b]
        if a != b:
            pull[:, b] = r[:, a]
        effect = none._replace(pull=by_step(pull))
        name = f"uneven.{AXES[a]}{AXES[b]}"
        yield Disturbance(name, "uneven", "1/s^2", effect)


def _drag(followed: Followed) -> Iterator[Disturbance]:
    """Drag of the pads under bodies: without any declared, of one below S."""
    robot = followed.robot
    none = nothing(followed)
    pads = robot.pads or {robot.bodies[0]: np.zeros(3)}
    for body, p in pads.items():
        k = robot.bodies.index(body)
        force = -followed.point(k, p).v * [1.0, 1.0, 0.0]
        arm = followed.in_inertial(followed.arm(k, p))
        pushed = none._replace(
            force=by_step(force), torque=by_step(np.cross(arm, force))
        )
        turned = none._replace(torque=by_step(-followed.rate(k)))
        for name, unit, effect in (
            (f"drag.{body}", "N s/m", pushed),
            (f"drag.{body}.turning", "N m s", turned),
        ):
            yield Disturbance(name, "drag", unit, effect, positive=True)
