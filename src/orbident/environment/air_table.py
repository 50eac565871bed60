"""A table that is neither level nor even, drag of its air film, and a hose.

    pull   F_i = m_i a(r_i),   a(r) = g theta + A r   each body, at its CM; A symmetric
    film   F = -c v_P,   tau = -c_r w_i               bodies with pads
    hose   F = -k r_S                                 the base

`theta` is how far the table falls along inertial x and y, and `r` is from the origin.
To the fit a level pull is `a = e_k`, in space too, and an uneven one
`a = E_k (r_cm - r_cm(0))`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from itertools import combinations_with_replacement
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from orbident.environment.agent import AXES, Agent, Disturbance, World
from orbident.environment.motion import (
    Load,
    RobotMotion,
    Vectors,
    by_step,
    heavy_bodies,
)
from orbident.environment.worlds import radius_of_gyration
from orbident.robot.units import STANDARD_GRAVITY
from orbident.trajectories.environment import Environment, Uneven

IN_PLANE = np.array([1.0, 1.0, 0.0])


class Pull(Agent, ABC):
    """What accelerates all parts by where they are, and no accelerometer feels."""

    key: ClassVar[str]
    """The environment's name of it."""
    unit = "m/s^2"

    @abstractmethod
    def at(self, environment: Environment, r: Vectors) -> Vectors:
        """The acceleration of what is at `r` (m), inertial axes, m/s^2."""

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """A force on each body, at its CM."""
        if getattr(world.environment, self.key) is None or motion.S is None:
            return
        for i, m, com in heavy_bodies(motion.robot):
            r = motion.S.r + motion.in_inertial(motion.poses.arm(i, com))
            yield motion.load(i, com, force=m * self.at(world.environment, r))

    def pulling(self, motion: RobotMotion, name: str, a: Vectors) -> Disturbance:
        """An acceleration of all parts."""
        return self.column(name, motion.nothing._replace(pull=by_step(a)))


class LevelPull(Pull):
    """A table that is not level."""

    group, key = "pull", "tilt"
    words = "all parts are pulled alike, as on a table that is not level"
    needs = "position or velocity of S"

    def at(self, environment: Environment, r: Vectors) -> Vectors:
        """The acceleration down the slope, which is the same everywhere, m/s^2."""
        fall = np.array([*(environment.tilt or (0.0, 0.0)), 0.0])
        return np.tile(STANDARD_GRAVITY * fall, (len(r), 1))

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Along each axis that momentum is conserved along."""
        for k in motion.robot.conserved_axes[1] if motion.S else ():
            yield self.pulling(motion, AXES[k], motion.always(np.eye(3)[k]))


class UnevenPull(Pull):
    """A table whose fall changes from place to place."""

    group = key = "uneven"
    words = "the pull changes from place to place, as on an uneven table"
    needs = "position or velocity of S, and a robot whose motion is planar"
    unit = "1/s^2"

    def at(self, environment: Environment, r: Vectors) -> Vectors:
        """Linear in the place."""
        uneven = environment.uneven or Uneven()
        A = np.array([[uneven.xx, uneven.xy], [uneven.xy, uneven.yy]])
        return np.pad(r[:, :2] @ A, ((0, 0), (0, 1)))

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Each entry of the symmetric matrix."""
        if motion.S is None or motion.robot.motion != "planar":
            return
        r = motion.S.r + motion.to_cm(motion.robot.theta)
        for a, b in combinations_with_replacement(range(2), 2):
            E = np.zeros((3, 3))
            E[a, b] = E[b, a] = 1.0
            pulled = self.pulling(motion, AXES[a] + AXES[b], (r - r[0]) @ E)
            yield pulled._replace(by_place=E)


class Hose(Agent):
    """A hose or a cable, which pulls S back."""

    group = "hose"
    words = "a hose or a cable pulls the base back"
    needs = UnevenPull.needs
    unit = "N/m"

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """To the origin of inertial axes."""
        if world.environment.hose and motion.S:
            yield self.pulled(motion, world.environment.hose)

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """To where S was at first: a steady pull is a number of its own."""
        if motion.S and motion.robot.motion == "planar":
            effect = motion.effect(self.pulled(motion, 1.0))
            yield self.column("stiffness", effect, positive=True)

    def pulled(self, motion: RobotMotion, stiffness: float) -> Load:
        """As by a spring, N/m."""
        assert motion.S is not None
        return motion.load(force=-stiffness * motion.S.r * IN_PLANE)


class FilmDrag(Agent):
    """Drag of the air film under bodies."""

    group = "drag"
    words = "drag acts, as of an air film"
    needs = UnevenPull.needs

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """At the pads of each body."""
        for body, film in world.environment.film_drag.items():
            yield self.film(motion, body, motion.robot.pads[body], film.c, film.c_r)

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """Of the pads under bodies: without any declared, of one below S."""
        robot = motion.robot
        if motion.S is None or robot.motion != "planar":
            return
        for body, pad in (robot.pads or {robot.bodies[0]: np.zeros(3)}).items():
            pushed = motion.effect(self.film(motion, body, pad, 1.0, 0.0))
            turned = motion.effect(self.film(motion, body, pad, 0.0, 1.0))
            yield self.column(body, pushed, "N s/m", positive=True)
            spun = self.column(f"{body}.turning", turned, "N m s", positive=True)
            yield spun._replace(std=radius_of_gyration(robot) ** 2)

    def film(
        self,
        motion: RobotMotion,
        body: str,
        pad: Float[np.ndarray, "3"],
        c: float,
        c_r: float,
    ) -> Load:
        """Drag under a pad of a body, at a point of its frame, m; N s/m and N m s."""
        i = motion.robot.bodies.index(body)
        force, moment = -c * motion.point(i, pad).v * IN_PLANE, -c_r * motion.rate(i)
        return motion.load(i, pad, force, moment)
