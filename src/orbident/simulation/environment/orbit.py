"""A circular orbit about an Earth with J2; inertial z is the Earth's axis.

With the argument of latitude u, the inclination i, the ascending node W and
`k = 3/2 J2 (R_E / R)^2`,

    n = sqrt(mu / R^3),   u' = n (1 + k (4 cos^2 i - 1)),   W' = -n k cos i.

The field of the Earth is that of a dipole along its axis.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.simulation.environment.moving import Vectors
from orbident.trajectories.environment import Orbit

MU = 3.986004418e14
"""m^3/s^2."""
R_E = 6378137.0
"""Radius of the Earth at the equator, m."""
J2 = 1.08262668e-3
DAY = np.array([0.0, 0.0, 7.2921159e-5])
"""The rate of the Earth and of its air, rad/s."""
FIELD = 2.98e-5
"""Magnetic field at the equator, on the ground, T."""
AXIS = np.array([0.0, 0.0, 1.0])


class Place(NamedTuple):
    """Where the spacecraft is at some times; inertial axes."""

    up: Vectors
    """Unit vectors away from the Earth."""
    R: float
    """Distance from the middle of the Earth, m."""
    v: Vectors
    """m/s."""

    @property
    def wind(self) -> Vectors:
        """The velocity relative to the air, which turns with the Earth, m/s."""
        return self.v - np.cross(DAY, self.R * self.up)

    @property
    def field(self) -> Vectors:
        """The magnetic field, T."""
        along = self.up @ AXIS
        return FIELD * (R_E / self.R) ** 3 * (AXIS - 3 * along[:, None] * self.up)


def place(orbit: Orbit, since: Float[np.ndarray, " n"]) -> Place:
    """Where it is so many seconds after the first row."""
    R, c = R_E + orbit.altitude, np.cos(orbit.inclination)
    n, k = np.sqrt(MU / R**3), 1.5 * J2 * (R_E / R) ** 2
    u_rate, node_rate = n * (1 + k * (4 * c**2 - 1)), -n * k * c
    u, node = orbit.argument + u_rate * since, orbit.node + node_rate * since
    tilted = np.full(since.size, orbit.inclination)
    turn = Rotation.from_euler("ZXZ", np.stack([node, tilted, u], axis=1))
    up = turn.apply([1.0, 0.0, 0.0])
    w = u_rate * turn.apply([0.0, 0.0, 1.0]) + node_rate * AXIS
    return Place(up, R, R * np.cross(w, up))
