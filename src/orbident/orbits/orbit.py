"""An orbit, and what is around a spacecraft on an arc of it; inertial axes are J2000's.

With the place `r` from the middle of the Earth, its rate `v` and that of the Earth `W`,

    nadir -r    wind v - W x r, against the air, which turns with the Earth
"""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.orbits.earth import AXIS, TURN, Vectors, sunlit, to_the_sun
from orbident.orbits.elements import Elements
from orbident.orbits.ephemeris import Ephemeris
from orbident.orbits.magnetic_field import dipole_field, reference_field

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
