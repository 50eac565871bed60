"""What acts on a robot from outside, as forces on MuJoCo's bodies."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, Protocol

import mujoco
import numpy as np
from leapfrog_orbit import EARTH_RATE, MU
from scipy.interpolate import CubicHermiteSpline

from orbident.robot.parameters import PER_BODY, from_mass_com_inertia

NOWHERE = np.zeros(3)

UNSIZED: Mapping[str, float] = MappingProxyType({})


class Stage(NamedTuple):
    """The robot in MuJoCo at one stage of a step."""

    model: mujoco.MjModel
    data: mujoco.MjData
    inside: float
    """Middle of the step, s: what goes on and off does so between steps."""

    def push(
        self,
        outside: np.ndarray,
        force: np.ndarray,
        torque: np.ndarray,
        body: str,
        at: np.ndarray = NOWHERE,
    ) -> None:
        """Add a force at a point of a body, and a torque, both in inertial axes.

        Args:
            outside: generalised forces, which are added to.
            force: N.
            torque: N m.
            body: its name.
            at: the point, m, in the body's axes from its joint.
        """
        k = self.model.body(body).id
        point = self.data.xpos[k] + self.turned(body, at)
        mujoco.mj_applyFT(self.model, self.data, force, torque, point, k, outside)

    def turned(self, body: str, vector: np.ndarray) -> np.ndarray:
        """A vector from a body's axes to inertial ones."""
        k = self.model.body(body).id
        return self.data.xmat[k].reshape(3, 3) @ vector


class Acts(Protocol):
    """Something from outside."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        """Add its generalised forces."""
        ...

    @property
    def group(self) -> str:
        """What a result calls it; empty for what happens at one time."""
        ...

    @property
    def sizes(self) -> Mapping[str, float]:
        """Its numbers, by the names of a result; those that are not there are zero."""
        ...


def _named(group: str, vector: np.ndarray) -> dict[str, float]:
    """The components that are not zero, by the names of a result."""
    parts = zip("xyz", vector, strict=True)
    return {f"{group}.{axis}": float(x) for axis, x in parts if x}


@dataclass(frozen=True, eq=False)
class Torque:
    """A constant torque, N m, in inertial axes or those of the base."""

    vector: np.ndarray
    axes: Literal["inertial", "base"] = "inertial"

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        on_base = self.axes == "base"
        torque = stage.turned("base", self.vector) if on_base else self.vector
        stage.push(outside, NOWHERE, torque, "base")

    @property
    def group(self) -> str:
        return "base_torque" if self.axes == "base" else "torque"

    @property
    def sizes(self) -> dict[str, float]:
        return _named(self.group, self.vector)


@dataclass(frozen=True, eq=False)
class Swell:
    """A torque that comes and goes as a sine, inertial axes.

    A result follows it by shapes of a random process; it is not made of these.
    """

    vector: np.ndarray
    """N m."""
    period: float
    """s."""
    phase: float

    def at(self, t: np.ndarray) -> np.ndarray:
        """The torque, N m, axes last."""
        return np.sin(2 * np.pi * t / self.period + self.phase)[:, None] * self.vector

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        (torque,) = self.at(np.array([stage.data.time]))
        stage.push(outside, NOWHERE, torque, "base")

    group = "slow_torque"
    sizes = UNSIZED


@dataclass(frozen=True, eq=False)
class Burst:
    """A push on the base for a short time."""

    at: float
    """s."""
    seconds: float
    force: np.ndarray
    """N, base axes."""
    point: np.ndarray
    """m, base axes."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        if self.at < stage.inside < self.at + self.seconds:
            force = stage.turned("base", self.force)
            stage.push(outside, force, NOWHERE, "base", self.point)

    group = "push"
    sizes = UNSIZED


