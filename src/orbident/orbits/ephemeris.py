"""An orbit by states over time, from a CCSDS Orbit Ephemeris Message (OEM)."""

import warnings
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import listed
from orbident.files.text import read_text
from orbident.orbits.earth import R_E

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
    """The states of an OEM.

    Args:
        path: of the file, KVN or XML.
        epoch: the time at t = 0.

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
