"""The total mass by several routes: which count, and whether they agree."""

import math
from collections.abc import Iterator

import numpy as np

from orbident.estimation.checks import Check, Level
from orbident.estimation.quantities import Quantity

BURN = "Eq. 40"
"""The mass by a thruster burn, among others."""

SURE = 0.1
"""A route whose deviation is beyond this part of the mass gives no mass."""

DISAGREE = 5.0
"""Combined deviations by which two masses differ that cannot both be right,"""

MATTERS = 0.03
"""and this part of the mass: by less, the other route is in doubt, not the result."""

WHITE_ONLY = (
    "use the first: the deviations of Eq. 32 count white noise only, so they are too "
    "narrow where encoders or a drift add to it"
)

TIMES = 3.0
"""So many times the nominal mass is no error of a CAD model."""

WHEEL_UNITS = {
    "degrees per second": 180 / math.pi,
    "turns per minute": 30 / math.pi,
    "turns per second": 0.5 / math.pi,
}
"""What a speed of 1 rad/s is in other units: pi and M are so many times too large where
wheel speeds in them are taken for rad/s."""

NEAR = 1.5
"""Times that an identified mass may be off a unit's factor: CAD values are hardly
further off."""


def is_a_mass(value: float, std: float, M: Quantity) -> bool:
    """Whether a route to the mass gives one: its deviation is a tenth of it at most.

    Args:
        value: of this route, kg.
        std: its deviation.
        M: the method's own mass, which says what a tenth is where it is determined.
    """
    whole = M.value if np.isfinite(M.value) else value
    return bool(std <= SURE * abs(whole))


def sigmas_apart(one: Quantity, other: Quantity) -> float:
    """The difference over its deviation, as if the two were independent."""
    std = float(np.hypot(one.std, other.std))
    return (one.value - other.value) / std if std > 0 else float("nan")


def agreement_of_routes(masses: dict[str, Quantity]) -> Iterator[Check]:
    """Whether the last route's mass is one of the others'.

    The statistic is how far beyond both limits, of sigmas and of percent, the worst is.
    Beyond the limit of sigmas alone the result stands, and the remedy says which mass
    to use.
    """
    *others, (route, M) = masses.items()
    if not others:
        return
    apart = {name: abs(sigmas_apart(value, M)) for name, value in others}
    part = {name: abs(value.value / M.value - 1) for name, value in others}
    # Both are to be broken.
    over = {name: min(apart[name] / DISAGREE, part[name] / MATTERS) for name in apart}
    far = [name for name in over if over[name] > 1]
    no_chance = far or [name for name in apart if apart[name] > DISAGREE]
    words = [
        f"{value.value:.6g} +- {value.std:.2g} kg by {name} ({apart[name]:.2g} sigmas "
        f"apart, {100 * part[name]:.2g} %)"
        for name, value in others
        if name in no_chance or not no_chance
    ]
    reason = (
        f"mass: {M.value:.6g} +- {M.std:.2g} kg by {route}, "
        f"{'but' if no_chance else 'and'} {', '.join(words)}"
    )
    level: Level = "with care" if far else "trust"
    remedy = ""
    if far:
        remedy = (
            "check the burn's force" if BURN in masses else f"weigh the robot ({BURN})"
        )
        remedy += ", or record a richer motion"
    elif no_chance:
        remedy = "check the burn's force" if BURN in no_chance else WHITE_ONLY
    yield Check("routes to the mass", level, reason, remedy, max(over.values()), 1.0)


def beside_nominal(M: Quantity, nominal: float, wheels: int) -> Iterator[Check]:
    """Whether the mass is far from the nominal one, as it is with a wrong scale.

    Wheels or known thrust alone give the scale, so nothing else in a recording shows
    that wheel speeds are in another unit, or that inertia or thrust is wrong.

    Args:
        M: the identified mass, kg.
        nominal: the mass in the robot file, kg.
        wheels: how many wheels the robot has.
    """
    times = M.value / nominal
    if not (times > TIMES or times < 1 / TIMES):
        return
    units = [
        unit for unit, factor in WHEEL_UNITS.items() if 1 / NEAR < times / factor < NEAR
    ]
    known = "wheel speeds and the wheels' inertia" if wheels else "the thrust"
    yield Check(
        "mass beside the nominal one",
        "with care",
        f"mass: {M.value:.4g} kg is {times:.2g} times the nominal {nominal:.4g} kg, "
        f"and only {'wheels' if wheels else 'thrust'} can say how large pi and M are",
        f"see whether wheel speeds are in {units[0]} and not in rad/s"
        if wheels and units
        else f"check the unit of {known}, unless the robot holds or has lost a load",
        times,
        TIMES,
    )