@dataclass(frozen=True, eq=False)
class Film:
    """An air film brakes each body that has pads: `F = -c v`, `tau = -c_r w`."""

    pads: Mapping[str, np.ndarray]
    """Middle of each body's pads, m."""
    drag: Mapping[str, tuple[float, float]]
    """By body, N s/m and N m s."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        model, data = stage.model, stage.data
        for name, (c, c_r) in self.drag.items():
            k, pad = model.body(name).id, self.pads[name]
            point = data.xpos[k] + stage.turned(name, pad)
            linear, angular = np.zeros((2, 3, model.nv))
            mujoco.mj_jac(model, data, linear, angular, point, k)
            force, torque = -c * linear @ data.qvel, -c_r * angular @ data.qvel
            stage.push(outside, force, torque, name, pad)

    group = "drag"

    @property
    def sizes(self) -> dict[str, float]:
        return {
            **{f"drag.{body}": c for body, (c, _) in self.drag.items()},
            **{f"drag.{body}.turning": c_r for body, (_, c_r) in self.drag.items()},
        }


@dataclass(frozen=True, eq=False)
class Tilt:
    """A table that is not level: MuJoCo's gravity has a part along it."""

    pull: np.ndarray
    """m/s^2."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        stage.model.opt.gravity = self.pull

    group = "pull"

    @property
    def sizes(self) -> dict[str, float]:
        return _named("pull", self.pull)


@dataclass(frozen=True, eq=False)
class InOrbit:
    """The tide on every body, and the drag of the air on the base.

    The tide on a body is that of its second moments: the force on its mass elements is
    `T r dm`, `T = mu / R^3 (3 n n^T - 1)`, so the torque about its CM is the
    antisymmetric part of `T E`, `E` the integral of `r r^T dm`.
    """

    place: CubicHermiteSpline
    """From the middle of the Earth, m, over s."""
    drag: float
    """Half of density, area and coefficient, kg/m."""
    centre: np.ndarray
    """Of pressure, m, in the axes of the base, from S."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        model, data = stage.model, stage.data
        r, v = self.place(data.time), self.place(data.time, 1)
        R = np.linalg.norm(r)
        T = MU / R**3 * (3 * np.outer(r, r) / R**2 - np.eye(3))
        m, moments = model.body_mass[1:], model.body_inertia[1:]
        axes = data.ximat[1:].reshape(-1, 3, 3)
        second = moments.sum(axis=1, keepdims=True) / 2 - moments
        A = T @ ((axes * second[:, None]) @ axes.swapaxes(1, 2))
        cm = m @ data.xipos[1:] / m.sum()
        data.xfrc_applied[1:, :3] = m[:, None] * ((data.xipos[1:] - cm) @ T)
        data.xfrc_applied[1:, 3:] = np.stack(
            [A[:, 2, 1] - A[:, 1, 2], A[:, 0, 2] - A[:, 2, 0], A[:, 1, 0] - A[:, 0, 1]],
            axis=1,
        )
        wind = v - np.cross(EARTH_RATE, r)
        force = -self.drag * np.linalg.norm(wind) * wind
        stage.push(outside, force, NOWHERE, "base", self.centre)

    group = "air"
    sizes = UNSIZED


@dataclass(frozen=True, eq=False)
class Capture:
    """A link gets hold of a body at rest, which from then on is a part of it."""

    at: float
    """s."""
    body: str
    mass: float
    """kg."""
    com: np.ndarray
    """m, in the axes of the link."""
    inertia: np.ndarray
    """About its CM, kg m^2."""

    def __call__(self, stage: Stage, outside: np.ndarray) -> None:
        pass

    group = ""
    sizes = UNSIZED

    def onto(self, theta: np.ndarray, bodies: tuple[str, ...]) -> np.ndarray:
        """The parameters of all bodies with what was captured."""
        held = np.zeros((len(bodies), PER_BODY))
        held[bodies.index(self.body)] = from_mass_com_inertia(
            self.mass, self.com, self.inertia
        )
        return theta + held
