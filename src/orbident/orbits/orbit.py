"""An orbit, and what is around a spacecraft on an arc of it; inertial axes are J2000's.

With the place `r` from the middle of the Earth, its rate `v` and that of the Earth `W`,

    nadir -r    wind v - W x r, against the air, which turns with the Earth

An orbit may be given by its elements, about an Earth with J2. With `p = a (1 - e^2)`,
the true anomaly `f`, and unit vectors up and, across it, ahead,

    r = p / (1 + e cos f) up,   v = sqrt(mu / p) (e sin f up + (1 + e cos f) ahead)

at the epoch, and from there on

    r'' = -mu r / R^3 + 3/2 J2 mu R_E^2 / R^5 ((5 z^2 / R^2 - 1) r - 2 z e_z).

It is integrated: elements of a place and velocity (osculating) are then exact, and
what J2 does within an orbit, up to 10 km, is there. Or by states over time, from a
CCSDS Orbit Ephemeris Message (OEM).
"""

import warnings
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import listed
from orbident.files.text import read_text
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

FRAMES = ("EME2000", "J2000", "GCRF", "ICRF")
"""Axes that are those of J2000, within 0.1 microradians."""

TIMES = ("UTC", "TAI", "TT")

NEAR = 0.7
"""rad: cubics through states that are farther apart around the Earth are wrong by more
than a thousandth of its distance."""

GROUND = R_E - 21.4e3
"""m: the radius of the Earth at its poles, the least there is."""


@dataclass(frozen=True, eq=False)
class Ephemeris:
    """States over time; J2000 axes."""

    t: Float[np.ndarray, " states"]
    """Seconds after the epoch, increasing."""
    states: Float[np.ndarray, "states 6"]
    """Places, m, and velocities, m/s."""
    source: str
    """The file's name, for messages."""
    text: str = ""
    """The file's text, so that a result can keep what it was made from."""

    def check_covers(self, start: float, end: float) -> None:
        """Refuse times of which nothing is known.

        Raises:
            InputError: so, or states between them are too far apart.
        """
        t = self.t
        if start < t[0] or end > t[-1]:
            raise InputError(
                f"{self.source}: has states from t = {t[0]:.6g} to {t[-1]:.6g} s after "
                f"the epoch, and the recording is from {start:.6g} to {end:.6g} s; "
                "give an OEM that covers it, or correct the epoch"
            )
        up = self.states[:, :3] / np.linalg.norm(self.states[:, :3], axis=1)[:, None]
        apart = np.arccos(np.clip(np.sum(up[1:] * up[:-1], axis=1), -1, 1))
        wide = np.flatnonzero((apart > NEAR) & (t[1:] > start) & (t[:-1] < end))
        if wide.size:
            k = wide[0]
            raise InputError(
                f"{self.source}: has no state between t = {t[k]:.6g} and "
                f"{t[k + 1]:.6g} s after the epoch, {np.degrees(apart[k]):.0f} degrees "
                f"of the orbit; give at least one in {np.degrees(NEAR):.0f} degrees"
            )


def read_oem(path: Path, epoch: datetime) -> Ephemeris:
    """The states of an OEM, a file of KVN or XML; the epoch is `t = 0`.

    Raises:
        InputError: the file is no OEM, or its frame, centre or time system is another.
        MissingLibraryError: oem is not installed.
    """
    text = read_text(path)
    with extra("orbit", "reading an OEM"):
        from astropy.time import Time
        from oem import OrbitEphemerisMessage
    try:
        with warnings.catch_warnings():
            # Of time systems that astropy does not know: refused below.
            warnings.simplefilter("ignore")
            message = OrbitEphemerisMessage.open(path)
            for segment in message:
                _check(path, segment.metadata)
            zero = Time(epoch, scale="utc")
            states = message.states
            t = np.array([(state.epoch - zero).sec for state in states])
            x = np.array([[*state.position, *state.velocity] for state in states])
    except InputError:
        raise
    except Exception as error:
        # The library raises whatever a part of the file that it cannot read causes.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: no valid OEM: {reason}; correct it") from None
    t, which = np.unique(t, return_index=True)
    return _checked(Ephemeris(t, 1e3 * x.reshape(-1, 6)[which], str(path), text))


def _check(path: Path, metadata: Any) -> None:
    for key, accepted in (
        ("CENTER_NAME", ("EARTH",)),
        ("REF_FRAME", FRAMES),
        ("TIME_SYSTEM", TIMES),
    ):
        found = str(metadata[key])
        if found.upper() not in accepted:
            raise InputError(
                f"{path}: {key}: found '{found}'; give an OEM with one of "
                f"{listed(accepted)}"
            )


def _checked(found: Ephemeris) -> Ephemeris:
    if found.t.size < 2 or not np.isfinite(found.states).all():
        raise InputError(
            f"{found.source}: has {found.t.size} states; give two or more, all finite"
        )
    least = float(np.linalg.norm(found.states[:, :3], axis=1).min())
    if least < GROUND:
        raise InputError(
            f"{found.source}: found a place {least / 1e3:.6g} km from the middle of "
            "the Earth: an orbit below the ground; give kilometres, as an OEM has them"
        )
    return found


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
        """Places, m, and velocities, m/s, `t` s after the epoch, which increase."""
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

    def position(self, t: Float[np.ndarray, " n"]) -> Vectors:
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
        return sunlit(self.position(t), sun)[:, None] * sun

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

        r = self.position(self.grid)
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
        grid = np.unique(np.clip(grid, t[0], t[-1]))
    else:
        t, x = grid, orbit.motion.states(grid)
    from scipy.interpolate import CubicHermiteSpline

    return Arc(CubicHermiteSpline(t, x[:, :3], x[:, 3:]), grid, orbit.epoch)
