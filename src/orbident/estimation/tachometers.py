"""What noise of measured wheel speeds does to the base rate that they predict."""

import numpy as np
from jaxtyping import Float

from orbident.model.inertia import inertia_at
from orbident.model.minimal_sets import conserved_axes
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.description import Robot


def momentum_noise(robot: Robot) -> Float[np.ndarray, "3 wheels"]:
    """A root of the covariance of `h_rw`, N m s, by the declared tachometers."""
    wheels = robot.sensors.wheels
    return wheels_of(robot).A_rw * ((wheels and wheels.tachometer) or 0.0)


def rate_noise(robot: Robot) -> float:
    """Std of the predicted base rate, rad/s: `dw = -D^-1 dh_rw` (Eq. 3).

    Root mean square of the axes about which momentum is conserved, with the nominal
    inertia at zero joint positions.
    """
    axes = list(conserved_axes(robot)[0])
    D = inertia_at(robot, np.zeros(len(robot.joints))).D[np.ix_(axes, axes)]
    dw = np.linalg.solve(D, momentum_noise(robot)[axes])
    return float(np.linalg.norm(dw) / np.sqrt(len(axes)))
