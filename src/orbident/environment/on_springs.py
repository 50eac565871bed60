"""What swings inside a robot that its file takes for rigid: a panel, a boom, fuel.

Where it swings faster than the robot moves, its inertia `I` at the frequency `f`
follows the base with a little more than its own momentum. To first order in the square
of the two frequencies' ratio that of the robot is, in base axes,

    h = D w + ... - K d2w/dt2,      K = I / (2 pi f)^2

So it acts on a rigid robot as the torque `d/dt (R_WB K d2w/dt2)`.
"""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from orbident.environment.agent import AXES, Agent, Disturbance
from orbident.environment.motion import RobotMotion
from orbident.model.minimal_sets import conserved_axes
from orbident.model.rotations import rotate
from orbident.recordings.derivatives import HALF, derivatives


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
        t, w = motion.t[::2], motion.w[::2]
        if t.size <= 2 * HALF:
            return
        _, bent = derivatives(t, w)
        axes = conserved_axes(motion.robot)[0]
        for i in axes:
            for k in axes[axes.index(i) :]:
                K = np.zeros((3, 3))
                K[i, k] = K[k, i] = 1.0
                momentum = rotate(motion.R_WB[::2], bent @ K)
                torque = CubicSpline(t, momentum)(motion.t, 1)
                name = f"{AXES[i]}{AXES[k]}"
                yield self.column(name, motion.turning(torque), positive=i == k)
