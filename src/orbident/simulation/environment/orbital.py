"""What acts in an orbit.

    gravity gradient   F_i = m_i mu / R^3 (3 n n . r_i - r_i)
                       tau_i = 3 mu / R^3 n x I_i n
    air drag           F = -1/2 rho C A |v| v       v relative to the air
    sunlight           F = -P C A s                 s towards the sun
    dipole             tau = m x B

`n` is up, and body `i`, with the inertia `I_i` about its CM, is at `r_i` from the
system CM: the tide moves no CM. Together its moments are `3 mu / R^3 n x D n` (Hughes
1986).

Where Earth, air, sun and field are, as the base of a flying robot sees them.
"""

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.model.rotations import (
    rotate,
    rotate_back,
)
from orbident.orbits.earth import MU
from orbident.orbits.orbit import Arc
from orbident.robot.parameters import inertia_about_com
from orbident.simulation.environment.moving import (
    Load,
    Moving,
    Vectors,
    heavy_bodies,
)
from orbident.trajectories.environment import AirDrag, Environment, SolarPressure

SUNLIGHT = 4.54e-6
"""The pressure of light that is absorbed, at the Earth, N/m^2."""


def tidal_loads(arc: Arc, moving: Moving) -> list[Load]:
    """Tidal force and moment on each body."""
    place, robot = arc.place(moving.t), moving.robot
    R = np.linalg.norm(place, axis=1, keepdims=True)
    tide, n = MU / R**3, place / R
    bodies = heavy_bodies(robot)
    places = [moving.point(i, com).r for i, _, com in bodies]
    r_cm = sum(m * r for (_, m, _), r in zip(bodies, places, strict=True)) / robot.mass
    acting = []
    for (i, m, com), r in zip(bodies, places, strict=True):
        along = np.sum(n * (r - r_cm), axis=1, keepdims=True)
        force = m * tide * (3 * along * n - (r - r_cm))
        R_Wi = moving.R_WB @ moving.poses.R[:, i]
        I_n = rotate(R_Wi, rotate_back(R_Wi, n) @ inertia_about_com(robot.theta[i]))
        acting.append(moving.acting(i, com, force, 3 * tide * np.cross(n, I_n)))
    return acting


def air_drag(given: AirDrag, arc: Arc, moving: Moving) -> list[Load]:
    """Drag at the centre of pressure of the base."""
    v = arc.wind(moving.t)
    size = given.density * given.coefficient * given.area / 2
    force = -size * np.linalg.norm(v, axis=1, keepdims=True) * v
    return [_at(given.centre, force, moving)]


def solar_pressure(given: SolarPressure, arc: Arc | None, moving: Moving) -> list[Load]:
    """The pressure of the sun's light at the centre of pressure of the base."""
    s = sun_of(given, arc, moving.t)
    force = -SUNLIGHT * given.coefficient * given.area * s
    return [_at(given.centre, force, moving)]


def sun_of(
    given: SolarPressure, arc: Arc | None, t: Float[np.ndarray, " n"]
) -> Vectors:
    """The sun's direction, as it is given or by date, in inertial axes.

    Args:
        given: perhaps with the direction.
        arc: otherwise, the orbit.
        t: the times, s.

    Raises:
        InputError: no direction is given, and no orbit with an epoch.
    """
    if given.sun is not None:
        return np.tile(np.array(given.sun) / np.linalg.norm(given.sun), (t.size, 1))
    if arc is None or arc.epoch is None:
        raise InputError(
            "environment: solar_pressure: where the sun is, is not known; add sun: "
            "[x, y, z], or an orbit with an epoch"
        )
    return arc.sun(t)


def dipole(moment: tuple[float, ...], arc: Arc, moving: Moving) -> list[Load]:
    """The torque of the Earth's field on a magnet in the base, base axes, A m^2."""
    m = moving.R_WB @ np.array(moment)
    return [moving.acting(0, np.zeros(3), moment=np.cross(m, arc.field(moving.t)))]


def _at(centre: tuple[float, ...], force: np.ndarray, moving: Moving) -> Load:
    """A force on the base, at a point in the frame of its link."""
    return moving.acting(0, np.array(centre) - moving.robot.feature_point, force)


def seen_from_base(
    environment: Environment,
    arc: Arc | None,
    t: Float[np.ndarray, " rows"],
    R_WB: Float[np.ndarray, "rows 3 3"],
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns `nadir`, `flow`, `field` and `sun`, without noise.

    Args:
        environment: perhaps with the sun's direction.
        arc: of the orbit, if there is one.
        t: the times of the rows, s.
        R_WB: the attitude.
    """
    shown: dict[str, Vectors] = {}
    if arc is not None:
        speed = np.linalg.norm(arc.wind(t), axis=1, keepdims=True)
        shown |= {"nadir": -arc.place(t), "flow": -arc.wind(t) / speed}
        shown["field"] = arc.field(t)
    if environment.solar_pressure is not None:
        shown["sun"] = sun_of(environment.solar_pressure, arc, t)
    return {
        f"{name}.{axis}": column
        for name, vectors in shown.items()
        for axis, column in zip("xyz", rotate_back(R_WB, vectors).T, strict=True)
    }
