"""What acts in an orbit.

    gravity gradient   F_i = m_i mu / R^3 (3 n n . r_i - r_i)
                       tau_i = 3 mu / R^3 n x I_i n
    air drag           F = -1/2 rho C A |v| v       v relative to the air
    sunlight           F = -P C A s                 s towards the sun
    dipole             tau = m x B

`n` is up, and body `i`, with the inertia `I_i` about its CM, is at `r_i` from the
system CM: the tide moves no CM. Together its moments are `3 mu / R^3 n x D n` (Hughes
1986).

To the fit air and light are a force along the flow or away from the sun, and moments:
at the point `p` of the base it has `p x F`, linear in `p |F|`.

Where Earth, air, sun and field are, as the base of a flying robot sees them.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from orbident.environment.agent import AXES, Agent, Disturbance, Named, World
from orbident.environment.motion import (
    Load,
    RobotMotion,
    Vectors,
    by_step,
    heavy_bodies,
)
from orbident.model.kinematics import inertia
from orbident.model.rotations import rotate, rotate_back
from orbident.orbits.earth import MU
from orbident.robot.parameters import inertia_about_com

SUNLIGHT = 4.54e-6
"""The pressure of light that is absorbed, at the Earth, N/m^2."""


class GravityGradient(Agent):
    """The tide of the Earth, of which nothing is unknown but the robot."""

    group = "gravity_gradient"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """A force and a moment on each body."""
        if not (world.environment.gravity_gradient and world.arc):
            return
        tide, n = _tide(world.arc.position(motion.t))
        r_cm = motion.to_cm(motion.robot.theta)
        for i, m, com in heavy_bodies(motion.robot):
            r = motion.in_inertial(motion.poses.arm(i, com)) - r_cm
            force = m * tide * (3 * np.sum(n * r, axis=1, keepdims=True) * n - r)
            R_Wi = motion.R_WB @ motion.poses.R[:, i]
            I_i = inertia_about_com(motion.robot.theta[i])
            I_n = rotate(R_Wi, rotate_back(R_Wi, n) @ I_i)
            yield motion.load(i, com, force, 3 * tide * np.cross(n, I_n))

    def moment(
        self, motion: RobotMotion, theta: Float[np.ndarray, "bodies 10"]
    ) -> Vectors:
        """All moments on these bodies, as the recorded `nadir` tells; inertial, N m."""
        tide, n = _tide(-motion.surroundings["nadir"])
        n = rotate_back(motion.R_WB, n)
        D = inertia(replace(motion.robot, theta=theta), motion.q).D
        return motion.in_inertial(3 * tide * np.cross(n, rotate(D, n)))


class _Across(Agent):
    """A torque across what a recording may show of the surroundings."""

    seen: ClassVar[str]
    """The name of what is shown."""
    sign: ClassVar[float] = 1.0

    def torques(self, motion: RobotMotion) -> Named:
        """By what is along each axis of the base."""
        if self.seen in motion.surroundings:
            across = self.sign * motion.surroundings[self.seen]
            for k in motion.robot.conserved_axes[0]:
                yield AXES[k], np.cross(motion.R_WB[:, :, k], across)


class _Blowing(_Across):
    """A force at the base's centre of pressure."""

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """The force has one sign, its moments have any."""
        if self.seen in motion.surroundings:
            along = by_step(self.sign * motion.surroundings[self.seen])
            effect = motion.nothing._replace(force=along)
            yield self.column("force", effect, "N", positive=True)
            yield from super().columns(motion)


class OrbitalDrag(_Blowing):
    """Drag of the thin air at the base's centre of pressure."""

    group = "air"
    words = "a force acts along the flow of the air"
    needs = "position or velocity of S, and flow.x, flow.y and flow.z"
    seen = "flow"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """With the square of the speed."""
        given = world.environment.air_drag
        if given and world.arc:
            v = world.arc.wind(motion.t)
            size = given.density * given.coefficient * given.area / 2
            force = -size * np.linalg.norm(v, axis=1, keepdims=True) * v
            yield _at_centre(given.centre, force, motion)


class SunlightPressure(_Blowing):
    """The pressure of the sun's light at the base's centre of pressure."""

    group = "sunlight"
    words = "a force acts away from the sun"
    needs = "position or velocity of S, and sun.x, sun.y and sun.z"
    seen, sign = "sun", -1.0

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """Where the Earth hides no part of the sun, the same all the time."""
        given = world.environment.solar_pressure
        if given:
            size = SUNLIGHT * given.coefficient * given.area
            force = -size * world.sun(motion.t)
            yield _at_centre(given.centre, force, motion)


class MagneticDipole(_Across):
    """A magnet in the base, on which the Earth's field has a torque."""

    group = "dipole"
    words = "a torque acts across the magnetic field, as on a magnet in the base"
    needs = "field.x, field.y and field.z"
    unit = "A m^2"
    seen = "field"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """A moment on the base."""
        if world.environment.dipole and world.arc:
            m = motion.R_WB @ np.array(world.environment.dipole)
            yield motion.load(moment=np.cross(m, world.arc.field(motion.t)))


def _tide(
    up: Float[np.ndarray, "nodes 3"],
) -> tuple[Float[np.ndarray, "nodes 1"], Float[np.ndarray, "nodes 3"]]:
    """`mu / R^3`, 1/s^2, and the direction, from the place as the Earth sees it, m."""
    R = np.linalg.norm(up, axis=1, keepdims=True)
    return MU / R**3, up / R


def _at_centre(centre: tuple[float, ...], force: Vectors, motion: RobotMotion) -> Load:
    """A force on the base, at a point in the frame of its link."""
    return motion.load(0, np.array(centre) - motion.robot.feature_point, force)


def seen_from_base(
    world: World, t: Float[np.ndarray, " rows"], R_WB: Float[np.ndarray, "rows 3 3"]
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns `nadir`, `flow`, `field` and `sun`, without noise.

    Args:
        world: perhaps with an orbit, or with the sun's direction.
        t: the times of the rows, s.
        R_WB: the attitude.
    """
    shown: dict[str, Vectors] = {}
    if world.arc is not None:
        wind = world.arc.wind(t)
        flow = -wind / np.linalg.norm(wind, axis=1, keepdims=True)
        shown |= {"nadir": -world.arc.position(t), "flow": flow}
        shown["field"] = world.arc.field(t)
    if world.environment.solar_pressure is not None:
        shown["sun"] = world.sun(t)
    return {
        f"{name}.{axis}": column
        for name, vectors in shown.items()
        for axis, column in zip(AXES, rotate_back(R_WB, vectors).T, strict=True)
    }
