"""An orbit, and what is around a spacecraft on an arc of it; inertial axes are J2000's.

With the place `r` from the middle of the Earth, its rate `v` and that of the Earth `W`,

    nadir -r    wind v - W x r, against the air, which turns with the Earth

An orbit may be given by its elements, about an Earth with J2. With `p = a (1 - e^2)`,
the true anomaly `f`, and unit vectors up and, across it, ahead,

    r = p / (1 + e cos f) up,   v = sqrt(mu / p) (e sin f up + (1 + e cos f) ahead)

at the epoch, and from there on

    r'' = -mu r / R^3 + 3/2 J2 mu R_E^2 / R^5 ((5 z^2 / R^2 - 1) r - 2 z e_z).

It is integrated: elements of a place and velocity (osculating) are then exact, and
what J2 does within an orbit, up to 10 km, is there.
"""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.orbits.earth import (
    AXIS,
    DAY,
    J2,
    MU,
    R_E,
    TURN,
    Vectors,
    dipole_field,
    reference_field,
    sunlit,
    to_the_sun,
)
from orbident.orbits.ephemeris import Ephemeris

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


STEP = 10.0
"""s: cubics through so many states are exact to a millimetre, and through the field,
whose shortest waves take some minutes, to a millionth."""

KEPT = 16
"""Arcs that are kept: a recording is looked at many times."""


@dataclass(frozen=True, eq=False)
class Arc:
    """An orbit from one time to another."""

    path: Any
    """The place, m, over seconds after the epoch: a spline of SciPy."""
    grid: Float[np.ndarray, " times"]
    """Times every ten seconds, s, beyond both ends."""
    epoch: datetime | None

    def place(self, t: Float[np.ndarray, " n"]) -> Vectors:
        """From the middle of the Earth, m."""
        return np.asarray(self.path(t))

    def wind(self, t: Float[np.ndarray, " n"]) -> Vectors:
        """The velocity relative to the air, m/s."""
        return np.asarray(self.path(t, 1)) - np.cross(TURN * AXIS, self.path(t))

    def sun(self, t: Float[np.ndarray, " n"]) -> Vectors:
        """The direction to the sun, of length one, shorter where the Earth hides it.

        Raises:
            InputError: the orbit has no epoch.
        """
        if self.epoch is None:
            raise InputError(
                "orbit: where the sun is, is not known without a date; add epoch: to "
                "the orbit"
            )
        sun = to_the_sun(self.epoch, t)
        return sunlit(self.place(t), sun)[:, None] * sun

    def field(self, t: Float[np.ndarray, " n"]) -> Vectors:
        """The magnetic field, T: IGRF's, or that of a dipole without an epoch.

        Raises:
            InputError: the epoch is not one of the model.
            MissingLibraryError: there is an epoch, and ppigrf is not installed.
        """
        return np.asarray(self._field(t))

    @cached_property
    def _field(self) -> Any:
        # Late, as in `_arc`: it takes long to load, and few robots are in orbit.
        from scipy.interpolate import CubicSpline

        r = self.place(self.grid)
        if self.epoch is None:
            return CubicSpline(self.grid, dipole_field(r))
        return CubicSpline(self.grid, reference_field(self.epoch, self.grid, r))


@dataclass(frozen=True, eq=False)
class Orbit:
    """Where a spacecraft is at any time."""

    motion: Elements | Ephemeris
    epoch: datetime | None = None
    """The time at t = 0; without it sun and field of the date are not known."""

    def arc(self, start: float, end: float) -> Arc:
        """The orbit between two times, seconds after the epoch.

        Raises:
            InputError: the times are too far from the epoch, or not in the ephemeris.
        """
        return _arc(self, start, end)


@lru_cache(maxsize=KEPT)
def _arc(orbit: Orbit, start: float, end: float) -> Arc:
    # First: there are as many states as the time between is long.
    orbit.motion.check_covers(start, end)
    grid = STEP * np.arange(np.floor(start / STEP) - 1, np.ceil(end / STEP) + 2)
    if isinstance(orbit.motion, Ephemeris):
        t, x = orbit.motion.t, orbit.motion.states
        grid = np.clip(grid, t[0], t[-1])
        grid = np.unique(grid)
    else:
        t, x = grid, orbit.motion.states(grid)
    from scipy.interpolate import CubicHermiteSpline

    return Arc(CubicHermiteSpline(t, x[:, :3], x[:, 3:]), grid, orbit.epoch)
