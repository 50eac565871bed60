"""Parts of the base that its robot file takes for rigid, for MuJoCo to fly."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import mujoco
import numpy as np
from mujoco_model import give_inertia

from orbident.robot.description import Joint, Robot
from orbident.robot.parameters import (
    from_mass_com_inertia,
    inertia_about_com,
    transformed,
)
from orbident.trajectories.trajectory import Trajectory

DAMPING = 0.005
"""Of springs, over critical damping."""


class Base(NamedTuple):
    """How large a base is."""

    mass: float
    com: np.ndarray
    """m, from S."""
    radius: float
    """Of gyration about z, m."""

    @classmethod
    def of(cls, robot: Robot) -> "Base":
        mass = robot.theta[0, 0]
        about_z = inertia_about_com(robot.theta[0])[2, 2]
        return cls(mass, robot.theta[0, 1:4] / mass, float(np.sqrt(about_z / mass)))


class Part(NamedTuple):
    """A body that the base carries, in axes of the base."""

    name: str
    place: np.ndarray
    """Of its joint from S, m."""
    mass: float
    com: np.ndarray
    """From its joint, m."""
    inertia: np.ndarray
    """About its CM, kg m^2."""

    @property
    def theta(self) -> np.ndarray:
        return from_mass_com_inertia(self.mass, self.com, self.inertia)

    def about(self, axis: np.ndarray) -> float:
        """Moment of inertia about an axis through the joint, kg m^2."""
        across = np.cross(axis, self.com)
        return float(axis @ self.inertia @ axis + self.mass * across @ across)


def plate(name: str, base: Base, share: float, side: float) -> Part:
    """A thin plate, 2.5 radii long, along the base's y from where the base ends."""
    length, mass = 2.5 * base.radius, share * base.mass
    along = np.array([0.0, side, 0.0])
    x, y, z = mass / 12 * (length * np.array([0.25, 1.0, 0.02])) ** 2
    return Part(
        name,
        base.com + 1.3 * base.radius * along,
        mass,
        length / 2 * along,
        np.diag([y + z, x + z, x + y]),
    )


def ball(name: str, base: Base, share: float, off: Sequence[float]) -> Part:
    """A round body; `off` is its place from the CM of the base, radii."""
    mass, radius = share * base.mass, 0.2 * base.radius
    place = base.com + base.radius * np.asarray(off)
    return Part(name, place, mass, np.zeros(3), 0.4 * mass * radius**2 * np.eye(3))


def without(robot: Robot, *parts: Part) -> Robot:
    """The robot less what its base carries."""
    theta = robot.theta.copy()
    for part in parts:
        theta[0] -= transformed(part.theta, np.eye(3), part.place)
    return replace(robot, theta=theta)


def on_springs(
    hz: float, *parts: tuple[Part, Sequence[np.ndarray]]
) -> Callable[[mujoco.MjSpec], None]:
    """Hinges about these axes; each swings so on a base that stands still."""

    def add(spec: mujoco.MjSpec) -> None:
        for part, axes in parts:
            body = spec.body("base").add_body(name=part.name, pos=part.place)
            give_inertia(body, part.theta)
            for k, axis in enumerate(axes):
                name, inertia = f"{part.name} {k}", part.about(axis)
                body.add_joint(name=name, axis=axis, **spring(hz, inertia))

    return add


def spring(hz: float, inertia: float) -> dict[str, float]:
    """Stiffness and damping of a hinge, N m/rad and N m s/rad."""
    rate = 2 * np.pi * hz
    return {"stiffness": rate**2 * inertia, "damping": 2 * DAMPING * rate * inertia}


def fixed(part: Part) -> Callable[[mujoco.MjSpec], None]:
    """A body of its own that does not move in the base."""

    def add(spec: mujoco.MjSpec) -> None:
        body = spec.body("base").add_body(name=part.name, pos=part.place)
        give_inertia(body, part.theta)

    return add


def driven(
    robot: Robot, part: Part, kind: Literal["revolute", "prismatic"], axis: np.ndarray
) -> Robot:
    """The robot with a joint that moves a part of its base."""
    less = without(robot, part)
    return replace(
        less,
        theta=np.vstack([less.theta, part.theta]),
        bodies=(*less.bodies, part.name),
        joints=(*less.joints, Joint(part.name, kind, 0, axis, np.eye(3), part.place)),
    )


def moving(name: str, rate: float, swing: float) -> Callable[[Trajectory], Trajectory]:
    """A joint beside those of a trajectory: `rate t + swing (1 - cos(w t))`.

    Args:
        name: of the joint.
        rate: rad/s or m/s.
        swing: at `w`, the trajectory's highest harmonic, rad or m.
    """

    def add(motion: Trajectory) -> Trajectory:
        harmonics, end = motion.b.shape[1], motion.duration
        w = 2 * np.pi * harmonics / end
        b = np.zeros(harmonics)
        b[-1] = swing * w
        return replace(
            motion,
            joints=(*motion.joints, name),
            a=np.vstack([motion.a, np.zeros(harmonics)]),
            b=np.vstack([motion.b, b]),
            start=np.vstack([motion.start, [0.0, rate, swing * w**2]]),
            end=np.vstack([motion.end, [rate * end, rate, swing * w**2]]),
        )

    return add
