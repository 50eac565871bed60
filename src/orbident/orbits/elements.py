"""An orbit by its elements, about an Earth with J2.

With `p = a (1 - e^2)`, the true anomaly `f`, and unit vectors up and, across it, ahead,

    r = p / (1 + e cos f) up,   v = sqrt(mu / p) (e sin f up + (1 + e cos f) ahead)

at the epoch, and from there on

    r'' = -mu r / R^3 + 3/2 J2 mu R_E^2 / R^5 ((5 z^2 / R^2 - 1) r - 2 z e_z).

It is integrated: elements of a place and velocity (osculating) are then exact, and
what J2 does within an orbit, up to 10 km, is there.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.orbits.earth import AXIS, DAY, J2, MU, R_E

AFAR = 7 * DAY
"""s: the drag of some days moves a low orbit by degrees, which no elements know: 100 m
a day of height lost are 0.05 rad along the orbit after a week."""

EXACT = 1e-11
"""Relative, of a step's place and velocity: centimetres after an orbit."""

NOTHING = 1e-6
"""m and m/s: what crosses zero need not be known better."""


@dataclass(frozen=True)
class Elements:
    """Osculating elements at the epoch; J2000 axes."""

    semi_major_axis: float
    """m."""
    inclination: float
    """rad."""
    eccentricity: float = 0.0
    node: float = 0.0
    """Angle of the ascending node from inertial x, rad."""
    perigee: float = 0.0
    """Argument of perigee: its angle from the ascending node, rad."""
    anomaly: float = 0.0
    """True anomaly: the angle from the perigee, rad."""

    def state(self) -> Float[np.ndarray, "6"]:
        """Place, m, and velocity, m/s, at the epoch."""
        e, f = self.eccentricity, self.anomaly
        p = self.semi_major_axis * (1 - e**2)
        # Late, as in `states`: it takes long to load, and few robots are in orbit.
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_euler("ZXZ", [self.node, self.inclination, self.perigee])
        up = turn.apply([np.cos(f), np.sin(f), 0.0])
        ahead = turn.apply([-np.sin(f), np.cos(f), 0.0])
        slow = np.sqrt(MU / p)
        r = p / (1 + e * np.cos(f)) * up
        v = slow * (e * np.sin(f) * up + (1 + e * np.cos(f)) * ahead)
        return np.concatenate([r, v])

    def check_covers(self, start: float, end: float) -> None:
        """Refuse times that are too far from the epoch.

        Raises:
            InputError: that is more than a week away.
        """
        far = max(start, end, key=abs)
        if abs(far) > AFAR:
            raise InputError(
                f"orbit: t = {far:.6g} s is {abs(far) / DAY:.0f} days from its epoch, "
                "and elements hold for a week: times of a recording are seconds after "
                "the epoch; give elements and an epoch near them"
            )

    def states(self, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 6"]:
        """Places, m, and velocities, m/s.

        Args:
            t: seconds after the epoch, increasing.
        """
        from scipy.integrate import solve_ivp

        x = np.tile(self.state(), (t.size, 1))
        for rows in (np.flatnonzero(t < 0)[::-1], np.flatnonzero(t > 0)):
            if rows.size:
                x[rows] = solve_ivp(
                    _rate,
                    (0.0, t[rows[-1]]),
                    self.state(),
                    "DOP853",
                    t_eval=t[rows],
                    rtol=EXACT,
                    atol=NOTHING,
                ).y.T
        return x


def _rate(_: float, x: Float[np.ndarray, "6"]) -> Float[np.ndarray, "6"]:
    r, v = x[:3], x[3:]
    R, z = np.linalg.norm(r), r[2]
    oblate = 1.5 * J2 * MU * R_E**2 / R**5
    a = (oblate * (5 * z**2 / R**2 - 1) - MU / R**3) * r - 2 * oblate * z * AXIS
    return np.concatenate([v, a])
