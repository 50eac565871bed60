"""What may act from outside changes both momenta along a motion.

With `F`, `tau` (about S), the pull `a` and the push `b` in inertial axes,

    d h_cm = int tau - R r_cm x F dt,    d v_cm = int F / M + a + b dt

and an accelerometer feels no pull. Each agent's columns are those of the estimators, at
its deviation beforehand, along the present motion.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.agent import Disturbance
from orbident.environment.agents import disturbances
from orbident.environment.motion import PointMotion, RobotMotion, by_step
from orbident.environment.worlds import scale_of, what_may_act
from orbident.excitation.floating import NodalMotion
from orbident.estimation.output_error.followed import integral
from orbident.model.rotations import rotate


class OutsideChanges(NamedTuple):
    """Changes of the momenta, inertial axes, of a deviation of each number."""

    h: Float[np.ndarray, "n 3 numbers"]
    """N m s."""
    v: Float[np.ndarray, "n 3 numbers"]
    """m/s."""
    felt: Float[np.ndarray, "n 3 numbers"]
    """The part of `v` that an accelerometer feels."""


def outside_changes(motion: NodalMotion) -> OutsideChanges:
    """Of all that may act on a motion at an odd number of nodes."""
    at = robot_motion(motion)
    every = [each for each in disturbances(at) if each.std]
    none = np.zeros((len(at.t), 3, len(every)))
    if not every:
        return OutsideChanges(none, none, none)
    torque, force, pull, push = (
        np.stack([each.std * each.effect[k] for each in every], axis=-1)
        for k in (1, 0, 2, 3)
    )
    r = by_step(rotate(motion.R, motion.r_cm))
    h = integral(at.t, torque - np.cross(r[..., None], force, axis=2))
    felt = integral(at.t, force / motion.craft.robot.mass + push)
    return OutsideChanges(h, felt + integral(at.t, pull), felt)


def robot_motion(motion: NodalMotion) -> RobotMotion:
    """The motion as agents know it, from S at the start."""
    craft = motion.craft
    t = motion.dt * np.arange(len(motion.w))
    phi = craft.sets.phi(craft.robot.theta)
    v = np.zeros((len(t), 3))
    v[:, craft.sets.regressors.velocity_axes] = motion.W @ phi
    v = rotate(motion.R, v)
    v_cm = craft.velocity - v[0]
    r_cm = rotate(motion.R, motion.r_cm)
    S = PointMotion(np.outer(t, v_cm) + r_cm[0] - r_cm, v + v_cm)
    v = S.v
    robot = craft.robot
    scale = scale_of(robot, t, motion.qd_rw, motion.w, v)
    return RobotMotion(
        robot, t, motion.q, motion.qd, motion.R, motion.w, S,
        allowed=what_may_act(robot, scale),
    )
